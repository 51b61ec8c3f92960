"""prefect.yaml is checked before anything is served."""

from pathlib import Path

import pytest

from nodes.errors import BadInput
from pipelines.deployments import load_deployments

ROOT = Path(__file__).resolve().parent.parent.parent
ENTRY = "deployments: [{name: a, entrypoint: 'pipelines/flows.py:run_cases', schedules: [%s]%s}]"


def written(folder: Path, schedule: str, more: str = "") -> Path:
    path = folder / "prefect.yaml"
    path.write_text(ENTRY % (schedule, more))
    return path


def test_the_projects_own_file_has_a_cron_and_an_interval_schedule() -> None:
    schedules = [s for d in load_deployments(ROOT / "prefect.yaml") for s in d.schedules]
    assert any(schedule.cron for schedule in schedules)
    assert any(schedule.interval for schedule in schedules)


def test_a_schedule_is_read(tmp_path: Path) -> None:
    (deployment,) = load_deployments(written(tmp_path, "{interval: 15}", ", concurrency_limit: 2"))
    assert (deployment.schedules[0].interval, deployment.concurrency_limit) == (15, 2)


@pytest.mark.parametrize(
    ("schedule", "more", "told"),
    [
        ("{intervall: 15}", "", "unknown key schedules.0.intervall"),
        ("{interval: abc}", "", "interval"),
        ("{interval: -1}", "", "greater than or equal to 0"),
        ("{}", "", "either cron or interval"),
        ("{cron: '0 3 * * *', interval: 9}", "", "either cron or interval"),
        ("{interval: 9}", ", schedule: x", "did you mean schedules?"),
        ("{interval: 9}", ", parameters: {case: [x]}", "unknown key parameters.case"),
    ],
)
def test_a_mistake_is_refused(tmp_path: Path, schedule: str, more: str, told: str) -> None:
    with pytest.raises(BadInput) as refusal:
        load_deployments(written(tmp_path, schedule, more))
    assert told in str(refusal.value)
