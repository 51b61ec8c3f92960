import re
from base64 import b64encode
from dataclasses import replace
from hashlib import sha256
from html import unescape

import pytest

from nodes.reporting.artefacts import Section
from nodes.reporting.build_case_page import build_case_page

NO_STAGES = {"stages": (), "changed_parameters": (), "inputs": (), "versions": ()}


@pytest.fixture
def build(run_account, defaults):
    def build(*sections, **changes):
        account = replace(run_account, **changes)
        parameters = defaults("build_case_page")
        return build_case_page(*sections, run_account=account, parameters=parameters).html

    return build


def text_of(html):
    """Return what a reader sees, without styles and scripts."""
    html = re.sub(r"<(style|script)\b.*?</\1>", " ", html, flags=re.S)
    return unescape(re.sub(r"\s+", " ", re.sub(r"<[^>]*>", " ", html)))


def test_sections_stand_in_the_order_given(build):
    html = build(Section("Second", "<p>b</p>"), Section("First", "<p>a</p>"))
    assert html.index("Second") < html.index("<p>b</p>") < html.index("First")


def test_warnings_stand_before_pictures_and_once(build):
    html = build(
        Section("One", "<p>picture</p>", ("simulated: a phantom", "Thick slices.")),
        Section("Two", "", ("Thick slices.", "simulated: a phantom")),
    )
    assert html.count("Thick slices.") == 1 and html.count("simulated: a phantom") == 1
    assert html.index("are simulated") < html.index("Thick slices.") < html.index("picture</p>")


def test_a_real_case_has_no_banner(build):
    html = build(Section("One", "", ("Thick slices.",)))
    assert "are simulated" not in html and "Before you look" in html
    assert "Before you look" not in build(Section("One", ""))


def test_many_warnings_fold_but_none_is_lost(build, defaults):
    count = defaults("build_case_page").first_warnings
    many = tuple(f"Warning {n}." for n in range(count + 7))
    html = build(Section("One", "", many))
    assert all(html.count(text) == 1 for text in many)
    assert html.index(many[count - 1]) < html.index("7 more") < html.index(many[count])
    assert "more</summary>" not in build(Section("One", "", many[:count]))


def test_estimates_have_a_banner_of_their_own(build):
    html = build(Section("One", "", ("The skull is estimated.", "Thick slices.")))
    assert html.index("are estimated") < html.index("The skull") < html.index("Before you look")
    assert "are estimated" not in build(Section("One", "", ("Thick slices.",)))


def test_each_script_is_there_once_and_only_if_needed(build):
    scripts = r"<script>.*?</script>"
    assert not re.findall(scripts, build(Section("One", "")), re.S)
    twice = build(*[Section("One", "", (), ("slice_voxels",))] * 2)
    assert len(re.findall(scripts, twice, re.S)) == 1


def test_the_policy_lets_only_the_pages_own_scripts_run(build):
    html = build(Section("One", "", (), ("slices", "viewer3d")))
    policy = unescape(re.search(r'Content-Security-Policy" content="([^"]*)"', html).group(1))
    codes = re.findall(r"<script>(.*?)</script>", html, re.S)
    assert len(codes) == 2
    allowed = {b64encode(sha256(code.encode()).digest()).decode() for code in codes}
    assert set(re.findall(r"'sha256-([^']*)'", policy)) == allowed
    assert policy.startswith("default-src 'none'") and "unsafe-eval" not in policy
    assert "http" not in policy


def test_the_page_tells_parameters_versions_and_hashes(build, run_account):
    html = build()
    text = text_of(html)
    assert "-450" in text and "-400" in text and "Below this is air, in HU." in text
    assert "numpy 2.4.6" in text and "not a medical device" in text
    assert "never run" in text
    for stage in run_account.stages:
        for digest in (stage.key, *stage.output_hashes):
            assert f'title="{digest}"' in html
    assert f'title="{"ab" * 32}"' in html


def test_a_page_stands_without_stages_inputs_and_changes(build):
    text = text_of(build(**NO_STAGES))
    assert "every parameter has its default" in text and "How this page was made" not in text


def test_texts_of_the_account_stay_text(build, hostile, run_account):
    stages = tuple(
        replace(stage, summary=hostile, reasons=(hostile,)) for stage in run_account.stages
    )
    changed = replace(run_account.changed_parameters[0], value=hostile, meaning=hostile)
    html = build(
        Section(hostile, "", (hostile, "simulated: " + hostile)),
        title=hostile,
        case=hostile,
        stages=stages,
        inputs=((hostile, hostile, hostile),),
        changed_parameters=(changed,),
        versions=((hostile, hostile),),
    )
    assert "<script" not in html and "<b onmouseover" not in html
    assert text_of(html).count("document.title='owned'") > 20


def test_pages_are_the_same_whenever_they_are_built(build):
    section = Section("One", "", (), ("slice_voxels",))
    assert build(section) == build(section)
