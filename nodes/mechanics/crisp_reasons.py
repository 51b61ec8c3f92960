"""Why no equilibrium of a CRISP robot is given, in words for a person."""

Outcome = tuple[int, float, int, int]  # of a kernel: status, residual in mm, evaluations


def say_out_of_reach() -> str:
    return (
        "no solution: two entry points lie farther apart than the needles between them are long;"
        " a needle is no shorter than the straight way to what it grasps"
    )


def say_lost(outcome: Outcome, tolerance: float) -> str:
    return (
        f"not converged: no equilibrium was found; {outcome[1]:.3g} mm are left where"
        f" {tolerance:g} are asked for, after {outcome[2]} evaluations of the derivatives"
    )


def say_unstable(margin: float) -> str:
    return (
        "unstable: an equilibrium that the robot would leave; its stability margin is"
        f" {margin:.4g}, and above 0 it stays"
    )
