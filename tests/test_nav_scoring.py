"""The score of BARN by hand values, and intervals."""

import numpy as np
import pytest

from cairn.experiments.nav.scoring import CAP, OLD_CAP, figures, interval, mean_over_worlds, score


@pytest.mark.parametrize(
    ("actual_s", "new", "old"),
    [
        (3.0, 0.5, 0.25),  # faster than twice the optimal time counts as that
        (10.0, 0.5, 0.25),
        (15.0, 1 / 3, 0.25),
        (20.0, 0.25, 0.25),
        (25.0, 0.2, 0.2),
        (40.0, 0.125, 0.125),
        (99.0, 0.125, 0.125),  # slower than eight times as well
    ],
)
def test_the_score_of_ten_metres_is_five_seconds_over_the_clipped_time(actual_s, new, old):
    assert score(True, actual_s, 10.0, 2.0, CAP) == pytest.approx(new)
    assert score(True, actual_s, 10.0, 2.0, OLD_CAP) == pytest.approx(old)
    assert score(False, actual_s, 10.0, 2.0, CAP) == 0.0


def test_worlds_count_alike_however_many_trials_they_have():
    assert mean_over_worlds([[1.0, 1.0, 1.0], [0.0]]) == 0.5
    assert mean_over_worlds([]) is None


def test_an_interval_holds_the_mean_and_shrinks_with_more_worlds():
    random = np.random.default_rng(3)
    few, many = ([list(random.random(10)) for _ in range(n)] for n in (10, 400))
    (a, b), (c, d) = interval(few, 1), interval(many, 1)
    assert a < mean_over_worlds(few) < b
    assert d - c < (b - a) / 3
    assert interval(few, 1) == [a, b]
    # The standard error of a mean of means of uniform numbers, within a fifth.
    se = np.std([np.mean(world) for world in many]) / 20
    assert (d - c) / (2 * 1.96) == pytest.approx(se, rel=0.6)
    assert interval([[1.0] * 10] * 5, 1) == [1.0, 1.0]


def test_shares_of_outcomes_sum_to_one():
    def trial(outcome):
        return {"outcome": outcome, "time_s": 10.0, "score": 0.5, "score_old_cap": 0.25}

    kinds = ("success", "success", "collision", "timeout")
    summary = figures([[trial(kind) for kind in kinds], [trial("error")] * 4], seed=1)
    assert (summary["success"], summary["collision"]) == (0.25, 0.125)
    assert (summary["timeout"], summary["error"]) == (0.125, 0.5)
    assert (summary["worlds"], summary["trials"], summary["time_s"]) == (2, 8, 10.0)
