from nodes.geometry.origin import Origin
from nodes.reporting.honesty import gather_warnings, warnings_of


def test_what_is_simulated_is_said_first():
    real = Origin("a scan", notices=("Slices 5 mm apart.",))
    phantom = Origin("a phantom", True, ("Slices 5 mm apart.", "No noise."))
    assert warnings_of(real, phantom) == (
        "simulated: a phantom",
        "Slices 5 mm apart.",
        "No noise.",
    )


def test_a_real_scan_without_notices_warns_of_nothing():
    assert warnings_of(Origin("a scan")) == ()


def test_a_page_says_each_warning_once_and_by_kind():
    groups = (
        ("simulated: a", "x", "the skull is an estimate"),
        ("x ", "simulated: a", "simulated: an estimated b"),
        ("Estimated from intensities.",),
    )
    told = gather_warnings(groups)
    assert told.simulated == ("simulated: a", "simulated: an estimated b")
    assert told.estimated == ("the skull is an estimate", "Estimated from intensities.")
    assert told.others == ("x",)
