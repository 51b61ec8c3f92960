"""The datasets that catalog.yml names: format and place of each."""

from importlib import import_module
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

from catalog.validation import unknown, validate
from catalog.yaml_file import load_mapping

# Name in catalog.yml -> module and class; named, so that only what is used is imported.
FORMATS = {
    "image_files": "catalog.formats.image_files:ImageFilesFormat",
    "frames": "catalog.formats.frames:FramesFormat",
    "volume": "catalog.formats.volume:VolumeFormat",
    "labelmap": "catalog.formats.labelmap:LabelMapFormat",
    "mesh": "catalog.formats.mesh:MeshFormat",
    "point_cloud": "catalog.formats.point_cloud:PointCloudFormat",
    "label_files": "catalog.formats.label_files:LabelFilesFormat",
    "sites": "catalog.formats.sites:SitesFormat",
    "concentric_tube_robot": "catalog.formats.robot:ConcentricTubeRobotFormat",
    "concentric_tube_configuration": (
        "catalog.formats.configuration:ConcentricTubeConfigurationFormat"
    ),
    "crisp_setup": "catalog.formats.robot:CrispSetupFormat",
    "crisp_configuration": "catalog.formats.configuration:CrispConfigurationFormat",
    "robot_shape": "catalog.formats.robot_shape:RobotShapeFormat",
    "placed_setups": "catalog.formats.placed_setups:PlacedSetupsFormat",
    "goals": "catalog.formats.goals:GoalsFormat",
    "crisp_trees": "catalog.formats.crisp_trees:CrispTreesFormat",
    "visibility_sets": "catalog.formats.visibility_sets:VisibilitySetsFormat",
    "motion_plans": "catalog.formats.motion_plans:MotionPlansFormat",
    "checked_plans": "catalog.formats.checked_plans:CheckedPlansFormat",
    "table": "catalog.formats.table:TableFormat",
    "record": "catalog.formats.record:RecordFormat",
    "section": "catalog.formats.page:SectionFormat",
    "page": "catalog.formats.page:PageFormat",
}


class Dataset(BaseModel):
    """One entry of catalog.yml.

    An optional input that a case does not bring is what its format makes of no files at all.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    format: Literal[tuple(FORMATS)] | None = None  # type: ignore[valid-type]
    place: str = "store"
    option: str = ""
    optional: bool = False
    about: str

    @property
    def is_input(self) -> bool:
        """Whether a case may bring this dataset as files."""
        return self.place == "input"

    @property
    def format_target(self) -> str:
        """Module and class of the format; empty for what only the engine gives."""
        return FORMATS[self.format] if self.format else ""

    def load_format(self) -> Any:
        """Import and return the format's class."""
        module, _, name = self.format_target.partition(":")
        return getattr(import_module(module), name)


def load_catalog(path: Path) -> dict[str, Dataset]:
    """Return the datasets of catalog.yml by name, each entry checked."""
    entries = load_mapping(path)
    return {
        name: validate(Dataset, entry, f"{path.name}: {name}") for name, entry in entries.items()
    }


def find_dataset(catalog: dict[str, Dataset], name: str) -> Dataset:
    """Return a dataset by its name; a name that is not there is answered with the nearest."""
    if name not in catalog:
        raise unknown("dataset", name, catalog)
    return catalog[name]
