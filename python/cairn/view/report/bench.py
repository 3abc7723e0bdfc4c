"""The report of a benchmark, from the record that its command leaves in `summary.json`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement

from markupsafe import Markup

from cairn.view.report.pages import rendered, written
from cairn.view.report.run import Fact, words
from cairn.view.report.svg import as_markup

ROWS_AT_MOST = 400
LEFT, RIGHT, ROW = 190.0, 90.0, 19.0
OUTCOMES = (
    ("success", "track", "arrived"),
    ("collision", "avoid", "touched"),
    ("timeout", "box", "too late"),
    ("error", "plan", "error"),
)


@dataclass(frozen=True)
class Table:
    """Rows of text under a title; `numbers` says which columns are."""

    title: str
    columns: list[str]
    rows: list[list[str]]
    numbers: set[int] = field(default_factory=set)
    left_out: int = 0


@dataclass(frozen=True)
class Bars:
    """A chart of one bar per row, ready to be put into the page."""

    title: str
    svg: Markup
    note: str = ""
    legend: Sequence[tuple[str, str]] = ()


def write_bench(record: Mapping[str, Any], path: Path, *, source: str = "") -> Path:
    """Write the report of a benchmark as one HTML file that needs nothing else.

    Args:
        record: of `cairn bench nav` or `cairn bench plan`; of another benchmark, its numbers are
            shown as tables.
        path: the file.
        source: where the record is from, told at the end.

    Returns:
        `path`.
    """
    if "worlds" in record and "by_difficulty" in record:
        values = _nav(record)
    elif "cases" in record and "geometric_mean_ratio" in record.get("summary", {}):
        values = _plan(record)
    else:
        values = _any(record)
    made_from = [f"record {source}"] if source else []
    made_from += [
        f"{words(key)} {value}"
        for key, value in {**record.get("machine", {}), **record.get("settings", {})}.items()
        if isinstance(value, str | int | float)
    ]
    if "version" in record:
        made_from.append(f"Cairn {record['version']}")
    return written(
        rendered("bench.html", **values, made_from="; ".join(made_from) or "a record"), path
    )


# ---- navigation ----------------------------------------------------------------------------------


def _nav(record: Mapping[str, Any]) -> dict[str, Any]:
    told = record["summary"]
    arrived = round(told["success"] * told["trials"])
    facts = [
        Fact("arrived", f"{100 * told['success']:.1f} %", _between(told["success_95"], 100, "%")),
        Fact("touched something", f"{100 * told['collision']:.1f} %",
             kind="bad" if told["collision"] else ""),
        Fact("too late", f"{100 * told['timeout']:.1f} %"),
        Fact("errors", f"{100 * told['error']:.1f} %", kind="bad" if told["error"] else ""),
        Fact("score", f"{told['score']:.4f}", _between(told["score_95"])),
        Fact("time of arrivals", "–" if told["time_s"] is None else f"{told['time_s']:.1f} s",
             "mean"),
        Fact("a decision", f"{record['wall']['tick_mean_ms']:.2f} ms",
             f"99 of 100 within {record['wall']['tick_p99_ms']:.1f} ms"),
    ]  # fmt: skip
    failed = [trial for trial in record.get("trials", ()) if trial["outcome"] != "success"]
    tables = []
    if record["by_difficulty"]:
        rows = [[name, *_figures(one)] for name, one in record["by_difficulty"].items()]
        columns = ["difficulty", "worlds", "trials", "arrived", "touched", "too late", "score"]
        tables.append(Table("By difficulty", columns, rows, set(range(1, 7))))
    if failed:
        rows = [
            [
                one["world"],
                str(one["trial"]),
                one["outcome"],
                one["reason"],
                f"{one['time_s']:.1f} s",
            ]
            for one in failed
        ]
        tables.append(
            Table("Trials that did not arrive", ["world", "trial", "outcome", "why", "time"],
                  rows[:ROWS_AT_MOST], {1, 4}, max(len(rows) - ROWS_AT_MOST, 0))
        )  # fmt: skip
    return {
        "title": f"{record['stack']} in {told['worlds']} worlds",
        "verdict": f"{arrived} of {told['trials']} arrived",
        "good": arrived == told["trials"],
        "sentence": f"{record['stack']} on {record['robot']}, {record['source']}, "
        f"{record['trials_per_world']} trials a world, seed {record['seed']}.",
        "caveat": told.get("caveat", ""),
        "facts": facts,
        "charts": [_outcomes(record["worlds"]), *_times(record["worlds"])],
        "tables": tables,
    }


def _figures(one: Mapping[str, Any]) -> list[str]:
    shares = [f"{100 * one[key]:.1f} %" for key in ("success", "collision", "timeout")]
    return [str(one["worlds"]), str(one["trials"]), *shares, f"{one['score']:.4f}"]


def _outcomes(worlds: Sequence[Mapping[str, Any]]) -> Bars:
    """How the trials of every world ended; worlds where all arrived are put together."""
    clean = [one for one in worlds if not any(one[kind] for kind, *_ in OUTCOMES[1:])]
    shown = list(worlds) if len(worlds) <= 60 else [one for one in worlds if one not in clean]
    rows = [
        (one["world"], [(colour, one[kind]) for kind, colour, _ in OUTCOMES], f"{one['score']:.3f}")
        for one in shown[:ROWS_AT_MOST]
    ]
    note = "A bar per world, by how its trials ended; its score at the right."
    if len(shown) < len(worlds):
        note += f" In {len(clean)} more worlds every trial arrived."
    if not rows:
        rows = [("all worlds", [("track", sum(one["success"] for one in worlds))], "")]
    legend = [(colour, name) for _, colour, name in OUTCOMES]
    return Bars("How every world went", stacked(rows), note, legend)


def _times(worlds: Sequence[Mapping[str, Any]]) -> list[Bars]:
    """Times of arrival as a histogram over worlds."""
    times = [one["time_s"] for one in worlds if one["time_s"] is not None]
    if len(times) < 5:
        return []
    low, high = min(times), max(times)
    bins = min(20, max(5, round(math.sqrt(len(times)))))
    step = max((high - low) / bins, 1e-9)
    counts = [0] * bins
    for time in times:
        counts[min(int((time - low) / step), bins - 1)] += 1
    rows = [
        (f"{low + n * step:.1f}–{low + (n + 1) * step:.1f} s", [("track", count)], str(count))
        for n, count in enumerate(counts)
    ]
    return [Bars("How long arrivals took", stacked(rows), "Worlds by the mean time of arrival.")]


# ---- plans ---------------------------------------------------------------------------------------


def _plan(record: Mapping[str, Any]) -> dict[str, Any]:
    told, cases = record["summary"], record["cases"]
    peers = list(dict.fromkeys(name for case in cases for name in case["contenders"]))
    rows = [
        (_case(case), [("track", case["ratio"])], f"{case['ratio']:.1f} ×")
        for case in cases
        if case["ratio"]
    ]
    table = [
        [
            _case(case),
            f"{100 * case['reached']:.0f} %",
            *(_ns(case["contenders"].get(name)) for name in peers),
        ]
        for case in cases
    ]
    facts = [
        Fact("Dial ÷ Cairn", _times_of(told["geometric_mean_ratio"]), "geometric mean"),
        Fact("least", _times_of(told["lowest_ratio"]), str(told["lowest_ratio_case"] or "")),
        Fact("scipy ÷ Cairn", _times_of(told["geometric_mean_ratio_scipy"]), "geometric mean"),
        Fact("aims met", f"{told['aims_met']} of {told['aims']}"),
        Fact("cases", str(told["cases"])),
    ]
    differs = [Table("Answers that differ", ["case"], [[line] for line in told["differs"]])]
    return {
        "title": "Plans on grids",
        "verdict": "every answer equal" if told["agree"] else "ANSWERS DIFFER",
        "good": bool(told["agree"]),
        "sentence": "The field of every cell to one goal, beside the planners of others.",
        "caveat": "Times are medians, per cell of the map, blocked ones too.",
        "facts": facts,
        "charts": [
            Bars("How many times faster than Dial", stacked(rows), "A bar per map, by its kind.")
        ],
        "tables": [
            *(differs if told["differs"] else []),
            Table("Nanoseconds per cell", ["map", "reached", *peers], table,
                  set(range(1, 2 + len(peers)))),
        ],
    }  # fmt: skip


def _case(case: Mapping[str, Any]) -> str:
    corners = ", corners cut" if case.get("corner_cutting") else ""
    return f"{words(case['class'])}, {case['size']}²{corners}"


def _ns(contender: Mapping[str, Any] | None) -> str:
    value = None if contender is None else contender["median_ns_per_cell"]
    return "–" if value is None else f"{value:.1f}"


def _times_of(value: float | None) -> str:
    return "–" if value is None else f"{value:.1f} ×"


# ---- any other -----------------------------------------------------------------------------------


def _any(record: Mapping[str, Any]) -> dict[str, Any]:
    """Numbers of the summary as facts, every list of like things as a table."""
    told = record.get("summary", {})
    facts = [Fact(words(key), _text(value)) for key, value in told.items() if _is_plain(value)]
    rest = {key: value for key, value in {**told, **record}.items() if key != "summary"}
    tables = []
    for name, value in rest.items():
        rows = value if isinstance(value, list) else None
        if (
            isinstance(value, Mapping)
            and value
            and all(isinstance(v, Mapping) for v in value.values())
        ):
            rows = [{"name": key, **one} for key, one in value.items()]
        if rows and all(isinstance(row, Mapping) for row in rows):
            tables.append(_table_of(words(name), rows))
    return {
        "title": "Benchmark",
        "verdict": "",
        "good": False,
        "sentence": words(str(told.get("sentence", "The numbers of a record."))),
        "caveat": "",
        "facts": facts,
        "charts": [],
        "tables": tables,
    }


def _table_of(title: str, rows: Sequence[Mapping[str, Any]]) -> Table:
    columns = [
        key for key in dict.fromkeys(key for row in rows for key in row)
        if all(_is_plain(row.get(key)) for row in rows)
    ]  # fmt: skip
    numbers = {
        place for place, key in enumerate(columns)
        if all(isinstance(row.get(key), int | float | None) for row in rows)
    }  # fmt: skip
    told = [[_text(row.get(key)) for key in columns] for row in rows[:ROWS_AT_MOST]]
    left_out = max(len(rows) - ROWS_AT_MOST, 0)
    return Table(title, [words(key) for key in columns], told, numbers, left_out)


def _is_plain(value: Any) -> bool:
    return value is None or isinstance(value, str | int | float)


def _text(value: Any) -> str:
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _between(interval: Sequence[float], times: float = 1.0, unit: str = "") -> str:
    low, high = (times * value for value in interval)
    text = f"{low:.1f} to {high:.1f} {unit}" if unit else f"{low:.3f} to {high:.3f}"
    return f"95 %: {text}"


def stacked(rows: Sequence[tuple[str, Sequence[tuple[str, float]], str]]) -> Markup:
    """Return bars as SVG: (name, parts as (colour, length), what to say at the right)."""
    most = max((sum(length for _, length in parts) for _, parts, _ in rows), default=1.0) or 1.0
    height = ROW * len(rows) + 6
    svg = Element("svg", {
        "class": "chart bars", "viewBox": f"0 0 1000 {height:g}", "role": "img",
    })  # fmt: skip
    for number, (name, parts, said) in enumerate(rows):
        y = ROW * number + 3
        text = {"class": "right", "x": f"{LEFT - 8:g}", "y": f"{y + 12:g}"}
        SubElement(svg, "text", text).text = name
        x = LEFT
        for colour, length in parts:
            width = (1000 - LEFT - RIGHT) * length / most
            if width > 0:
                bar = SubElement(svg, "rect", {
                    "x": f"{x:.1f}", "y": f"{y:g}", "width": f"{width:.1f}",
                    "height": f"{ROW - 5:g}", "rx": "2", "style": f"fill: var(--{colour})",
                })  # fmt: skip
                SubElement(bar, "title").text = f"{name}: {length:g}"
            x += width
        SubElement(svg, "text", {"x": f"{x + 8:.1f}", "y": f"{y + 12:g}"}).text = said
    return as_markup(svg)
