"""What tubes are made of: constants from the literature, to be replaced by measured ones.

E of Nitinol differs by batch, heat treatment and phase (28 to 83 GPa), that of polycaprolactone by
how it was made, and cold-drawn steel comes back from several times the strain of annealed steel:
who has measured a tube writes its own numbers.
"""

from dataclasses import replace

from nodes.mechanics.robots import Material

NITINOL = Material(
    name="nitinol",
    young_modulus_mpa=50000.0,  # [Anderson2017] Sec. III
    poisson_ratio=0.33,  # [Anderson2017] Sec. III
    recoverable_strain=0.08,  # below the about 10 % of [Stoeckel1995]
)
STAINLESS_STEEL = Material(
    name="stainless steel",
    young_modulus_mpa=200000.0,  # [EN1993-1-4] 2.1.3, austenitic
    poisson_ratio=0.3,  # [EN1993-1-4] 2.1.3
    recoverable_strain=0.001,  # yield strength of annealed 1.4301, 210 MPa, over E [EN1993-1-4]
)
POLYCAPROLACTONE = Material(
    name="polycaprolactone",
    young_modulus_mpa=354.0,  # middle of 344 to 364 MPa, solid, laser-sintered [Eshraghi2010]
    poisson_ratio=0.3,  # assumed: 0.3 to 0.47 are in use
    recoverable_strain=0.023,  # least tensile yield strength, 8.2 MPa, over E [Eshraghi2010]
)
MATERIALS = {material.name: material for material in (NITINOL, STAINLESS_STEEL, POLYCAPROLACTONE)}
"""By the name that people write."""


def make_material(
    name: str,
    young_modulus_mpa: float | None = None,
    poisson_ratio: float | None = None,
    recoverable_strain: float | None = None,
) -> Material:
    """Return a material of the table, with those of its numbers replaced that are given.

    Parameters
    ----------
    name : a key of MATERIALS.
    young_modulus_mpa : MPa.
    poisson_ratio, recoverable_strain : without unit.

    Raises
    ------
    BadInput for a number that no material has.
    """
    measured = {
        "young_modulus_mpa": young_modulus_mpa,
        "poisson_ratio": poisson_ratio,
        "recoverable_strain": recoverable_strain,
    }
    return replace(
        MATERIALS[name], **{key: value for key, value in measured.items() if value is not None}
    )
