"""What the shell offers where a word of tendril's is begun."""

import click

from pipelines.project import Project


def complete_cases(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    return [name for name in Project().cases() if name.startswith(incomplete)]


def complete_stages(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    from pipelines.registry import PIPELINES

    names = {stage.name for module in PIPELINES.values() for stage in module.STAGES}
    return sorted(name for name in names if name.startswith(incomplete))


def complete_pipelines(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    from pipelines.registry import PIPELINES

    return [name for name in PIPELINES if name.startswith(incomplete)]
