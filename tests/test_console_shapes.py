"""What the console draws and tells, without a browser."""

import math

import numpy as np
import pytest

import cairn
from cairn.missions import Scenario
from cairn.missions.live import Live, with_nothing_to_do
from cairn.view.console import commands as ask
from cairn.view.console import shapes, words
from cairn.view.console.snapshot import Body, Grid, Lidar, Sonar

TURNED = (1.0, 2.0, math.pi / 2)


def a_body(sonars=(), lidar=None):
    return Body(0.6, 0.5, 0.3, tuple(sonars), lidar, 0.7, 2.4)


def test_row_0_of_a_map_is_at_the_bottom_of_its_picture():
    grid = Grid(np.array([[1, 0], [0, 2], [0, 0]], np.uint8), 1.0, (0.0, 0.0, 0.0), 1)
    picture = shapes.map_pixels(grid)
    times = picture.shape[0] // 3
    assert tuple(picture[-1, 0]) == shapes.OCCUPIED
    assert tuple(picture[-1 - times, -1]) == shapes.UNKNOWN
    assert tuple(picture[0, 0]) == shapes.FREE


def test_a_turned_grid_is_centred_where_its_world_says():
    grid = Grid(np.zeros((4, 6), np.uint8), 0.5, TURNED, 1)
    world = cairn.World(grid.values, resolution_m=0.5, origin=TURNED)
    assert shapes.centre(grid) == pytest.approx(world.world_from_grid((1.5, 1.0)))
    assert shapes.view(grid) == pytest.approx(world.extent)


def test_contours_run_where_the_cost_to_go_has_their_level():
    # A cone: the level of a point is its distance from the goal.
    grid = Grid(np.empty((80, 80)), 0.1, (0.0, 0.0, 0.0), 1)
    y, x = (np.indices((80, 80)) + 0.5) * 0.1
    costs = np.hypot(x - 4, y - 4)
    costs[:, 60:] = np.inf
    segments, shares = shapes.contours(Grid(costs, 0.1, (0.0, 0.0, 0.0), grid.number))
    away = np.hypot(*(segments - (4, 4)).reshape(-1, 2).T).reshape(-1, 2)
    assert np.ptp(away, axis=1).max() < 0.03
    levels = {round(float(level), 1) for level in away.mean(axis=1)}
    assert len(levels) > 10
    assert segments[..., 0].max() < 6.0  # none where there is no way
    assert np.corrcoef(shares, away.mean(axis=1))[0, 1] > 0.999


def test_arrows_point_down_the_cost_to_go():
    y, x = (np.indices((60, 60)) + 0.5) * 0.1
    segments, _ = shapes.arrows(Grid(np.hypot(x - 3, y - 3), 0.1, (0.0, 0.0, 0.0), 1))
    way, towards = segments[:, 1] - segments[:, 0], (3, 3) - segments.mean(axis=1)
    far = np.hypot(*towards.T) > 0.5
    cosine = (way * towards).sum(axis=1) / np.hypot(*way.T) / np.hypot(*towards.T)
    assert len(segments) > 100
    assert cosine[far].min() > 0.99


def test_a_sonar_cone_reaches_to_what_it_heard_from_where_it_sits():
    sonar = Sonar((0.2, 0.1, 0.0), math.radians(30), 5.0)
    ranges = np.array([2.0, math.inf, math.nan])
    heard, silent = shapes.cones(a_body([sonar] * 3), ranges, TURNED)
    at = np.array([1.0 - 0.1, 2.0 + 0.2])  # the sonar's place, turned left with the robot
    assert heard[0][0] == pytest.approx(at)
    assert np.hypot(*(heard[0][1:] - at).T) == pytest.approx(2.0)
    assert np.hypot(*(silent[0][1:] - at).T) == pytest.approx(5.0)
    assert len(heard[1]) == len(silent[1])


def test_lidar_points_lie_where_their_beams_end():
    body = a_body(lidar=Lidar((0.1, 0.0, 0.0), -math.pi / 2, math.pi / 2))
    points = shapes.scan_points(body, np.array([1.0, 2.0, math.inf]), (0.0, 0.0, 0.0))
    assert points == pytest.approx(np.array([[0.1, -1.0], [2.1, 0.0]]), abs=1e-12)


@pytest.mark.parametrize("curvature", [-3.0, -0.4, 0.0, 1e-9, 0.7])
def test_an_arc_has_its_length_and_its_curvature(curvature):
    points = shapes.arc(curvature, 1.0)
    assert np.hypot(*np.diff(points, axis=0).T).sum() == pytest.approx(1.0, rel=0.02)
    if abs(curvature) > 0.1:
        assert np.hypot(*(points - (0, 1 / curvature)).T) == pytest.approx(1 / abs(curvature))


def test_free_arcs_end_at_their_free_length_and_are_sorted_by_it():
    intervals = [
        {"curvature_lo": low, "curvature_hi": low + 0.1, "distance_m": distance}
        for low, distance in ((-0.1, 0.3), (0.0, 1.0), (0.1, 3.0))
    ]
    near, middling, far = shapes.free_arcs({"intervals": intervals}, (0.0, 0.0, 0.0))
    for mesh, distance in ((near, 0.3), (middling, 1.0), (far, 3.0)):
        assert np.hypot(*mesh[0].T).max() == pytest.approx(distance, rel=0.03)


def test_all_that_is_told_is_escaped():
    live = Live(with_nothing_to_do(Scenario.load("quick")), paused=True, open_end=True).start()
    live.do(ask.TakeBox("<script>alert(1)</script>"))
    while not (snapshot := live.newer(0, 10.0)).notes:
        pass
    live.end()
    assert "<script>" in snapshot.notes[0].text
    assert "<script>" not in words.log(snapshot, 0)
    assert "&lt;script&gt;" in words.log(snapshot, 0)


def test_the_rules_that_fire_are_lit_by_their_strength():
    tracking = {
        "C": 2.5, "dR": 0.4, "dtheta": 0.1, "Vc": 0.3,
        "look_ahead": {
            "memberships": {
                "alpha1": {"High1": 0.25, "Straight1": 0.75, "VeryHigh1": 0.0},
                "alpha2": {"High2": 0.0, "Straight2": 1.0, "VeryHigh2": 0.0},
            },
            "rules": {
                "if alpha1 Straight1 and alpha2 Straight2 then C NoCurvature": 0.75,
                "if alpha1 High1 and alpha2 Straight2 then C cHigh": 0.25,
            },
        },
        "tracker": {
            "outputs": {"V": 0.5, "omega": 0.1},
            "memberships": {"C": {"None": 1.0}},
            "rules": {"if C None and dR Far then V 0.7": 0.6, "if C None then omega 0": 0.4},
        },
    }  # fmt: skip
    state = type("State", (), {"decision": {"tracking": tracking}})()
    told = words.why(state)
    # Table 1 stands in the paper's order, whatever the order of the record.
    assert told.index("Straight1") < told.index("High1") < told.index("VeryHigh1")
    assert told.index("NoCurvature") < told.index("cHigh")
    assert "60 %" in told
    assert "40 %" in told


def test_nothing_to_the_side_has_no_sign():
    told = [words._degrees(math.radians(angle)) for angle in (-0.3, 0.2, 0.6, -12.0)]
    assert told == ["0", "0", "+1", "−12"]
