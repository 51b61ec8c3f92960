"""The closed base type of all parameters; their values stand in catalog/parameters/<stage>.yml."""

from pydantic import BaseModel, ConfigDict


class Parameters(BaseModel):
    """Parameters of one stage: frozen, closed, and every field explained by the text below it."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True
    )
