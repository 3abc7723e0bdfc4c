"""Worlds of the navigation benchmark: files, splines, and the generator."""

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline
from scipy.ndimage import binary_dilation, label

from cairn import errors
from cairn.experiments.nav import generator, worlds
from cairn.experiments.nav.movers import Mover, Movers

STATIC = {
    "index": 7,
    "kind": "static",
    "cylinders": [[1.0, 2.0, 0.075], [1.5, 2.0, 0.075]],
    "start": [-2.25, 3.0, 1.57],
    "goal": [-2.25, 13.0],
    "goal_tolerance": 1.0,
    "timeout": 100.0,
    "path_length": 12.5,
    "reference_path_fitted": [[-2.25, 3.0], [-2.25, 13.0]],
}
DYNAMIC = {
    "start": [11.0, 0.0, 3.14],
    "goal": [-9.0, 0.0],
    "boxes": [[-10.0, 0.0, 0.5, 20.0]],
    "obstacles": [
        {
            "name": "hardlibobs_1",
            "radius": 0.5,
            "period": 4.0,
            "keyframes": [[0.0, 1.0, 0.0], [2.0, 3.0, 1.0], [4.0, 3.0, 5.0]],
        }
    ],
    "path_length_nominal": 20.0,
}
SDF = """<sdf version='1.6'><world name='default'>
<model name='ground_plane'><link name='l'><collision name='c'><geometry><plane/></geometry>
</collision></link></model>{models}</world></sdf>"""
POST = """<model name='post'><pose frame=''>{x} {y} 0 0 0 0</pose><link name='l'>
<collision name='c'><geometry><cylinder><radius>0.075</radius><length>1</length></cylinder>
</geometry></collision></link></model>"""
WALL = """<model name='wall'><pose>1 2 0 0 0 0.5</pose><link name='l'><collision name='c'>
<geometry><box><size>3 0.2 1</size></box></geometry></collision></link></model>"""


def written(folder: Path, data, name="world_7.json"):
    path = folder / name
    path.write_text(data if isinstance(data, str) else json.dumps(data))
    return path


def test_a_static_world_keeps_every_number_of_its_file(tmp_path):
    world = worlds.load(written(tmp_path, STATIC))
    np.testing.assert_array_equal(world.circles, STATIC["cylinders"])
    assert (tuple(world.start), world.goal) == ((-2.25, 3.0, 1.57), (-2.25, 13.0))
    assert (world.path_length_m, world.timeout_s, world.kind) == (12.5, 100.0, "static")
    assert world.motion() is None


def test_walls_of_a_dynamic_world_reach_half_their_size_to_both_sides(tmp_path):
    world = worlds.load(written(tmp_path, DYNAMIC))
    assert (world.kind, world.difficulty, world.path_length_m) == ("dynamic", "hard", 20.0)
    ranges, cosines = world.shapes().cast((0.0, 0.0), np.array([np.pi]), 30.0)
    assert (ranges[0], cosines[0]) == pytest.approx((9.75, 1.0))
    assert np.isinf(world.shapes().cast((0.0, 10.1), np.array([np.pi]), 30.0)[0][0])


@pytest.mark.parametrize(
    ("key", "value", "named"),
    [
        ("start", None, "start"),
        ("start", [1.0, 2.0], "start"),
        ("goal", ["a", 2.0], "goal"),
        ("goal", [float("inf"), 2.0], "goal"),
        ("cylinders", [[0.0, 0.0, -1.0]], "cylinders"),
        ("cylinders", [[0.0, 0.0]], "cylinders"),
        ("cylinders", [[0.0, 0.0, 1.0], [0.0]], "cylinders"),
        ("boxes", [[0.0, 0.0, 0.0, 1.0]], "boxes"),
        ("path_length", 0, "path_length"),
        ("path_length", None, "path_length"),
        ("timeout", "long", "timeout"),
        ("obstacles", [7], "obstacles[0]"),
        ("obstacles", [{"radius": 1, "period": 1, "keyframes": [[0, 0, 0]]}], "keyframes"),
        (
            "obstacles",
            [{"radius": 1, "period": 2, "keyframes": [[0, 0, 0], [2, 0, 0], [1, 0, 0]]}],
            "keyframes",
        ),
        ("obstacles", [{"radius": 0, "period": 1, "keyframes": [[0, 0, 0], [1, 0, 0]]}], "radius"),
    ],
)
def test_a_file_that_is_no_world_is_refused_with_its_path_and_key(tmp_path, key, value, named):
    path = written(tmp_path, {**STATIC, key: value})
    with pytest.raises(errors.NavWorldInvalid) as caught:
        worlds.load(path)
    assert caught.value.path == str(path)
    assert named in caught.value.key


@pytest.mark.parametrize("text", ["", "[1, 2]", "{'a': 1}", "\x00"])
def test_a_file_that_is_no_json_object_is_refused(tmp_path, text):
    with pytest.raises(errors.NavWorldInvalid):
        worlds.load(written(tmp_path, text))


def test_a_folder_gives_the_worlds_asked_for_and_names_those_it_has_not(tmp_path):
    for number in (3, 11, 12):
        written(tmp_path, STATIC, f"world_{number:03d}.json")
    assert [w.name for w in worlds.load_folder(tmp_path)] == ["world_003", "world_011", "world_012"]
    assert [w.name for w in worlds.load_folder(tmp_path, (12, 3))] == ["world_012", "world_003"]
    with pytest.raises(errors.NavWorldsMissing) as caught:
        worlds.load_folder(tmp_path, (3, 4, 5))
    assert caught.value.missing == [4, 5]
    with pytest.raises(errors.NavWorldsMissing):
        worlds.load_folder(tmp_path / "nowhere")


# ---- the benchmark's own files ------------------------------------------------------------


def test_a_gazebo_world_gives_its_posts_and_walls_and_the_length_of_its_path_file(tmp_path):
    models = POST.format(x=-0.5, y=6.0) + WALL
    path = written(tmp_path, SDF.format(models=models), "world_7.world")
    (tmp_path / "path_files").mkdir()
    cells = np.array([[15, 0], [15, 29]])
    np.save(tmp_path / "path_files" / "path_7.npy", cells)
    world = worlds.load(path)
    np.testing.assert_allclose(world.circles, [[-0.5, 6.0, 0.075]])
    np.testing.assert_allclose(world.boxes, [[1.0, 2.0, 0.5, 3.0, 0.2]])
    # Cell (15, c) is at x = 15 · 0.15 − 4.575, y = 0.15 c + 5.075, as the challenge's own script.
    there = [(-2.25, 3.0), (-2.325, 5.075), (-2.325, 9.425), (-2.25, 13.0)]
    length = sum(np.hypot(*np.subtract(b, a)) for a, b in pairwise(there))
    assert world.path_length_m == pytest.approx(length)


def test_a_gazebo_world_without_a_path_file_is_measured_by_the_shortest_way(tmp_path):
    known = generator.generated(4)
    models = "".join(POST.format(x=x, y=y) for x, y, _ in known.circles)
    world = worlds.load(written(tmp_path, SDF.format(models=models), "world_1.world"))
    np.testing.assert_allclose(world.circles, known.circles, atol=1e-12)
    # No shorter than straight on, no longer than the way between places that were drawn.
    assert 10.0 <= world.path_length_m <= known.path_length_m


@pytest.mark.parametrize(
    "text",
    [
        "no xml",
        SDF.format(models=""),
        SDF.format(models=POST.format(x="nan", y=1)),
        SDF.format(models=POST.format(x="", y=1)),
        SDF.format(models="".join(POST.format(x=x / 10, y=7) for x in range(-50, 5))),
    ],
    ids=["no XML", "nothing in it", "no number", "a number too few", "no way through"],
)
def test_a_gazebo_file_that_is_no_world_is_refused(tmp_path, text):
    with pytest.raises(errors.NavWorldInvalid):
        worlds.load(written(tmp_path, text, "world_0.world"))


def test_a_gazebo_file_whose_obstacles_move_by_plugins_is_refused_for_that(tmp_path):
    # As DynaBARN has them, its XML not well-formed at that.
    moving = "<plugin name='easylibobs_66' filename='easylibobs_66.so'/>"
    wall = "<model name='w'><pose frame=>-10 0 .5 0 0 0</pose></model>"
    with pytest.raises(errors.NavWorldInvalid, match="read as JSON") as caught:
        worlds.load(written(tmp_path, SDF.format(models=moving + wall), "world_0.world"))
    assert caught.value.key == "plugin"


def test_a_world_scaled_measures_the_same_angles_and_longer_ranges(tmp_path):
    world = worlds.load(written(tmp_path, DYNAMIC))
    large = world.scaled(1.3)
    angles = np.linspace(-3, 3, 50)
    one, two = (w.shapes().cast(w.start[:2], angles, 1e3)[0] for w in (world, large))
    np.testing.assert_allclose(two, 1.3 * one)
    np.testing.assert_allclose(Movers(large.movers).at(1.0), 1.3 * Movers(world.movers).at(1.0))
    assert large.path_length_m == pytest.approx(26.0)


# ---- moving obstacles ------------------------------------------------------------

FRAMES = np.array(
    [[0.0, -10.0, 6.0], [5.0, -1.0, 2.5], [5.3, -1.0, 2.0], [8.5, 1.1, -3.3], [12.0, 3.0, 0.0]]
)


def test_movers_follow_the_hermite_spline_with_half_chords_as_tangents():
    points = FRAMES[:, 1:]
    tangents = np.gradient(points, axis=0)  # half chords inside, whole ones at both ends
    tangents[[0, -1]] /= 2
    oracle = CubicHermiteSpline(np.arange(5.0), points, tangents)
    movers = Movers([Mover("a", 0.5, 12.0, FRAMES)])
    times = np.linspace(0, 11.999, 500)
    expected = oracle(np.interp(times, FRAMES[:, 0], np.arange(5.0)))
    np.testing.assert_allclose(movers.at(times)[:, 0, :2], expected, atol=1e-9)
    np.testing.assert_allclose(movers.at(times + 24.0), movers.at(times), atol=1e-9)
    assert (movers.at(times)[..., 2] == 0.5).all()


def test_movers_with_different_key_frames_are_each_where_they_would_be_alone():
    two = [Mover("a", 0.5, 12.0, FRAMES), Mover("b", 0.2, 9.0, FRAMES[:3] * [1, 2, 3])]
    times = np.linspace(0, 50, 200)
    both = Movers(two).at(times)
    for i, mover in enumerate(two):
        np.testing.assert_array_equal(both[:, i], Movers([mover]).at(times)[:, 0])


def test_a_mover_jumps_at_the_end_of_its_period_unless_its_loop_is_closed():
    closed = FRAMES.copy()
    closed[-1, 1:] = closed[0, 1:]
    movers = Movers([Mover("a", 0.5, 12.0, FRAMES), Mover("b", 0.5, 12.0, closed)])
    assert movers.from_jump_s(0, 23.95) == pytest.approx(0.05)
    assert movers.from_jump_s(0, 24.3) == pytest.approx(0.3)
    assert movers.from_jump_s(1, 24.0) == np.inf


# ---- our own worlds ------------------------------------------------------------


def test_a_generated_world_is_the_same_for_ever_and_no_other():
    np.testing.assert_array_equal(generator.generated(5).circles, generator.generated(5).circles)
    seen = {generator.generated(n, seed).circles.tobytes() for n in range(3) for seed in (1, 2)}
    assert len(seen) == 6


@pytest.mark.parametrize("number", range(5))
def test_a_disc_of_the_clearance_passes_every_generated_world(number):
    world = generator.generated(number)
    # The oracle: a picture of 2.5 cm, thickened by the disc less the error of a pixel, flooded.
    cell = 0.025
    x = np.arange(-4.5, 0.0, cell)
    y = np.arange(0.0, 14.0, cell)
    taken = np.zeros((len(y), len(x)), bool)
    for cx, cy, radius in world.circles:
        taken |= np.hypot(x - cx, (y - cy)[:, None]) <= radius
    reach = int((generator.CLEARANCE_M - 2 * cell) / cell)
    disc = np.hypot(*np.mgrid[-reach : reach + 1, -reach : reach + 1]) <= reach
    free = ~binary_dilation(taken, disc)
    regions, _ = label(free)
    start, goal = (
        regions[int((p[1]) / cell), int((p[0] + 4.5) / cell)] for p in (world.start, world.goal)
    )
    assert start != 0
    assert start == goal


def test_the_automaton_fills_what_is_surrounded_and_empties_what_is_alone():
    field = np.zeros((generator.CELLS, generator.CELLS), bool)
    field[10, 10] = True  # alone
    field[20:23, 20:23] = True
    field[21, 21] = False  # surrounded by eight
    after = generator.smoothed(field, 1)
    assert not after[10, 10]
    assert after[20:23, 20:23].all()
    assert not after[5:15, 5:15].any()


def test_generated_worlds_are_as_long_and_as_full_as_those_of_barn():
    series = [generator.generated(n) for n in range(14)]
    lengths = np.array([world.path_length_m for world in series])
    posts = np.array([len(world.circles) for world in series])
    # The given worlds of BARN: 10.05 to 13.7 m, 181 to 365 posts.
    assert (lengths >= 10.0).all()
    assert (lengths < 14.0).all()
    assert (posts >= 150).all()
    assert (posts <= 400).all()
