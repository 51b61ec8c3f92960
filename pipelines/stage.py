"""A stage: one node, and the names of the datasets that it takes and makes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

# The dataset that the engine itself gives: what the run did so far. Whoever takes it, takes all.
ACCOUNT = "run_account"


@dataclass(frozen=True, init=False)
class Stage:
    """One step of a pipeline.

    Parameters
    ----------
    function : the node, "folder.verb_object"; its function has the name of its file. Named and not
        imported, so that a run which has nothing to do loads no science.
    inputs : dataset names. Each is an argument of that name; where the names differ, a mapping
        from argument to dataset; names that are no argument go to the function's `*arguments`.
    outputs : dataset names, in the order in which the function returns them.
    name : the stage's own name and that of its parameter file, where a node is used twice.
    """

    function: str
    arguments: Mapping[str, str] = field(hash=False)
    outputs: tuple[str, ...]
    name: str

    def __init__(
        self,
        function: str,
        inputs: Sequence[str] | Mapping[str, str],
        outputs: Sequence[str],
        name: str = "",
    ) -> None:
        arguments = dict(inputs) if isinstance(inputs, Mapping) else {i: i for i in inputs}
        object.__setattr__(self, "function", function)
        object.__setattr__(self, "arguments", arguments)
        object.__setattr__(self, "outputs", tuple(outputs))
        object.__setattr__(self, "name", name or function.rpartition(".")[2])

    @property
    def inputs(self) -> tuple[str, ...]:
        """Dataset names, in order."""
        return tuple(self.arguments.values())

    @property
    def target(self) -> str:
        """Module and function of the node, "nodes.folder.verb_object:verb_object"."""
        return f"nodes.{self.function}:{self.function.rpartition('.')[2]}"
