"""Grey images in Netpbm's PGM format, plain (P2) and binary (P5), of 8 and 16 bits."""

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cairn import errors
from cairn.maps.source import refuse

# A number after white space and comments; one white space ends the header of P5.
_NUMBER = re.compile(rb"(?:\s|#[^\r\n]*[\r\n])+([^\s#]+)")


def read_pgm(path: Path) -> NDArray[np.float64]:
    """Shades 0..1 (rows, cols), first row on top.

    Raises:
        MapImageInvalid: the header or a sample is not usable.
        MapImageTruncated: there are fewer samples than width × height.
        MapEmpty: width or height is 0.
    """
    data = path.read_bytes()
    image = str(path)
    header, at = [], 2
    for what in ("width", "height", "maximum"):
        found = _NUMBER.match(data, at)
        if found is None:
            reason = f"the header ends at byte {at}, before the {what}"
            refuse(errors.MapImageTruncated, path, reason, image=image)
        if not found[1].isdigit() or len(found[1]) > 9:
            reason = f"{what} at byte {found.start(1)} is {found[1][:20]!r}, not a whole number"
            refuse(errors.MapImageInvalid, path, reason, image=image)
        header.append(int(found[1]))
        at = found.end()
    width, height, maximum = header
    if width * height == 0:
        refuse(errors.MapEmpty, path, f"the image is {width} × {height} pixels")
    if not 0 < maximum < 65536:
        reason = f"maximum is {maximum}, must be 1 to 65535"
        refuse(errors.MapImageInvalid, path, reason, image=image)

    if data[:2] == b"P5":
        kind = np.dtype(np.uint8 if maximum < 256 else ">u2")
        body = data[at + 1 :]
        samples = np.frombuffer(body[: len(body) - len(body) % kind.itemsize], kind)
    else:
        words = re.sub(rb"#[^\r\n]*", b"", data[at:]).split()
        bad = next((i for i, word in enumerate(words) if not word.isdigit() or len(word) > 9), None)
        if bad is not None:
            reason = f"pixel {bad} is {words[bad][:20]!r}, not a whole number"
            refuse(errors.MapImageInvalid, path, reason, image=image)
        samples = np.array([int(word) for word in words], np.uint64)
    if samples.size < width * height:
        reason = f"{samples.size} pixels where the header says {width} × {height}"
        refuse(errors.MapImageTruncated, path, reason, image=image)
    shades = samples[: width * height].reshape(height, width)
    if (shades > maximum).any():
        row, col = (int(v) for v in np.argwhere(shades > maximum)[0])
        value = shades[row, col]
        reason = f"pixel at row {row}, column {col} is {value}, above the maximum {maximum}"
        refuse(errors.MapImageInvalid, path, reason, image=image)
    return shades / float(maximum)
