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


def test_the_last_notices_are_said_first():
    told = warnings_of(Origin("a plan", notices=("of the scan", "of the plan")))
    assert told == ("of the plan", "of the scan")


def test_what_was_computed_from_a_simulation_is_told_apart_from_it():
    chain = ("simulated: plans in a phantom", "simulated: a phantom", "simulated: a noise")
    told = gather_warnings((chain,))
    assert told.simulated == ("simulated: a phantom", "simulated: a noise")
    assert told.derived == ("simulated: plans in a phantom",)


def test_a_real_scan_without_notices_warns_of_nothing():
    assert warnings_of(Origin("a scan")) == ()


def test_a_page_says_each_warning_once_and_by_kind():
    groups = (
        ("simulated: one", "x", "the skull is an estimate"),
        ("x ", "simulated: one", "simulated: an estimated b"),
        ("Estimated from intensities.",),
    )
    told = gather_warnings(groups)
    assert told.simulated == ("simulated: one", "simulated: an estimated b")
    assert told.estimated == ("the skull is an estimate", "Estimated from intensities.")
    assert told.others == ("x",)
