"""The benchmark of a tick measures the ticks of the run, and counts if their commands agree."""

from cairn.experiments.bench_tick import PARTS, Case, measure, summary_of

QUICK = Case("quick", "quick", "odometry")


def test_the_measured_ticks_are_those_of_the_run_with_the_same_commands():
    (measured,) = measure((QUICK,), rounds=1)
    assert measured.same
    assert measured.plans == 1
    assert measured.ticks > 150  # `quick` takes 18 s
    assert measured.parts_us.keys() == set(PARTS)
    assert {"path tracking", "stop"} <= measured.modes_us.keys()


def test_the_summary_is_of_the_worst_case_that_counts():
    (measured,) = measure((QUICK,), rounds=1)
    apart = Case("apart", "quick", "odometry", counts=False)
    slow = type(measured)(**{**vars(measured), "case": apart, "share": 9.0})
    assert summary_of([measured, slow])["recording_share"] == measured.share
