"""Map files: what is read from good ones, and how each kind of bad one is refused."""

import math
import struct
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from PIL import Image

import cairn
from cairn.missions.setting import load_map
from cairn.world import FREE, OCCUPIED, UNKNOWN

YAML = """\
image: m.pgm
resolution: 0.1
origin: [-1.0, 2.0, 0.5]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""
PGM = b"P2\n# drawn by hand\n3 2\n255\n254 0 205\n0 0 254\n"


def write(folder, **files):
    """Writes m.yaml and what belongs to it; returns the path of m.yaml."""
    for suffix, content in {"yaml": YAML, "pgm": PGM, **files}.items():
        data = content.encode() if isinstance(content, str) else content
        if data is not None:
            (folder / f"m.{suffix}").write_bytes(data)
    return folder / "m.yaml"


# ---- map_server ----------------------------------------------------------------------------------


def test_map_server_row_zero_is_the_images_last_row(tmp_path):
    world = cairn.maps.load(write(tmp_path))
    assert world.occupancy.tolist() == [[OCCUPIED, OCCUPIED, FREE], [FREE, OCCUPIED, UNKNOWN]]
    assert (world.resolution_m, world.origin) == (0.1, (-1.0, 2.0, 0.5))
    assert world.costs is None


@pytest.mark.parametrize(
    "pgm",
    [
        b"P5 3 2 255 " + bytes([254, 0, 205, 0, 0, 254]),
        b"P5\n#c\n3 2\n#c\n65535\n" + struct.pack(">6H", 65278, 0, 52685, 0, 0, 65278),
        b"P2 3 2 65535 65278 0 52685 0 0 65278",
    ],
)
def test_plain_and_binary_and_16_bit_images_are_the_same_map(tmp_path, pgm):
    world = cairn.maps.load(write(tmp_path, pgm=pgm))
    assert world.occupancy.tolist() == [[OCCUPIED, OCCUPIED, FREE], [FREE, OCCUPIED, UNKNOWN]]


def test_negate_swaps_black_and_white(tmp_path):
    world = cairn.maps.load(write(tmp_path, yaml=YAML.replace("negate: 0", "negate: 1")))
    assert world.occupancy.tolist() == [[FREE, FREE, OCCUPIED], [OCCUPIED, FREE, OCCUPIED]]


def test_thresholds_are_strict_as_in_map_server(tmp_path):
    # p of these shades is 0.2, 0.4 and 0.6 exactly as doubles say.
    yaml = YAML.replace("0.65", repr(1 - 102 / 255)).replace("0.196", repr(1 - 204 / 255))
    world = cairn.maps.load(write(tmp_path, yaml=yaml, pgm=b"P2 4 1 255 204 205 102 101"))
    assert world.occupancy.tolist() == [[UNKNOWN, FREE, UNKNOWN, OCCUPIED]]


def test_scale_prices_what_lies_between_the_thresholds(tmp_path):
    yaml = YAML.replace("0.65", "0.8").replace("0.196", "0.2") + "mode: scale\n"
    world = cairn.maps.load(write(tmp_path, yaml=yaml, pgm=b"P2 3 1 1000 900 500 100"))
    assert world.occupancy.tolist() == [[FREE, FREE, OCCUPIED]]
    np.testing.assert_allclose(world.costs, [[1, 1 / (1 - 0.99 / 2), 1]], rtol=1e-6)


def test_scale_takes_transparent_pixels_as_unknown_and_trinary_does_not(tmp_path):
    yaml = YAML.replace("m.pgm", "m.png")
    pixels = np.array([[[255, 255, 255, 255], [255, 255, 255, 254], [0, 0, 0, 0]]], np.uint8)
    Image.fromarray(pixels).save(tmp_path / "m.png")
    scale = cairn.maps.load(write(tmp_path, yaml=yaml + "mode: scale\n"))
    assert scale.occupancy.tolist() == [[FREE, UNKNOWN, UNKNOWN]]
    trinary = cairn.maps.load(write(tmp_path, yaml=yaml))
    assert trinary.occupancy.tolist() == [[FREE, FREE, OCCUPIED]]


def test_raw_takes_shades_as_percent_and_above_100_as_unknown(tmp_path):
    raw = write(tmp_path, yaml=YAML + "mode: raw\n", pgm=b"P2 5 1 255 0 50 100 101 255")
    world = cairn.maps.load(raw)
    assert world.occupancy.tolist() == [[FREE, FREE, OCCUPIED, UNKNOWN, UNKNOWN]]
    assert world.costs.tolist() == [[1, 2, 1, 1, 1]]


@pytest.mark.parametrize("mode", ["1", "L", "P", "RGB", "RGBA", "LA", "I;16"])
def test_png_images_of_every_mode_are_read_by_the_mean_of_their_colours(tmp_path, mode):
    if mode == "I;16":
        image = Image.fromarray(np.array([[65535, 0]], np.uint16))
    else:
        image = Image.fromarray(np.array([[255, 0]], np.uint8)).convert(mode)
    image.save(tmp_path / "m.png")
    world = cairn.maps.load(write(tmp_path, yaml=YAML.replace("m.pgm", "m.png")))
    assert world.occupancy.tolist() == [[FREE, OCCUPIED]]


def test_numbers_with_an_exponent_are_numbers_and_strange_keys_are_left_alone(tmp_path):
    yaml = YAML.replace("0.1\n", "1e-1\n") + "owner: facilities\n"
    assert cairn.maps.load(write(tmp_path, yaml=yaml)).resolution_m == 0.1


def test_goals_beside_the_map_are_read(tmp_path):
    path = write(tmp_path)
    goals = '[goals]\n"far desk" = { x = 1, y = 2.5 }\ndock = { x = 0.0, y = 0.0, heading = 1.5 }\n'
    (tmp_path / "m.goals.toml").write_text(goals)
    assert cairn.maps.load(path).goals == {"far desk": (1.0, 2.5), "dock": (0.0, 0.0, 1.5)}
    for broken in (
        "[goals",
        "goals = 3",
        "[goals]\na = { x = 1 }",
        "[goals]\na = { x = nan, y = 1 }",
    ):
        (tmp_path / "m.goals.toml").write_text(broken)
        with pytest.raises(cairn.errors.MapLineInvalid, match="goals"):
            cairn.maps.load(path)


@settings(max_examples=40, deadline=None)
@given(
    cells=arrays(
        np.uint8, st.tuples(st.integers(1, 9), st.integers(1, 9)), elements=st.integers(0, 2)
    ),
    resolution=st.floats(1e-3, 10),
    origin=st.tuples(*[st.floats(-1e3, 1e3)] * 3),
    goals=st.dictionaries(
        st.text(st.characters(exclude_categories=("Cs",))),
        st.tuples(st.floats(-9, 9), st.floats(-9, 9))
        | st.tuples(st.floats(-9, 9), st.floats(-9, 9), st.floats(-9, 9)),
        max_size=3,
    ),
)
def test_what_is_saved_is_loaded_to_the_bit(tmp_path_factory, cells, resolution, origin, goals):
    path = tmp_path_factory.mktemp("saved") / "a: #b.yaml"
    world = cairn.World(cells, resolution, origin, goals=goals)
    cairn.maps.save(world, path)
    again = cairn.maps.load(path)
    assert (again.occupancy == world.occupancy).all()
    assert (again.resolution_m, again.origin) == (world.resolution_m, world.origin)
    assert again.goals == world.goals


def test_saving_what_the_format_cannot_hold_is_refused(tmp_path):
    world = cairn.World(np.ones((1, 1), bool), costs=np.ones((1, 1)))
    with pytest.raises(cairn.errors.MapNotRepresentable):
        cairn.maps.save(world, tmp_path / "m.yaml")
    with pytest.raises(cairn.errors.MapFormatUnknown):
        cairn.maps.save(replace(world, costs=None), tmp_path / "m.tif")


@pytest.mark.parametrize(
    ("error", "files", "line", "reason"),
    [
        ("MapEmpty", {"yaml": ""}, None, "empty"),
        ("MapYamlInvalid", {"yaml": "image: [m.pgm\nresolution: 1"}, 2, "not YAML"),
        ("MapYamlInvalid", {"yaml": "- image"}, None, "keys and values"),
        ("MapTextInvalid", {"yaml": b"image: \xff\xfe"}, None, "byte 7"),
        ("MapKeyMissing", {"yaml": YAML.replace("resolution", "resolutoin")}, None, "`resolution`"),
        ("MapKeyMissing", {"yaml": YAML.replace("free_thresh", "free")}, None, "`free_thresh`"),
        ("MapKeyInvalid", {"yaml": YAML.replace("0.1\n", "0\n")}, 2, "resolution is 0"),
        ("MapKeyInvalid", {"yaml": YAML.replace("0.1\n", "-0.1\n")}, 2, "resolution is -0.1"),
        ("MapKeyInvalid", {"yaml": YAML.replace("0.1\n", ".nan\n")}, 2, "resolution is nan"),
        ("MapKeyInvalid", {"yaml": YAML.replace("0.1\n", "fine\n")}, 2, "resolution is 'fine'"),
        ("MapKeyInvalid", {"yaml": YAML.replace(", 0.5]", "]")}, 3, "yaw"),
        ("MapKeyInvalid", {"yaml": YAML.replace("0.5]", ".inf]")}, 3, "yaw"),
        ("MapKeyInvalid", {"yaml": YAML.replace("negate: 0", "negate: 2")}, 4, "0 or 1"),
        ("MapKeyInvalid", {"yaml": YAML.replace("0.196", "0.7")}, 6, "occupied_thresh"),
        ("MapKeyInvalid", {"yaml": YAML.replace("0.65", "65")}, 5, "at most 1"),
        ("MapKeyInvalid", {"yaml": YAML + "mode: shades\n"}, 7, "trinary"),
        ("MapKeyInvalid", {"yaml": YAML.replace("m.pgm", "7")}, 1, "must be text"),
        ("MapImageMissing", {"yaml": YAML.replace("m.pgm", "n.pgm")}, 1, "n.pgm"),
        ("MapImageInvalid", {"pgm": b"GIF of something"}, None, "image"),
        ("MapImageInvalid", {"pgm": b"P2 x 2 255 1 1"}, None, "width at byte 3"),
        ("MapImageInvalid", {"pgm": b"P2 1 1 0 1"}, None, "maximum is 0"),
        ("MapImageInvalid", {"pgm": b"P2 2 1 255 1 " + b"9" * 30}, None, "pixel 1"),
        ("MapKeyInvalid", {"yaml": YAML.replace("0.1\n", "9" * 400 + "\n")}, 2, "finite"),
        ("MapYamlInvalid", {"yaml": YAML + "drawn: 2001-99-99\n"}, None, "not YAML"),
        ("MapImageInvalid", {"pgm": b"P2 2 1 255 1 x"}, None, "pixel 1"),
        ("MapImageInvalid", {"pgm": b"P2 2 1 100 1 101"}, None, "column 1"),
        ("MapImageTruncated", {"pgm": PGM[:-4]}, None, "5 pixels"),
        ("MapImageTruncated", {"pgm": b"P5 3 2 255 12345"}, None, "5 pixels"),
        ("MapImageTruncated", {"pgm": b"P5 3 2"}, None, "maximum"),
        ("MapEmpty", {"pgm": b"P5 0 2 255 "}, None, "0 × 2"),
    ],
)
def test_a_bad_map_server_file_is_refused_with_file_line_and_reason(
    tmp_path, error, files, line, reason
):
    path = write(tmp_path, **files)
    with pytest.raises(getattr(cairn.errors, error), match=reason) as caught:
        cairn.maps.load(path)
    assert caught.value.line == line
    assert str(tmp_path / "m.") in str(caught.value)


def test_a_truncated_png_is_refused(tmp_path):
    noise = np.random.default_rng(1).integers(0, 255, (40, 40), np.uint8)
    Image.fromarray(noise).save(tmp_path / "m.png")
    data = (tmp_path / "m.png").read_bytes()
    path = write(tmp_path, yaml=YAML.replace("m.pgm", "m.png"), png=data[: len(data) // 2])
    with pytest.raises(cairn.errors.MapImageTruncated):
        cairn.maps.load(path)


# ---- MovingAI ------------------------------------------------------------------------------------

MOVINGAI = "type octile\nheight 2\nwidth 7\nmap\n.GS@OTW\n@@@@@@.\n"
SCEN = "version 1\n0\ta map.map\t7\t2\t0\t0\t6\t1\t6.41421356\n3\tb.map\t7\t2\t1\t0\t2\t1\t1.0\n"


def test_movingai_rows_are_the_files_y_and_cells_a_metre(tmp_path):
    path = tmp_path / "m.map"
    path.write_text(MOVINGAI)
    world = cairn.maps.load(path)
    assert world.occupancy.tolist() == [[0, 0, 0, 1, 1, 1, 1], [1, 1, 1, 1, 1, 1, 0]]
    assert (world.resolution_m, world.origin) == (1.0, (0.0, 0.0, 0.0))
    path.write_bytes(MOVINGAI.replace("\n", "\r\n").encode())
    assert (cairn.maps.load(path).occupancy == world.occupancy).all()


def test_a_map_of_one_cell_is_a_map(tmp_path):
    path = tmp_path / "m.map"
    path.write_text("type octile\nheight 1\nwidth 1\nmap\n.")
    assert cairn.maps.load(path).shape == (1, 1)


@pytest.mark.parametrize(
    ("error", "text", "line", "reason"),
    [
        ("MapEmpty", "", None, "empty"),
        ("MapFormatUnknown", "hello\n", 1, "neither"),
        ("MapKeyInvalid", MOVINGAI.replace("octile", "tile"), 1, "octile"),
        ("MapKeyInvalid", MOVINGAI.replace("height 2", "height two"), 2, "height"),
        ("MapKeyInvalid", MOVINGAI.replace("width 7", "width -7"), 3, "width"),
        ("MapKeyMissing", MOVINGAI.replace("height 2\n", ""), None, "height"),
        ("MapKeyMissing", "type octile\nheight 2\nwidth 7\n", None, "map"),
        ("MapLineInvalid", MOVINGAI.replace("width 7", "depth 7"), 3, "depth"),
        ("MapEmpty", "type octile\nheight 0\nwidth 7\nmap\n", None, "0 × 7"),
        ("MapTruncated", MOVINGAI[:-8], 5, "1 of 2 rows"),
        ("MapCountMismatch", MOVINGAI[:-3], 6, "5 characters"),
        ("MapCountMismatch", MOVINGAI + "@@@@@@.\n", 7, "too many"),
        ("MapCharacterInvalid", MOVINGAI.replace("@O", "@x"), 5, "`x` in column 5"),
    ],
)
def test_a_bad_movingai_file_is_refused_with_file_line_and_reason(
    tmp_path, error, text, line, reason
):
    path = tmp_path / "m.map"
    path.write_text(text)
    with pytest.raises(getattr(cairn.errors, error), match=reason) as caught:
        cairn.maps.load(path)
    assert (caught.value.path, caught.value.line) == (str(path), line)


def test_scen_queries_are_cells_with_the_optimal_length(tmp_path):
    path = tmp_path / "m.scen"
    path.write_text(SCEN)
    first, second = cairn.maps.load_scen(path)
    assert (first.map_name, first.shape, first.start, first.goal) == (
        "a map.map",
        (2, 7),
        (0, 0),
        (1, 6),
    )
    assert (second.bucket, second.optimal_length) == (3, 1.0)


@pytest.mark.parametrize(
    ("error", "text", "line"),
    [
        ("MapEmpty", "", None),
        ("MapKeyInvalid", SCEN.replace("version 1", "version 2"), 1),
        ("MapLineInvalid", SCEN.replace("\t1.0", ""), 3),
        ("MapLineInvalid", SCEN.replace("\t1.0", "\tnan"), 3),
        ("MapLineInvalid", SCEN.replace("\t1.0", "\t-1"), 3),
        ("MapKeyInvalid", SCEN.replace("\t6\t1\t", "\t7\t1\t"), 2),
        ("MapKeyInvalid", SCEN.replace("3\tb.map", "3.5\tb.map"), 3),
    ],
)
def test_a_bad_scen_file_is_refused_with_file_line_and_reason(tmp_path, error, text, line):
    path = tmp_path / "m.scen"
    path.write_text(text)
    with pytest.raises(getattr(cairn.errors, error)) as caught:
        cairn.maps.load_scen(path)
    assert (caught.value.path, caught.value.line) == (str(path), line)


# ---- ARIA ----------------------------------------------------------------------------------------

ARIA = """\
2D-Map
LineMinPos: 0 0
LineMaxPos: 4000 3000
NumLines: 2
MinPos: 600 500
MaxPos: 600 500
NumPoints: 1
Resolution: 20
Cairn: GoalWithHeading 1000 1000 90.000000 "" ICON "desk one"
Cairn: Goal 3000 2000 0.000000 "by the lift" ICON "lift"
Cairn: RobotHome 2500 2500 180.000000 "" ICON ""
Cairn: ForbiddenLine 0 0 0.000000 "" ICON "edge" 1000 1500 2000 1500
Cairn: ForbiddenArea 0 0 90.000000 "" ICON "stairs" 2000 -1000 2500 -500
LINES
0 0 4000 3000
0 3000 4000 3000
DATA
600 500
"""


def aria(tmp_path, text, **options):
    path = tmp_path / "m.map"
    path.write_text(text)
    return cairn.maps.load(path, **options)


def test_aria_goals_are_in_metres_and_radians(tmp_path):
    world = aria(tmp_path, ARIA)
    assert world.goals["lift"] == (3.0, 2.0)
    assert world.goals["desk one"] == pytest.approx((1.0, 1.0, math.pi / 2))
    assert world.goals["home"] == pytest.approx((2.5, 2.5, math.pi))


def test_aria_points_and_forbidden_ground_lie_where_they_should(tmp_path):
    world = aria(tmp_path, ARIA, resolution_m=0.1)
    assert world.occupancy[world.cell_of((0.65, 0.55))] == OCCUPIED
    forbidden = np.isinf(world.costs)
    # Turned by 90 degrees the area spans x 0.5..1.0, y 2.0..2.5.
    assert forbidden[world.cell_of((0.75, 2.25))]
    assert forbidden[world.cell_of((1.5, 1.5))]
    assert not forbidden[world.cell_of((2.25, 0.75))]
    assert world.occupancy[world.cell_of((0.75, 2.25))] == FREE
    assert not world.free()[world.cell_of((0.75, 2.25))]


COORDINATE = st.integers(-3000, 3000)


@settings(max_examples=80, deadline=None)
@given(COORDINATE, COORDINATE, COORDINATE, COORDINATE, st.sampled_from([0.05, 0.1, 0.13]))
def test_a_line_occupies_every_cell_that_it_passes_through_and_no_other(
    tmp_path_factory, x0, y0, x1, y1, resolution
):
    text = f"2D-Map\nNumLines: 1\nLINES\n{x0} {y0} {x1} {y1}\n"
    world = aria(tmp_path_factory.mktemp("aria"), text, resolution_m=resolution)
    t = np.linspace(0, 1, 2000)[:, None]
    points = (np.array([[x0, y0]]) * (1 - t) + np.array([[x1, y1]]) * t) / 1000
    cells = np.floor(world.grid_from_world(points) / resolution).astype(int)
    assert (world.occupancy[cells[:, 1], cells[:, 0]] == OCCUPIED).all()
    # Separating axis: no occupied cell lies wholly to one side of the line.
    along = np.array([x1 - x0, y1 - y0]) / 1000
    length = np.hypot(*along)
    across = np.array([-along[1], along[0]]) / (length or 1.0)
    centres = world.point_of(np.argwhere(world.occupancy == OCCUPIED))
    gap = np.abs((centres - points[0]) @ across)
    assert (gap <= resolution / 2 * np.abs(across).sum() + 1e-6).all()
    box = np.abs(centres - points.mean(axis=0)) - np.abs(along) / 2
    assert (box <= resolution / 2 + 1e-6).all()


@pytest.mark.parametrize(
    ("error", "text", "line", "reason"),
    [
        ("MapFormatUnknown", ARIA.replace("2D-Map", "2D-Map-Odd"), 1, "2D-Map-Odd"),
        ("MapEmpty", "2D-Map\nNumLines: 0\nLINES\n", None, "no line"),
        ("MapTruncated", ARIA.replace("NumLines: 2", "NumLines: 3"), 4, "2 follow"),
        ("MapLineInvalid", ARIA.replace("MinPos: 600 500", "MinPos: 600"), 5, "x y"),
        ("MapCountMismatch", ARIA + "1 2\n", 7, "2 follow"),
        ("MapKeyInvalid", ARIA.replace("NumLines: 2", "NumLines: two"), 4, "NumLines"),
        ("MapLineInvalid", ARIA.replace("0 0 4000 3000", "0 0 4000"), 15, "4 finite numbers"),
        ("MapLineInvalid", ARIA.replace("0 0 4000 3000", "0 0 4000 nan"), 15, "4 finite numbers"),
        ("MapLineInvalid", ARIA.replace("3000 2000 0.0", "3000 east 0.0"), 10, "lift"),
        ("MapLineInvalid", ARIA.replace('ICON "lift"', 'ICON "lift'), 10, "quote"),
        ("MapLineInvalid", ARIA.replace('ICON "lift"', "ICON"), 10, "Cairn"),
        ("MapLineInvalid", ARIA.replace('"lift"', '"desk one"'), 10, "second goal"),
        ("MapLineInvalid", ARIA.replace(" 1000 1500 2000 1500", " 1000"), 12, "ends"),
        ("MapLineInvalid", ARIA.replace("Resolution: 20", "Resolution 20"), 8, "Key: value"),
        ("MapTooLarge", ARIA.replace("4000 3000\n0", "1e308 -1e308\n0"), None, "cells"),
        ("MapTooLarge", ARIA.replace("4000 3000\n0", "4e9 3e9\n0"), None, "cells"),
    ],
)
def test_a_bad_aria_file_is_refused_with_file_line_and_reason(tmp_path, error, text, line, reason):
    with pytest.raises(getattr(cairn.errors, error), match=reason) as caught:
        aria(tmp_path, text)
    assert caught.value.line == line


# ---- numpy and the rest --------------------------------------------------------------------------


def test_arrays_are_free_space_costs_or_kinds_by_their_type(tmp_path):
    def load(array):
        np.save(tmp_path / "m.npy", np.array(array))
        return cairn.maps.load(tmp_path / "m.npy", resolution_m=0.5)

    assert load([[True, False]]).occupancy.tolist() == [[FREE, OCCUPIED]]
    assert load([[0, 1, 2]]).occupancy.tolist() == [[FREE, OCCUPIED, UNKNOWN]]
    world = load([[1.5, np.inf]])
    assert world.costs.tolist() == [[1.5, np.inf]]
    assert world.occupancy.tolist() == [[FREE, OCCUPIED]]
    assert world.resolution_m == 0.5


@pytest.mark.parametrize(
    ("error", "array"),
    [
        ("MapLineInvalid", np.ones(3)),
        ("MapLineInvalid", np.array([["a"]])),
        ("MapLineInvalid", np.array([[np.nan]])),
        ("MapLineInvalid", np.array([[-1.0]])),
        ("MapLineInvalid", np.array([[7]])),
        ("MapEmpty", np.ones((0, 4))),
    ],
)
def test_an_array_that_is_no_map_is_refused(tmp_path, error, array):
    np.save(tmp_path / "m.npy", array)
    with pytest.raises(getattr(cairn.errors, error), match=r"m\.npy"):
        cairn.maps.load(tmp_path / "m.npy")
    (tmp_path / "m.npy").write_bytes(b"\x93NUMPY\x01")
    with pytest.raises(cairn.errors.MapLineInvalid, match="not a numpy array"):
        cairn.maps.load(tmp_path / "m.npy")


@pytest.mark.parametrize("taken", [lambda path: path.mkdir(), lambda path: path.touch()])
def test_what_has_the_name_of_a_shipped_world_does_not_hide_it(tmp_path, monkeypatch, taken):
    monkeypatch.chdir(tmp_path)
    for name in cairn.maps.shipped():
        taken(tmp_path / name)
        there = cairn.maps.load(cairn.maps.shipped_path(name))
        for world in (cairn.maps.load(name), load_map(name, tmp_path)):
            assert (world.name, world.resolution_m) == (there.name, there.resolution_m)
            assert np.array_equal(world.occupancy, there.occupancy)
        with pytest.raises(cairn.errors.MapNotFound):
            cairn.maps.load(f"elsewhere/{name}")


def test_unknown_kinds_and_missing_files_say_what_would_be_right(tmp_path):
    (tmp_path / "m.tif").write_bytes(b"II*\0")
    with pytest.raises(cairn.errors.MapFormatUnknown, match="map_server"):
        cairn.maps.load(tmp_path / "m.tif")
    with pytest.raises(cairn.errors.MapNotFound, match=r"x\.yaml"):
        cairn.maps.load(tmp_path / "x.yaml")
    with pytest.raises(cairn.errors.MapNotFound, match="office"):
        cairn.maps.load("offise")
    with pytest.raises(cairn.errors.MapKeyInvalid, match="says its own"):
        cairn.maps.load("office", resolution_m=0.1)
