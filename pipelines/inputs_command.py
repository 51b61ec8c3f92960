"""A command with one option for each dataset that a case may bring."""

import click

from pipelines.project import Project


class InputsCommand(click.Command):
    """A command whose options are read from the catalog only when it is used."""

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        if not self.params[1:]:
            for name, dataset in Project().catalog.items():
                if dataset.option:
                    option = click.Option(
                        [dataset.option, name],
                        type=click.Path(),
                        metavar="DIR|FILE",
                        help=dataset.about,
                    )
                    self.params.append(option)
            self.params.append(click.Option(["--title"], help="Heading of the case's page."))
            self.params.append(
                click.Option(["--pipeline"], help="Where several take these inputs.")
            )
        return super().get_params(ctx)
