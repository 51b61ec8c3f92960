"""Labels on the grid of an image: in place, told where they are cut, refused where they miss."""

import numpy as np
import pytest

from nodes.errors import BadInput
from nodes.geometry.grids import Volume
from nodes.geometry.origin import Origin
from nodes.imaging.hand_labels import check_given_labels
from nodes.imaging.place_labels import place_labels
from tests.nodes.imaging.handed_in import block, files, mask_file, place_parameters, steps

SHAPE = (12, 11, 10)
LUNG = block(SHAPE, (2, 10), (2, 9), (2, 8))


def image(matrix, shape=SHAPE) -> Volume:
    return Volume(np.zeros(shape, np.int16), matrix, "HU", Origin("CT"))


def test_nothing_handed_in_gives_no_names_on_the_grid_of_the_image():
    volume = image(steps(0.5, 0.6, 2.0, start=(3, 4, 5)))
    placed = place_labels(files(), volume, place_parameters())
    assert placed.names == () and not placed.voxels.any()
    assert placed.voxels.shape == SHAPE and placed.origin.notices == ()
    np.testing.assert_array_equal(placed.patient_from_index, volume.patient_from_index)


def test_labels_drawn_in_the_image_come_bit_by_bit():
    matrix = steps(-0.5, 0.6, 2.0, start=(3, 4, 5))
    placed = place_labels(files(mask_file("lung", LUNG, matrix)), image(matrix), place_parameters())
    np.testing.assert_array_equal(placed.mask("lung"), LUNG)
    assert placed.origin.notices == ()


def test_placed_labels_fit_what_a_segmentation_asks_of_given_ones():
    volume = image(steps(0.7, 0.8, 1.1, start=(0.2, 0.3, 0.4)))
    for handed in (files(), files(mask_file("lung", LUNG))):
        check_given_labels(volume, place_labels(handed, volume, place_parameters()))


def test_labels_saved_with_other_axes_come_to_the_same_voxels():
    """As NIfTI tools store them: axes in another order and direction, same places."""
    matrix = steps(0.5, 0.6, 2.0, start=(3, 4, 5))
    stored = LUNG[::-1].transpose(2, 0, 1)
    other = matrix[:, [2, 0, 1, 3]]
    other[:3, 1] *= -1
    other[0, 3] += 0.5 * 11
    placed = place_labels(
        files(mask_file("lung", stored, other)), image(matrix), place_parameters()
    )
    np.testing.assert_array_equal(placed.mask("lung"), LUNG)


def test_what_lies_outside_of_the_image_is_told_in_ml():
    """The image ends in the middle of the label: 4 of 8 planes of 7 x 6 voxels are lost."""
    volume = image(np.eye(4), (6, 11, 10))
    placed = place_labels(files(mask_file("lung", LUNG)), volume, place_parameters())
    np.testing.assert_array_equal(placed.mask("lung"), LUNG[:6])
    assert placed.origin.notices == (
        "lung: 0.168 of 0.336 ml lie outside of the image and are cut off",
    )


def test_another_patients_label_map_is_refused_with_both_places():
    handed = files(mask_file("lung", LUNG, steps(1, 1, 1, start=(500, 0, 0))))
    with pytest.raises(BadInput) as caught:
        place_labels(handed, image(np.eye(4)), place_parameters())
    assert "label lung lies at x 501.5 to 509.5, y 1.5 to 8.5, z 1.5 to 7.5" in str(caught.value)
    assert "the image at x -0.5 to 11.5" in str(caught.value)


def test_names_and_order_are_those_of_the_parameters():
    inner = block(SHAPE, (4, 6), (4, 6), (4, 6))
    handed = files(mask_file("a", LUNG), mask_file("b", inner))
    parameters = place_parameters(names={"a": "right_lung"}, order=["b"])
    placed = place_labels(handed, image(np.eye(4)), parameters)
    assert placed.names == ("right_lung", "b")
    np.testing.assert_array_equal(placed.mask("b"), inner)
    np.testing.assert_array_equal(placed.mask("right_lung"), LUNG & ~inner)
