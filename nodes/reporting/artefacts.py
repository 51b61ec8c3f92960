"""What the reporting stages make: sections, pages, and the account of a run that pages show."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Section:
    """One part of a page.

    Parameters
    ----------
    title : heading, plain text.
    html : ready fragment; every text in it that came from a file is escaped already.
    warnings : plain texts that the page shows before any picture.
    scripts : names of the bundled scripts that the fragment needs.
    """

    title: str
    html: str
    warnings: tuple[str, ...] = ()
    scripts: tuple[str, ...] = ()


@dataclass(frozen=True)
class Page:
    """One self-contained HTML document."""

    html: str


@dataclass(frozen=True)
class StageAccount:
    """What one stage did in a run: `status` is "computed", "cached" or "running" (the page's own
    stage while it is made); `reasons` say why it was computed; `seconds` is what the computation
    took, in this run or, for a cached stage, when it was done; hashes are hex SHA-256."""

    name: str
    summary: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    status: str
    reasons: tuple[str, ...]
    seconds: float
    key: str
    output_hashes: tuple[str, ...]


@dataclass(frozen=True)
class ChangedParameter:
    """A parameter that differs from its default, with the meaning and unit of its field."""

    stage: str
    name: str
    value: str
    default: str
    meaning: str


@dataclass(frozen=True)
class RunAccount:
    """Who made what in one run: the case, its inputs (name, what it is, hash), every stage in
    order, the parameters that differ, the versions of what it was computed with."""

    case: str
    title: str
    pipeline: str
    run: str
    started: str
    inputs: tuple[tuple[str, str, str], ...]
    stages: tuple[StageAccount, ...]
    changed_parameters: tuple[ChangedParameter, ...]
    versions: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class CaseLine:
    """One case in the list of all cases: `status` is "complete", "failed", "interrupted" or "never
    run"; `page` is a relative link or "" where there is none."""

    case: str
    title: str
    pipeline: str
    status: str
    started: str
    seconds: float
    page: str
    warnings: tuple[str, ...] = ()
