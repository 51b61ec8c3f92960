from nodes.reporting.colours import PALETTE, colour_names


def test_a_name_keeps_its_colour_in_other_company():
    alone = colour_names(("needle",))
    assert colour_names(("bone", "lungs", "needle"))[2] == alone[0]


def test_unknown_names_differ_while_the_palette_lasts():
    names = tuple(f"part_{n}" for n in range(len(PALETTE)))
    assert len(set(colour_names(names))) == len(PALETTE)


def test_more_names_than_colours_all_get_one():
    colours = colour_names(tuple(f"part_{n}" for n in range(255)))
    assert len(colours) == 255 and set(colours) <= set(PALETTE)
