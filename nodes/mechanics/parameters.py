"""Parameters of mechanics, one class a node."""

from pydantic import Field

from nodes.parameters import Parameters


class FollowCrispEdgesParameters(Parameters):
    """How straight, unloaded CRISP robots are followed along edges."""

    tolerance_mm: float = Field(gt=0, le=1e-3)
    """Sum of what may be left of the joints' conditions, mm; angles and moments count as the gap
    that they make over the needles' mean length. The tip is then known about as well."""
    integration_error_mm: float = Field(gt=0, le=1e-3)
    """Error of a needle's integrated shape at its end, mm, as a finer integration shows it."""
    largest_bend_rad: float = Field(gt=0)
    """Change of a needle's bend in one iteration, rad: more is shortened to it."""
    iterations: int = Field(ge=2)
    """Iterations at one step at most; that halve the residual in no three end earlier."""
    steps_between_checks: int = Field(ge=1)
    """Steps along an edge after which the integration's error is measured again."""
    refinements: int = Field(ge=0)
    """How often the rest of an edge is tried again with steps a quarter as long."""


class ShapeCrispParameters(Parameters):
    """How equilibria of CRISP robots are sought and sampled."""

    tolerance_mm: float = Field(gt=0, le=1e-3)
    """What may be left of the joints' and the tip's conditions, mm; angles count by the tool's
    length, moments by the deflection that they make."""
    sample_spacing_mm: float = Field(gt=0)
    """Largest distance of the places along each needle that are given, mm."""
    guesses: int = Field(ge=0, le=1000)
    """Random wrenches from which further equilibria are sought besides the one from rest; the
    stable one of least energy is taken."""
    seed: int = Field(ge=0)
    """Of the random wrenches."""
    same_equilibrium: float = Field(gt=0)
    """Two equilibria are the same whose base wrenches differ by less than this share of what bends
    the tool by a radian."""
    margin_accuracy: float = Field(ge=1e-12, le=0.01)
    """Error of the stability margin, without unit."""


class ShapeConcentricTubesParameters(Parameters):
    """How the shape of a concentric tube robot is sampled."""

    sample_spacing_mm: float = Field(gt=0)
    """Largest distance of the places along the backbone that are given, mm; ends of tubes and
    starts of their curves are added."""
