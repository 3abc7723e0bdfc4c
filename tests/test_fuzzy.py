import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cairn
from cairn import errors

SPEED = """
[inputs.distance]
range = [0.0, 2.0]
sets.Near = { left_shoulder = [0.2, 1.0] }
sets.Far = { right_shoulder = [0.2, 1.0] }
[outputs.speed]
Slow = 0.1
Fast = 0.7
[[rules]]
when = { distance = "Near" }
then = { speed = "Slow" }
[[rules]]
when = { distance = "Far" }
then = { speed = "Fast" }
"""


def test_a_system_of_two_rules_interpolates_between_their_singletons():
    system = cairn.FuzzySystem(SPEED)
    assert system.inputs == ["distance"]
    assert system.outputs == ["speed"]
    assert system.evaluate(distance=0.6)["speed"] == pytest.approx(0.4)
    assert system.evaluate(distance=-3)["speed"] == pytest.approx(0.1)
    assert system.evaluate(distance=99)["speed"] == pytest.approx(0.7)


def test_arrays_broadcast_and_equal_single_values():
    control = cairn.Tracker("p3at", cairn.Profile.load("p3at")).control
    distances = np.linspace(0, 2, 9)[:, None]
    headings = np.linspace(-np.pi, np.pi, 11)
    surface = control.evaluate(C=0, Vc=0, dR=distances, dtheta=headings)
    assert surface["V"].shape == surface["omega"].shape == (9, 11)
    one = control.evaluate(C=0, Vc=0, dR=distances[4, 0], dtheta=headings[7])
    assert surface["V"][4, 7] == one["V"]
    assert surface["omega"][4, 7] == one["omega"]


def test_an_explanation_names_the_rules_that_fired_and_recombines_to_the_output():
    seen = cairn.FuzzySystem(SPEED).explain(distance=0.4)
    assert seen["memberships"] == {"distance": pytest.approx({"Near": 0.75, "Far": 0.25})}
    assert seen["rules"] == pytest.approx(
        {"if distance Near then speed Slow": 0.75, "if distance Far then speed Fast": 0.25}
    )
    assert seen["outputs"]["speed"] == pytest.approx(0.75 * 0.1 + 0.25 * 0.7)


@given(st.floats(-1, 3))
def test_output_is_what_numpy_interpolates(distance):
    found = cairn.FuzzySystem(SPEED).evaluate(distance=distance)["speed"]
    assert found == pytest.approx(np.interp(distance, [0.2, 1.0], [0.1, 0.7]))


@pytest.mark.parametrize(
    ("before", "after", "error", "said"),
    [
        ('distance = "Far"', 'distance = "Fra"', errors.FuzzyNameUnknown, "Fra"),
        ('distance = "Far"', 'size = "Far"', errors.FuzzyNameUnknown, "size"),
        ("[0.2, 1.0] }\n[out", "[1.0, 0.2] }\n[out", errors.FuzzySetNotRising, "Far"),
        ("[0.2, 1.0] }\n[out", "[1.5, 1.8] }\n[out", errors.FuzzyRulesLeaveGap, "distance = 1"),
        ("range = [0.0, 2.0]", "range = [2.0, 0.0]", errors.FuzzyRangeNotRising, "distance"),
        ("Fast = 0.7", "Fast = nan", errors.FuzzyNumberInvalid, "Fast"),
        ("[[rules]]", "[[ruels]]", errors.ControllerUnreadable, "ruels"),
        ("range =", "range", errors.ControllerUnreadable, "line 3"),
        ('distance = "Far"', 'distance = "Near"', errors.FuzzyRulesLeaveGap, "distance = 1"),
    ],
)
def test_a_mistake_in_a_file_is_refused_by_name(before, after, error, said):
    assert before in SPEED
    with pytest.raises(error, match=said):
        cairn.FuzzySystem(SPEED.replace(before, after))


def test_inputs_that_are_missing_strange_or_no_numbers_are_refused():
    system = cairn.FuzzySystem(SPEED)
    with pytest.raises(errors.FuzzyInputsMismatch, match="distance"):
        system.evaluate()
    with pytest.raises(errors.FuzzyInputsMismatch):
        system.evaluate(distance=1, size=2)
    with pytest.raises(errors.FuzzyInputNotFinite, match="distance"):
        system.evaluate(distance=np.array([0.1, np.nan]))
