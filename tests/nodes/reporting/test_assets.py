import re

import pytest

from nodes.reporting.assets import read_asset


def test_the_3d_viewer_is_small_enough_for_every_page():
    assert len(read_asset("viewer3d.js").encode()) < 700_000


@pytest.mark.parametrize("name", ["viewer3d.js", "slices.js", "slice_pane.js", "slice_voxels.js"])
def test_scripts_can_stand_inside_a_page(name):
    code = read_asset(name)
    assert "</script" not in code.lower() and "<!--" not in code


@pytest.mark.parametrize("name", ["viewer3d.js", "slices.js", "page.css"])
def test_no_asset_names_a_place_to_load_from(name):
    addresses = set(re.findall(r"https?://[^\"'`)\s]*", read_asset(name)))
    assert addresses <= {"http://www.w3.org/1999/xhtml"}  # the name of a namespace, never loaded


def test_the_bundle_is_the_version_that_the_readme_names():
    release = re.search(r"three\s+0\.(\d+)\.", read_asset("README.md")).group(1)
    assert f'"{release}"' in read_asset("viewer3d.js")
