"""Dropping what no kept run uses."""

import shutil

from pipelines.history import History, keys_of
from pipelines.kernel_cache import drop_old_kernels
from pipelines.project import Project


def clean_store(project: Project, keep: int, *, dry_run: bool = False) -> tuple[int, int, int]:
    """Drop old runs, then every artefact that no run still there uses.

    Parameters
    ----------
    keep : how many of the newest runs of each case stay, and with them what they made; the newest
        complete run stays always.

    Returns
    -------
    Numbers of runs and of artefacts dropped, and bytes.
    """
    cases = [path.name for path in project.runs.glob("*") if path.is_dir()]
    old = {run for case in cases for run in History(project, case).forget(max(keep, 1))}
    kept = {run for case in cases for run in History(project, case).runs()} - old
    keys = {key for run in kept for key in keys_of(run)}
    dropped, size = project.store.clean(keys, dry_run=dry_run)
    for run in old if not dry_run else ():
        shutil.rmtree(run)
    if not dry_run:
        drop_old_kernels(project.root)
    return len(old), dropped, size
