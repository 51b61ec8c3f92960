"""How a CRISP robot leaves an equilibrium that it cannot keep."""

import numpy as np
from jaxtyping import Float

from nodes.kernels.crisp_general_problem import Crisp, pack


def unstable_modes(
    crisp: Crisp, wrenches: Float[np.ndarray, "n 6"], margin: float, reach: float
) -> Float[np.ndarray, "mode n 6"]:
    """Return how the base wrenches begin to change when the robot leaves an equilibrium.

    Two modes, since a round tool gives to both sides nearly alike, and where it can stay only the
    second may lead.

    With the least eigenvalue `margin` < 0, the robot with the same shape and wrenches, but softer
    by 1 / (1 - margin), just begins to move: its derivatives by the wrenches are singular, and
    what they send to next to 0 is how it moves.

    Parameters
    ----------
    reach : how far one step of the integrator may turn, rad.
    """
    from nodes.kernels.crisp_general_solve import measure_rows, new_newton
    from nodes.kernels.crisp_general_units import set_weights

    packed = pack(crisp)
    newton = new_newton(packed)
    set_weights(packed, newton)
    newton.walk.ease[0] = 1 / (1 - margin)
    measure_rows(packed, np.array(wrenches), reach, newton)
    _, _, right = np.linalg.svd(newton.weights[:, None] * newton.walk.rows * newton.units)
    return (right[-2:] * newton.units).reshape(-1, *wrenches.shape)
