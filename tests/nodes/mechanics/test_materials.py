"""Constants of the table can be replaced one by one, and nothing else can."""

import pytest

from nodes.errors import BadInput
from nodes.mechanics.materials import MATERIALS, NITINOL, make_material


def test_nitinol_is_that_of_the_published_experiments():
    """[Anderson2017] Sec. III: 50 GPa, 0.33."""
    assert (NITINOL.young_modulus_mpa, NITINOL.poisson_ratio) == (50000, 0.33)


def test_what_is_measured_replaces_the_literature():
    measured = make_material("nitinol", young_modulus_mpa=58000.0)
    assert measured.young_modulus_mpa == 58000
    assert measured.poisson_ratio == NITINOL.poisson_ratio
    assert make_material("polycaprolactone") == MATERIALS["polycaprolactone"]


def test_constants_that_no_material_has_are_refused():
    with pytest.raises(BadInput, match=r"poisson_ratio = 0\.7"):
        make_material("nitinol", poisson_ratio=0.7)


def test_only_the_superelastic_alloy_takes_tight_curves():
    """Which is why concentric tubes are made of it."""
    strains = {name: material.recoverable_strain for name, material in MATERIALS.items()}
    assert strains["stainless steel"] < strains["polycaprolactone"] < strains["nitinol"] <= 0.1
