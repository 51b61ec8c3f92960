"""What is said of the time that is left."""

from pipelines.progress import Progress, expected_seconds
from pipelines.stage import Stage

STAGES = [Stage(f"x.s{n}", [], [f"o{n}"]) for n in range(3)]


def test_a_stage_takes_as_long_as_last_time_or_as_the_mean_of_the_known() -> None:
    assert expected_seconds(STAGES, {"s0": 2.0, "s2": 4.0}) == {"s0": 2.0, "s1": 3.0, "s2": 4.0}
    assert set(expected_seconds(STAGES, {}).values()) == {1.0}


def test_time_left_falls_as_stages_run_and_never_below_zero(monkeypatch) -> None:
    clock = [0.0]
    monkeypatch.setattr("time.monotonic", lambda: clock[0])
    progress = Progress("case", STAGES, {"s0": 10.0, "s1": 5.0, "s2": 5.0})
    assert progress.left_seconds() == 20
    progress.observe("running", STAGES[0], None)
    clock[0] = 4.0
    assert progress.left_seconds() == 16
    clock[0] = 400.0
    assert 10 <= progress.left_seconds() < 11
