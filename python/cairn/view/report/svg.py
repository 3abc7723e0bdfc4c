"""Charts over time as SVG whose colours come from the page's style sheet, so that they follow "
"its theme."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np
from markupsafe import Markup
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

Floats = NDArray[np.float64]
WIDTH, LEFT, RIGHT, TOP, BOTTOM = 1000.0, 62.0, 14.0, 10.0, 22.0
POINTS_AT_MOST = 1500


@dataclass(frozen=True)
class Line:
    """Values over time, drawn in the colour of a class; gaps where they are not finite."""

    kind: str
    values: Floats
    name: str = ""
    dots: bool = False


@dataclass(frozen=True)
class Band:
    """The room between two values over time."""

    kind: str
    low: Floats
    high: Floats
    name: str = ""


@dataclass
class Chart:
    """One chart: values of one unit over the time of a run.

    Args:
        title: what it shows, with the unit.
        time_s: (n,) of all values.
        lines, bands: drawn over each other in this order, bands first.
        marks: (time, class, what to say) as upright lines.
        limits: horizontal lines (value, name).
        low, high: of the values; by default what they need.
        note: a sentence under the title.
        image: a picture (class, data address) stretched over all of it, behind the lines.
    """

    title: str
    time_s: Floats
    lines: Sequence[Line] = ()
    bands: Sequence[Band] = ()
    marks: Sequence[tuple[float, str, str]] = ()
    limits: Sequence[tuple[float, str]] = ()
    low: float | None = None
    high: float | None = None
    height: float = 130.0
    note: str = ""
    image: str = ""
    legend: list[tuple[str, str]] = field(default_factory=list)

    def range(self) -> tuple[float, float]:
        """Least and greatest value shown."""
        shown = [line.values for line in self.lines]
        shown += [part for band in self.bands for part in (band.low, band.high)]
        shown.append(np.array([value for value, _ in self.limits], float))
        values = np.concatenate(shown) if shown else np.zeros(1)
        values = values[np.isfinite(values)]
        least, most = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
        low = least if self.low is None else self.low
        high = most if self.high is None else self.high
        if high - low < 1e-9:
            high = low + 1.0
        spare = 0.06 * (high - low)
        return (
            low - spare if self.low is None else low,
            high + spare if self.high is None else high,
        )


def x_of(time_s: float, end_s: float) -> float:
    """Where a time stands on a chart."""
    return LEFT + (WIDTH - LEFT - RIGHT) * time_s / max(end_s, 1e-9)


def drawn(chart: Chart, pieces: Sequence[tuple[str, float, float]], end_s: float) -> Markup:
    """Return a chart as SVG, modes shaded behind it.

    Args:
        chart: what to draw.
        pieces: (mode, from, to) [s].
        end_s: of the run; all its charts share it.
    """
    svg = _canvas(chart.height)
    low, high = chart.range()
    bottom = chart.height - BOTTOM

    def y_of(value: float) -> float:
        return bottom - (bottom - TOP) * (value - low) / (high - low)

    for mode, begin, end in pieces:
        SubElement(svg, "rect", {
            "class": f"shade {mode}", "x": _n(x_of(begin, end_s)), "y": _n(TOP),
            "width": _n(x_of(end, end_s) - x_of(begin, end_s)), "height": _n(bottom - TOP),
        })  # fmt: skip
    if chart.image:
        SubElement(svg, "image", {
            "href": chart.image, "x": _n(LEFT), "y": _n(TOP), "width": _n(WIDTH - LEFT - RIGHT),
            "height": _n(bottom - TOP), "preserveAspectRatio": "none", "class": "heat",
        })  # fmt: skip
    for value in MaxNLocator(4).tick_values(low, high):
        if low - 1e-9 <= value <= high + 1e-9:
            _rule(svg, y_of(value), "grid")
            _text(svg, LEFT - 7, y_of(value) + 4, f"{value:g}", "tick right")
    _time_axis(svg, end_s, bottom)
    for value, name in chart.limits:
        _rule(svg, y_of(value), "limit")
        _text(svg, LEFT + 5, y_of(value) - 3, name, "tick")
    for band in chart.bands:
        _draw_band(svg, chart.time_s, band, end_s, y_of)
    for line in chart.lines:
        _draw_line(svg, chart.time_s, line, end_s, y_of, low, high)
    for time_s, kind, said in chart.marks:
        mark = SubElement(svg, "line", {
            "class": f"mark {kind}", "x1": _n(x_of(time_s, end_s)), "x2": _n(x_of(time_s, end_s)),
            "y1": _n(TOP), "y2": _n(bottom),
        })  # fmt: skip
        SubElement(mark, "title").text = said
    _cursor(svg, bottom)
    return as_markup(svg)


def strip(
    pieces: Sequence[tuple[str, float, float]], names: dict[str, str], end_s: float
) -> Markup:
    """Return the modes over time as one strip with their names where there is room."""
    svg = _canvas(46.0)
    for mode, begin, end in pieces:
        width = x_of(end, end_s) - x_of(begin, end_s)
        piece = SubElement(svg, "rect", {
            "class": f"piece {mode}", "x": _n(x_of(begin, end_s)), "y": "2",
            "width": _n(max(width, 0.6)), "height": "20",
        })  # fmt: skip
        name = names.get(mode, mode)
        SubElement(piece, "title").text = f"{name}, {begin:.1f} to {end:.1f} s"
        if width > 9 * len(name):
            _text(svg, x_of(begin, end_s) + width / 2, 16, name, "onpiece")
    _time_axis(svg, end_s, 24.0)
    _cursor(svg, 24.0)
    return as_markup(svg)


def as_markup(svg: Element) -> Markup:
    """Return an element as text for a template; everything in it is escaped already."""
    return Markup(tostring(svg, encoding="unicode"))


def _canvas(height: float) -> Element:
    return Element("svg", {
        "class": "chart", "viewBox": f"0 0 {WIDTH:g} {height:g}", "role": "img",
        "data-left": f"{LEFT:g}", "data-right": f"{WIDTH - RIGHT:g}",
    })  # fmt: skip


def _time_axis(svg: Element, end_s: float, bottom: float) -> None:
    _rule(svg, bottom, "axis")
    for value in MaxNLocator(12, steps=[1, 2, 5, 10]).tick_values(0.0, end_s):
        if 0 <= value <= end_s:
            _text(svg, x_of(value, end_s), bottom + 14, f"{value:g} s", "tick middle")


def _cursor(svg: Element, bottom: float) -> None:
    SubElement(svg, "line", {
        "class": "cursor", "x1": "0", "x2": "0", "y1": "0", "y2": _n(bottom),
        "transform": f"translate({LEFT:g} 0)",
    })  # fmt: skip


def _rule(svg: Element, y: float, kind: str) -> None:
    SubElement(svg, "line", {
        "class": kind, "x1": _n(LEFT), "x2": _n(WIDTH - RIGHT), "y1": _n(y), "y2": _n(y),
    })  # fmt: skip


def _text(svg: Element, x: float, y: float, text: str, kind: str) -> None:
    SubElement(svg, "text", {"class": kind, "x": _n(x), "y": _n(y)}).text = text


def _draw_line(
    svg: Element, time_s: Floats, line: Line, end_s: float, y_of, low: float, high: float
) -> None:
    times, values = thinned(time_s, line.values)
    values = np.where(np.isfinite(values), np.clip(values, low, high), np.nan)
    if line.dots:
        good = np.isfinite(values)
        dots = zip(times[good], values[good], strict=True)
        marks = [f"M{_n(x_of(t, end_s))} {_n(y_of(v))}h0" for t, v in dots]
        SubElement(svg, "path", {"class": f"dots {line.kind}", "d": "".join(marks) or "M0 0"})
        return
    steps, pen_down = [], False
    for t, v in zip(times, values, strict=True):
        if np.isfinite(v):
            steps.append(f"{'L' if pen_down else 'M'}{_n(x_of(t, end_s))} {_n(y_of(v))}")
        pen_down = bool(np.isfinite(v))
    SubElement(svg, "path", {"class": f"line {line.kind}", "d": "".join(steps) or "M0 0"})


def _draw_band(svg: Element, time_s: Floats, band: Band, end_s: float, y_of) -> None:
    good = np.isfinite(band.low) & np.isfinite(band.high)
    if not good.any():
        return
    times, highs = thinned(time_s[good], band.high[good])
    times_back, lows = thinned(time_s[good], band.low[good])
    there = [f"{_n(x_of(t, end_s))},{_n(y_of(v))}" for t, v in zip(times, highs, strict=True)]
    back = [f"{_n(x_of(t, end_s))},{_n(y_of(v))}" for t, v in zip(times_back, lows, strict=True)]
    points = " ".join([*there, *reversed(back)])
    SubElement(svg, "polygon", {"class": f"band {band.kind}", "points": points})


def thinned(time_s: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Leave out points of a long line, but never the least or the greatest of a stretch."""
    if len(values) <= POINTS_AT_MOST:
        return time_s, values
    parts = np.array_split(np.arange(len(values)), POINTS_AT_MOST // 2)
    kept: list[int] = []
    for part in parts:
        good = part[np.isfinite(values[part])]
        if len(good):
            kept += sorted({int(good[values[good].argmin()]), int(good[values[good].argmax()])})
        else:
            kept.append(int(part[0]))
    return time_s[kept], values[kept]


def _n(value: float) -> str:
    """A coordinate, as short as it may be."""
    return f"{value:.1f}".rstrip("0").rstrip(".")
