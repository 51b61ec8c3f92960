"""The deployments of prefect.yaml, checked by closed types."""

from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from catalog.validation import validate
from catalog.yaml_file import load_mapping


class _Closed(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Schedule(_Closed):
    """When runs begin: a cron line or an interval."""

    cron: str = Field(default="", description="five fields: minute, hour, day, month, weekday")
    interval: float = Field(default=0.0, ge=0, description="seconds between runs")
    timezone: str = "UTC"

    @model_validator(mode="after")
    def _one_of_both(self) -> "Schedule":
        if bool(self.cron) == bool(self.interval):
            raise ValueError("give either cron or interval")
        return self


class FlowParameters(_Closed):
    """What a scheduled run is asked to do; as the arguments of `run_cases`."""

    pipeline: str = ""
    cases: list[str] = []
    settings: list[str] = []


class Deployment(_Closed):
    """One entry of prefect.yaml."""

    name: str
    description: str = ""
    entrypoint: Literal["pipelines/flows.py:run_cases"]
    schedules: list[Schedule]
    parameters: FlowParameters = FlowParameters()
    concurrency_limit: int | None = Field(default=None, ge=1)


class _File(_Closed):
    model_config = ConfigDict(frozen=True, extra="ignore")  # Prefect's own keys stand there, too

    deployments: list[dict]


def load_deployments(path: Path) -> list[Deployment]:
    """Return the deployments of a prefect.yaml.

    Raises
    ------
    BadInput : for an unknown key, a missing one, or a value outside its rule.
    """
    entries = validate(_File, load_mapping(path), path.name).deployments
    return [
        validate(Deployment, entry, f"{path.name}: {entry.get('name', 'deployment')}")
        for entry in entries
    ]
