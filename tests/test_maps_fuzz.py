"""Whatever bytes a map file holds, it is either a world or refused by name."""

import contextlib
import io

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

import cairn

YAML = (
    b"image: m.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\n"
    b"occupied_thresh: 0.65\nfree_thresh: 0.196\nmode: scale\n"
)
PNG = io.BytesIO()
Image.fromarray(np.arange(48, dtype=np.uint8).reshape(6, 8)).save(PNG, "PNG")
NPY = io.BytesIO()
np.save(NPY, np.ones((2, 3)))
GOOD = {
    "m.yaml": YAML,
    "m.pgm": b"P5 3 2 255 123456",
    "plain.pgm": b"P2\n3 2\n255\n1 2 3\n4 5 6\n",
    "m.png": PNG.getvalue(),
    "m.npy": NPY.getvalue(),
    "m.scen": b"version 1\n0\tm.map\t3\t2\t0\t0\t2\t1\t2.41421356\n",
    "octile.map": b"type octile\nheight 2\nwidth 3\nmap\n.G@\n.ST\n",
    "aria.map": (
        b'2D-Map\nNumLines: 1\nNumPoints: 1\nCairn: GoalWithHeading 1 2 3 "" ICON "a"\n'
        b'Cairn: ForbiddenArea 0 0 9 "" ICON "b" 1 2 3 4\nLINES\n0 0 99 70\nDATA\n5 6\n'
    ),
    "m.goals.toml": b'[goals]\na = { x = 1, y = 2 }\n"b c" = { x = 1, y = 2, heading = 3 }\n',
}
EDITS = st.lists(
    st.tuples(st.integers(0, 400), st.integers(0, 4), st.binary(max_size=4)), max_size=4
)


@pytest.mark.parametrize("name", GOOD)
@settings(max_examples=60, deadline=None)
@given(edits=EDITS)
def test_a_damaged_file_is_a_world_or_refused_by_name(tmp_path_factory, name, edits):
    folder = tmp_path_factory.mktemp("fuzz")
    for other, data in GOOD.items():
        (folder / other).write_bytes(data)
    data = GOOD[name]
    for at, gone, new in edits:
        at %= len(data) + 1
        data = data[:at] + new + data[at + gone :]
    (folder / name).write_bytes(data)
    kind = name.rpartition(".")[2]
    if kind in ("pgm", "png"):
        (folder / "m.yaml").write_bytes(YAML.replace(b"m.pgm", name.encode()))
    opened = "m.yaml" if kind in ("pgm", "png", "toml") else name
    load = cairn.maps.load_scen if kind == "scen" else cairn.maps.load
    with contextlib.suppress(cairn.errors.MapError):
        load(folder / opened)
