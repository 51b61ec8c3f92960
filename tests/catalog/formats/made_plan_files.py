"""Placed setups, motions, trees and plans of plain and of random numbers, for tests of formats."""

from dataclasses import fields, is_dataclass

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from nodes.mechanics.robots import CrispConfiguration, CrispSetup
from nodes.mechanics.shapes import Figure
from nodes.planning.artefacts import CheckedPlan, CrispMotion, CrispTree, MotionPlan, PlacedSetup
from tests.catalog.formats.hostile import NAMES, ORIGINS, TEXTS
from tests.nodes.mechanics.made_robots import crisp

NUMBERS = st.floats(-1e3, 1e3)
FIGURES = st.lists(st.builds(Figure, TEXTS, NUMBERS, TEXTS, TEXTS), max_size=2).map(tuple)
NEEDLES = 3


def assert_equal(one: object, other: object) -> None:
    """Field by field, arrays in type, shape and every bit."""
    assert type(one) is type(other)
    if is_dataclass(one):
        for field in fields(one):
            assert_equal(getattr(one, field.name), getattr(other, field.name))
    elif isinstance(one, np.ndarray):
        assert (one.dtype, one.shape) == (other.dtype, other.shape)
        assert one.tobytes() == other.tobytes()
    elif isinstance(one, tuple):
        assert len(one) == len(other)
        for each, its in zip(one, other, strict=True):
            assert_equal(each, its)
    else:
        assert one == other


def array(*shape: int, elements: st.SearchStrategy = NUMBERS) -> st.SearchStrategy[np.ndarray]:
    return hnp.arrays(float, shape, elements=elements)


def whole(*shape: int) -> st.SearchStrategy[np.ndarray]:
    return hnp.arrays(np.int64, shape, elements=st.integers(-1, 2**40))


def turns(count: int, needles: int = NEEDLES) -> st.SearchStrategy[np.ndarray]:
    def turn(vectors: np.ndarray) -> np.ndarray:
        return Rotation.from_rotvec(vectors).as_matrix().reshape(count, needles, 3, 3)

    return array(count * needles, 3, elements=st.floats(-3, 3)).map(turn)


@st.composite
def placed_setups(draw: st.DrawFn) -> PlacedSetup:
    made = crisp()
    setup = CrispSetup(made.needles, draw(array(NEEDLES, 3)) + 5000 * np.eye(3), made.snares,
                       draw(st.floats(1, 179)), draw(ORIGINS))  # fmt: skip
    lengths = draw(array(NEEDLES, elements=st.floats(200, 300)))
    frames = draw(turns(1))[0]
    return PlacedSetup(
        draw(NAMES), setup, CrispConfiguration(frames, lengths), frames[:, :, 2],
        draw(array(NEEDLES, elements=st.floats(0, 3))), lengths / 2, lengths * 2,
        draw(st.sampled_from([(), (4, 0, 11)])),
    )  # fmt: skip


@st.composite
def motions(draw: st.DrawFn, steps: int) -> CrispMotion:
    poses = np.tile(np.eye(4), (steps, 1, 1))
    poses[:, :3] = draw(array(steps, 3, 4))
    return CrispMotion(
        draw(turns(steps)),
        draw(array(steps, NEEDLES, elements=st.floats(200, 300))),
        draw(array(steps, NEEDLES, 6, elements=st.floats(-1e-3, 1e-3))),
        poses,
    )


@st.composite
def plans(draw: st.DrawFn) -> MotionPlan:
    steps = draw(st.integers(0, 3))
    return MotionPlan(
        draw(NAMES), draw(array(3)), draw(whole(draw(st.integers(0, 2)), 3)),
        draw(placed_setups()), "planned" if steps else draw(st.sampled_from(STATUSES)),
        draw(TEXTS), draw(motions(steps)), draw(FIGURES),
    )  # fmt: skip


STATUSES = ["not seen", "unreachable"]


@st.composite
def checked_plans(draw: st.DrawFn) -> CheckedPlan:
    proposed = draw(plans())
    steps = len(proposed.motion.lengths_mm)
    passed = bool(steps) and draw(st.booleans())
    margins = draw(array(steps, elements=NUMBERS | st.just(np.nan)))
    failures = () if passed else tuple(draw(st.lists(TEXTS, max_size=2)))
    return CheckedPlan(proposed, passed, failures, draw(FIGURES), draw(array(steps)), margins)


@st.composite
def trees(draw: st.DrawFn) -> CrispTree:
    count = draw(st.integers(1, 4))
    placed = draw(placed_setups())
    parents = np.array([-1, *(draw(st.integers(0, node - 1)) for node in range(1, count))])
    return CrispTree(
        placed, parents, draw(array(count, NEEDLES, 4)), draw(array(count, NEEDLES)),
        draw(whole(count)), draw(array(count, NEEDLES, 6)), draw(array(count, 3)),
        draw(array(count, 3)), draw(array(count)), draw(whole(count)),
        draw(whole(draw(st.integers(0, 3)))), "node limit", draw(FIGURES),
    )  # fmt: skip


def straight_motion(steps: int = 3) -> CrispMotion:
    """All needles straight along +z, the tool inserted by 1 mm a step."""
    frames = np.tile(np.eye(3), (steps, NEEDLES, 1, 1))
    lengths = np.tile([200.0, 105, 105], (steps, 1))
    lengths[:, 0] += np.arange(steps)
    poses = np.tile(np.eye(4), (steps, 1, 1))
    poses[:, 2, 3] = lengths[:, 0]
    return CrispMotion(frames, lengths, np.zeros((steps, NEEDLES, 6)), poses)


def straight_plan(steps: int = 3) -> MotionPlan:
    motion = straight_motion(steps)
    frames, lengths = np.tile(np.eye(3), (NEEDLES, 1, 1)), np.array([200.0, 105, 105])
    placed = PlacedSetup(
        "setup A", crisp(), CrispConfiguration(frames, lengths), frames[:, :, 2],
        np.full(NEEDLES, 1.0), lengths / 2, lengths * 2,
    )  # fmt: skip
    return MotionPlan("goal 1", np.array([1.0, 2, 300]), np.array([[1, 2, 3]]), placed,
                      "planned" if steps else "unreachable", "", motion, ())  # fmt: skip
