"""Robots followed along edges: published cases, the slow oracle, and what holds for all."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.mechanics_cases import random_crisp as crisp_of
from nodes.errors import BadInput
from nodes.mechanics.crisp_edges import BEYOND, NO_SOLUTION, NOT_CONVERGED, SOLVED, CrispEdges
from nodes.mechanics.follow_crisp_edges import follow_crisp_edges
from nodes.mechanics.robots import CrispConfiguration
from nodes.mechanics.solve_crisp import solve_crisp
from tests.nodes.mechanics import oracle_crisp
from tests.nodes.mechanics.crisp_reference import CASES, case_robot, case_wrenches, parameters
from tests.nodes.mechanics.made_crisp_edges import PARAMETERS, edges_from
from tests.nodes.mechanics.made_robots import crisp
from tests.nodes.mechanics.oracle_crisp_rods import robot_of

STRAIGHT = [
    "rigid1_0", "rigid1_2", "rigid1_4", "relaxed1_1", "relaxed1_3", "rigid2_0", "rigid2_2",
    "relaxed2_paper_1", "relaxed2_1", "sym2_relaxed_same_s",
]  # fmt: skip
FINE = PARAMETERS.model_copy(update={"tolerance_mm": 1e-8, "integration_error_mm": 1e-9})


def start_of(name, measured_from="tip"):
    """Return setup, frames, lengths and wrenches of a published case."""
    setup, configuration = case_robot(CASES[name], measured_from)
    frames, lengths = configuration.patient_from_entry, configuration.lengths_mm
    return setup, frames, lengths, case_wrenches(CASES[name])


def follow_from(name, parameters=PARAMETERS, **options):
    setup, frames, lengths, wrenches = start_of(name)
    edges = edges_from(frames, lengths, wrenches, **options)
    return setup, edges, follow_crisp_edges(setup, edges, parameters)


@pytest.mark.parametrize("name", STRAIGHT)
def test_published_cases_are_solved_from_nearby(name):
    setup, frames, lengths, wrenches = start_of(name)
    parameters = FINE
    edges = edges_from(frames, lengths, 0.9 * wrenches)
    tracks = follow_crisp_edges(setup, edges, parameters)
    case = CASES[name]["out"]
    assert tracks.status.tolist() == [[SOLVED]]
    assert tracks.residual_mm[0, 0] < parameters.tolerance_mm
    camera = tracks.patient_from_camera[0, 0]
    assert np.abs(camera[:3, 3] - case["tip_p"]).max() < 1e-6
    assert np.abs(camera[:3, :3] - case["tip_R"]).max() < 1e-8
    found = tracks.wrenches[0, 0]
    for part in (slice(0, 3), slice(3, 6)):
        assert np.abs(found - wrenches)[:, part].max() < 1e-6 * np.abs(wrenches[:, part]).max()


@pytest.mark.parametrize("name", ["rigid1_0", "relaxed1_1", "rigid2_0", "relaxed2_paper_1"])
def test_needles_that_are_not_bent_yet_lead_to_a_solution(name):
    setup, frames, lengths, _ = start_of(name)
    tracks = follow_crisp_edges(setup, edges_from(frames, lengths), PARAMETERS)
    assert tracks.status[0, 0] == SOLVED


@pytest.mark.parametrize("name", ["relaxed1_1", "rigid2_0", "relaxed2_1"])
def test_ends_of_edges_are_what_the_oracle_finds(name):
    setup, edges, tracks = follow_from(name, count=2, steps=12)
    assert (tracks.status == SOLVED).all()
    for edge in range(2):
        end = CrispConfiguration(edges.ends[edge], edges.end_lengths_mm[edge])
        found = tracks.wrenches[edge, -1]
        slow = oracle_crisp.polish(robot_of(setup, end), found)
        assert np.abs(tracks.patient_from_camera[edge, -1, :3, 3] - slow.tip_point).max() < 1e-6
        assert np.abs(tracks.patient_from_camera[edge, -1, :3, :3] - slow.tip_frame).max() < 1e-8
        assert np.abs(found - slow.base_wrenches).max() < 1e-6 * np.abs(found).max()


@pytest.mark.parametrize("name", ["rigid1_2", "relaxed2_paper_1"])
def test_edges_there_and_back_end_where_they_began(name):
    setup, edges, there = follow_from(name, count=3, steps=15)
    back = CrispEdges(
        edges.ends, edges.starts, edges.end_lengths_mm, edges.start_lengths_mm,
        there.wrenches[:, -1], edges.steps,
    )  # fmt: skip
    again = follow_crisp_edges(setup, back, PARAMETERS)
    apart = again.patient_from_camera[:, ::-1] - there.patient_from_camera
    assert (again.status == SOLVED).all()
    assert np.abs(apart).max() < 1e-6


def test_a_robot_is_the_same_alone_and_among_others():
    setup, edges, tracks = follow_from("relaxed1_1", count=21, steps=6)
    fields = {key: value[17:18] for key, value in vars(edges).items()}
    alone = follow_crisp_edges(setup, CrispEdges(**fields), PARAMETERS)
    apart = alone.patient_from_camera[0] - tracks.patient_from_camera[17]
    assert np.abs(apart).max() < 1e-6


def test_same_input_gives_the_same_bytes():
    one, two = (follow_from("relaxed2_1", count=5, steps=4)[2] for _ in range(2))
    assert one.wrenches.tobytes() == two.wrenches.tobytes()
    assert one.patient_from_camera.tobytes() == two.patient_from_camera.tobytes()


def test_edges_of_different_numbers_of_steps_go_together():
    setup, frames, lengths, wrenches = start_of("rigid1_0")
    edges = edges_from(frames, lengths, wrenches, count=3, steps=4)
    edges = replace(edges, steps=np.array([4, 0, 2]))
    tracks = follow_crisp_edges(setup, edges, PARAMETERS)
    assert ((tracks.status == SOLVED).sum(1) == [5, 1, 3]).all()
    assert (tracks.status[1, 1:] == BEYOND).all() and np.isnan(tracks.wrenches[1, 1:]).all()


def test_a_snare_that_gets_too_short_ends_its_edge_and_no_other():
    setup, frames, lengths, wrenches = start_of("relaxed1_1")
    edges = edges_from(frames, lengths, wrenches, count=2, steps=6, step=0.2)
    shorter = edges.end_lengths_mm.copy()
    shorter[1, 1] = lengths[1] / 2
    edges = replace(edges, end_lengths_mm=shorter, steps=np.array([6, 100]))
    tracks = follow_crisp_edges(setup, edges, PARAMETERS)
    assert (tracks.status[0, :7] == SOLVED).all()
    last = (tracks.status[1] == SOLVED).sum()
    assert 0 < last < 100 and tracks.status[1, last] in (NO_SOLUTION, NOT_CONVERGED)
    assert (tracks.status[1, last + 1 :] == BEYOND).all()
    assert np.isnan(tracks.residual_mm[1, last:]).all()


def test_a_snare_shorter_than_the_straight_way_is_refused_before_it_is_solved():
    frames, lengths = np.repeat(np.eye(3)[None], 3, 0), np.array([200.0, 48, 105])
    tracks = follow_crisp_edges(crisp(), edges_from(frames, lengths), PARAMETERS)
    assert tracks.status.tolist() == [[NO_SOLUTION]]


def test_wrenches_at_the_entry_points_balance():
    setup, _, tracks = follow_from("rigid2_2", count=4, steps=5)
    moments, forces = tracks.wrenches[..., :3], tracks.wrenches[..., 3:]
    about = moments + np.cross(setup.entry_points_patient_mm, forces)
    assert np.abs(forces.sum(2)).max() < 1e-9 * np.abs(forces).max()
    assert np.abs(about.sum(2)).max() < 1e-9 * np.abs(about).max()


@pytest.mark.parametrize("name", ["rigid1_4", "relaxed2_1"])
def test_a_robot_that_is_moved_as_a_whole_moves_its_camera_along(name):
    setup, frames, lengths, wrenches = start_of(name)
    turn, shift = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix(), np.array([30.0, -200, 75])
    moved = replace(setup, entry_points_patient_mm=setup.entry_points_patient_mm @ turn.T + shift)
    turned = np.concatenate([wrenches[:, :3] @ turn.T, wrenches[:, 3:] @ turn.T], axis=1)
    here = follow_crisp_edges(setup, edges_from(frames, lengths, wrenches), FINE)
    there = follow_crisp_edges(moved, edges_from(turn @ frames, lengths, turned), FINE)
    camera, wanted = there.patient_from_camera[0, 0], here.patient_from_camera[0, 0]
    assert np.abs(camera[:3, 3] - (turn @ wanted[:3, 3] + shift)).max() < 1e-7
    assert np.abs(camera[:3, :3] - turn @ wanted[:3, :3]).max() < 1e-9


def test_without_snares_the_tool_is_straight():
    setup, frames, lengths, _ = start_of("relaxed1_1")
    lone = replace(
        setup,
        needles=setup.needles[:1],
        snares=(),
        entry_points_patient_mm=setup.entry_points_patient_mm[:1],
    )
    tracks = follow_crisp_edges(lone, edges_from(frames[:1], lengths[:1]), PARAMETERS)
    tip = setup.entry_points_patient_mm[0] + lengths[0] * frames[0, :, 2]
    assert tracks.status.tolist() == [[SOLVED]]
    assert np.abs(tracks.patient_from_camera[0, 0, :3, 3] - tip).max() < 1e-10


def test_needles_that_are_curved_by_themselves_are_refused():
    setup, frames, lengths, wrenches = start_of("precurved1_1")
    with pytest.raises(BadInput, match="straight"):
        follow_crisp_edges(setup, edges_from(frames, lengths, wrenches), PARAMETERS)


def test_a_track_tells_whether_the_wrenches_handed_in_led_to_its_start():
    setup, frames, lengths, wrenches = start_of("relaxed1_1")
    given = follow_crisp_edges(setup, edges_from(frames, lengths, wrenches), PARAMETERS)
    lost = follow_crisp_edges(setup, edges_from(frames, lengths, 1e3 * wrenches), PARAMETERS)
    assert given.from_rest.tolist() == [False] and lost.from_rest.tolist() == [True]
    assert lost.status.tolist() == [[SOLVED]]


@pytest.mark.parametrize("field", ["starts", "end_lengths_mm", "start_wrenches"])
def test_an_edge_that_holds_nan_is_refused_by_its_number(field):
    _, frames, lengths, wrenches = start_of("rigid1_0")
    edges = edges_from(frames, lengths, wrenches, count=3)
    values = np.array(getattr(edges, field))
    values[1, 0] = np.nan
    with pytest.raises(BadInput, match=f"{field} of edge 1"):
        follow_crisp_edges(start_of("rigid1_0")[0], replace(edges, **{field: values}), PARAMETERS)


def test_no_start_found_without_wrenches_is_one_that_the_robot_would_leave():
    """The general path's margin at what is called solved is above 0; some starts are not."""
    counted = 0
    for seed in range(4):
        setup, first = crisp_of(np.random.default_rng(seed), ("relaxed", "relaxed"))
        frames, lengths = first.patient_from_entry, first.lengths_mm * [1.0, 1.25, 1.25]
        edges = edges_from(frames, lengths, count=6, seed=seed, step=8.0)
        edges = replace(edges, starts=edges.ends, start_lengths_mm=edges.end_lengths_mm)
        tracks = follow_crisp_edges(setup, edges, PARAMETERS)
        for edge, status in enumerate(tracks.status[:, 0]):
            if status != SOLVED:
                continue
            configuration = CrispConfiguration(edges.starts[edge], edges.start_lengths_mm[edge])
            found = solve_crisp(
                setup, configuration, parameters(guesses=0), tracks.wrenches[edge, 0]
            )
            assert found.status == "solved" and found.stability_margin > 0
            counted += 1
    assert counted > 10
