"""The one error that people are meant to read: what was found, which rule it breaks, what to do."""


class BadInput(ValueError):
    """Input that cannot be used.

    Parameters
    ----------
    value : str
        What was found, as the person wrote or sent it; never a patient's identifier.
    rule : str
        The rule that it breaks, with unit.
    cure : str
        What the person can do about it.
    """

    exit_code = 3

    def __init__(self, value: str, rule: str, cure: str) -> None:
        super().__init__(value, rule, cure)
        self.value, self.rule, self.cure = value, rule, cure

    def __str__(self) -> str:
        return f"{self.value}\n  rule: {self.rule}\n  cure: {self.cure}"
