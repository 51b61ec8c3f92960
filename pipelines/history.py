"""What each run of a case made: a folder a run, numbered, with links to its artefacts.

    data/runs/<case>/0007/run.json     what was done
    data/runs/<case>/0007/<dataset>.*  links into the store, one for each artefact
    data/runs/<case>/latest            link to the newest run

Numbers and not times give the order: a clock may be wrong.
"""

import json
import os
from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from catalog.cases import Case
from catalog.memory import recall
from catalog.signatures import hash_files
from catalog.store import StoreFailure
from pipelines.outcomes import Outcome
from pipelines.project import Project

COMPLETE, FAILED, INTERRUPTED = "complete", "failed", "interrupted"

# What a note must hold to be believed; one that a disk or a person spoilt is passed over.
_SHAPE = {
    "status": str,
    "started": str,
    "seconds": float,
    "keys": dict,
    "outputs": dict,
    "published": dict,
    "warnings": list,
}


class History:
    """The runs of one case."""

    def __init__(self, project: Project, case: str) -> None:
        self.project, self.case = project, case
        self.folder = project.runs / case

    def runs(self) -> list[Path]:
        """Return the folders of all runs, newest first."""
        found = (path for path in self.folder.glob("[0-9]*") if path.name.isdigit())
        return sorted(found, key=lambda path: int(path.name), reverse=True)

    def latest(self) -> dict[str, Any]:
        """Return what the newest run tells of itself; empty where there is none."""
        return next(self._told(), {})

    def last_key(self, stage: str) -> str:
        """Return the key under which a stage last ran for this case, "" if it never did."""
        for told in self._told():
            if key := told["keys"].get(stage):
                return key
        return ""

    def seconds(self) -> dict[str, float]:
        """Return how long each stage took when it was last computed."""
        keys = {
            name: key for told in reversed(list(self._told())) for name, key in told["keys"].items()
        }
        records = {name: self.project.store.read_record(key) for name, key in keys.items()}
        return {name: record.seconds for name, record in records.items() if record}

    def outputs(self) -> dict[str, str]:
        """Return dataset -> content hash of what the newest run, or one before it, made of each."""
        merged: dict[str, str] = {}
        for told in self._told():
            merged = {**told["outputs"], **merged}
        return merged

    def is_current(self, keys: Mapping[str, str]) -> bool:
        """Return whether the newest run ended well, made just this, and its pages stand."""
        told = self.latest()
        return (
            told.get("status") == COMPLETE
            and {**told["keys"], **keys} == told["keys"]
            and os.path.realpath(self.folder / "latest") == str(self.runs()[0].resolve())
            and told["published"].keys() == set(self._places(told["outputs"]).values())
            and all(
                self.project.store.signatures.hash_path(self.project.root / place) == content
                for place, content in told["published"].items()
            )
        )

    def _places(self, outputs: Mapping[str, str]) -> dict[str, str]:
        """Return dataset -> place, relative to the project, of what is to be published."""
        places = {name: self.project.catalog[name].place for name in outputs}
        return {
            name: place.format(case=self.case)
            for name, place in places.items()
            if place.startswith("reports/")
        }

    def keep(
        self, case: Case, started: str, outcomes: Collection[Outcome], status: str, error: str = ""
    ) -> Path:
        """Note a run, link its artefacts and publish its pages; return its folder."""
        outputs = {k: v for outcome in outcomes for k, v in outcome.record.outputs.items()}
        told = {
            "case": self.case,
            "title": case.title,
            "pipeline": case.pipeline,
            "status": status,
            "error": error,
            "started": started,
            "seconds": round(
                0.0 + sum(o.record.seconds for o in outcomes if o.status == "computed"), 3
            ),
            "stages": {o.stage.name: o.status for o in outcomes},
            "keys": {o.stage.name: o.record.key for o in outcomes},
            "outputs": outputs,
            "warnings": self._warnings(outputs),
            "published": self._publish(outputs),
        }
        with self.project.store.scratch() as scratch:
            (scratch / "run").mkdir()
            for name, content in outputs.items():
                self._link(scratch / "run", name, content)
            (scratch / "run" / "run.json").write_text(json.dumps(told, indent=1))
            return self._number(scratch / "run")

    def forget(self, kept: int) -> list[Path]:
        """Return the folders of the runs beyond the newest `kept`, and the newest complete one."""
        runs = self.runs()
        complete = [r for r in runs if recall(r / "run.json").get("status") == COMPLETE]
        return [run for run in runs[kept:] if run not in complete[:1]]

    def _told(self) -> Iterator[dict[str, Any]]:
        for folder in self.runs():
            told = recall(folder / "run.json")
            if all(isinstance(told.get(name), kind) for name, kind in _SHAPE.items()):
                yield told

    def _number(self, made: Path) -> Path:
        """Move a run's folder to the next free number and point `latest` to it."""
        self.folder.mkdir(parents=True, exist_ok=True)
        number = int(next((run.name for run in self.runs()), "0"))
        while True:
            number += 1
            folder = self.folder / f"{number:04d}"
            try:
                os.rename(made, folder)
                break
            except OSError:
                if not folder.exists():
                    raise
        pointer = made.with_name("latest")
        pointer.symlink_to(folder.name)
        os.replace(pointer, self.folder / "latest")
        return folder

    def _link(self, folder: Path, name: str, content: str) -> None:
        """Link an artefact under its dataset's name: its one file, or the folder of its files."""
        target = self.project.store.object_path(content)
        files = [path for path in target.rglob("*") if path.is_file()]
        if len(files) == 1:
            name += files[0].name[files[0].name.index(".") :]
            target = files[0]
        final = self.folder / "0000"
        (folder / name).symlink_to(os.path.relpath(target, final))

    def _warnings(self, outputs: Mapping[str, str]) -> list[str]:
        """Return what the sections of the case's page warn of, each once."""
        warnings: dict[str, None] = {}
        for name, content in outputs.items():
            dataset = self.project.catalog[name]
            if dataset.format == "section":
                section = dataset.load_format().decode(self.project.store.load_object(content))
                warnings |= dict.fromkeys(section.warnings)
        return list(warnings)

    def _publish(self, outputs: Mapping[str, str]) -> dict[str, str]:
        """Copy pages to where the catalog wants them; return place -> content hash of the copy."""
        published = {}
        for name, place in self._places(outputs).items():
            (data,) = self.project.store.load_object(outputs[name]).values()
            publish(self.project.root / place, data)
            published[place] = hash_files({Path(place).name: data})
        return published


def keys_of(run: Path) -> list[str]:
    """Return the keys of all that a run made or used, as its folder tells."""
    keys = recall(run / "run.json").get("keys")
    return [key for key in keys.values() if isinstance(key, str)] if isinstance(keys, dict) else []


def publish(path: Path, data: bytes) -> None:
    """Put a file in its place by one rename."""
    scratch = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        scratch.write_bytes(data)
        os.replace(scratch, path)
    except OSError as error:
        with suppress(OSError):
            scratch.unlink()
        raise StoreFailure(
            f"could not write {path.name}: {error.strerror}",
            f"the folder {path.parent.name} must be writable and have room",
            "make room or mend its permissions, and run again",
        ) from error
