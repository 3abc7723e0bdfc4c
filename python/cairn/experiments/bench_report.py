"""A benchmark's record as Markdown."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

HEAD = """# Benchmarks

## Plans on grids

The field of every cell to one goal: cost-to-go and next cell. The command above a table makes it
again, and with `--markdown` writes it here. Figures are medians, with the least and most of the
runs in brackets.

- **Dial**: our own plain bucket queue [Dial69] on the same integers, flat arrays used again: one
  bucket per unit of cost on free grids, buckets of 1024 units on weights (one per unit is five
  times slower there). **Wide**: the same with buckets as wide as the cheapest link [Denardo79].
- **Cairn**: the solver in Rust with its memory kept from run to run, one thread; set-up and
  row-major field and policy included. **Python**: `cairn.plan_grid`, conversion and fresh arrays
  included.
- ns are per cell of the map, blocked ones too. **Copy**: time to copy one uint32 per cell, as a
  share of the solve. **Memory**: peak of a first plan, over input + output. **2 threads**: how
  much faster than one.
- Weights are solved in float32 by Cairn and in integers by Dial; the answers are compared with Dial
  and heap in float32 to the bit, and with the integers within a tolerance.
- *Cutting*: diagonals may pass between blocked cells; *strict*: they may not (the default).
- scipy: `csgraph.dijkstra`, sparse matrix ready; scikit-image: `MCP_Geometric`; xarray-spatial:
  `cost_distance`. The last two always cut corners.
- Terrain is priced on the fly by the energy of a P3-AT, in float32; Dial is given the moves that
  the limits allow, Cairn finds them.
"""

COLUMNS = (
    "map", "size", "corners", "Dial ÷ Cairn", "Cairn ns", "aim ns", "Python ns", "2 threads",
    "copy", "memory", "Dial ns", "wide ns", "heap ns", "scipy ns", "scikit-image ns",
    "xarray-spatial ns",
)  # fmt: skip


def written(path: Path, name: str, section: str) -> None:
    """Put a section of BENCHMARKS.md in the place of the last one of its name.

    What stands between `<!-- NAME -->` and `<!-- end of NAME -->` is replaced, the rest of the file
    kept; a section that was not there is added at the end, a file that was not there begun.
    """
    text = path.read_text(encoding="utf-8") if path.exists() else HEAD
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    block = f"{begin}\n{section}{end}"
    if begin in text and end in text:
        before, _, rest = text.partition(begin)
        _, _, after = rest.partition(end)
        text = before + block + after
    else:
        text = text.rstrip() + f"\n\n{block}\n"
    path.write_text(text, encoding="utf-8")


def plans_section(record: dict[str, Any], command: str) -> str:
    """What `cairn bench plan` found."""
    lines = [f"`{command}`", ""]
    lines += [f"- {line}" for line in machine_lines(record["machine"])]
    lines += [f"- {line}" for line in summary_lines(record["summary"])]
    lines += ["", *table(COLUMNS, [row(case) for case in record["cases"]])]
    left_out = skipped(record)
    if left_out:
        lines += ["", "Left out: " + "; ".join(f"{why} ({count})" for why, count in left_out) + "."]
    return "\n".join(lines) + "\n"


def maps_section(record: dict[str, Any], command: str) -> str:
    """What `cairn bench movingai` found."""
    lines = [f"`{command}`", ""]
    lines += [f"- {line}" for line in machine_lines(record["machine"])]
    lines += [f"- {maps_line(record['summary'])}", ""]
    lines += table(MAP_COLUMNS, [map_row(each) for each in record["maps"]])
    return "\n".join(lines) + "\n"


GRAPH_COLUMNS = (
    "graph", "nodes", "links", "scipy ÷ Cairn", "Cairn ms", "ns per link", "2 threads", "scipy ms",
)  # fmt: skip


def graphs_section(record: dict[str, Any], command: str) -> str:
    """What `cairn bench graph` found."""
    lines = [f"`{command}`", ""]
    lines += [f"- {line}" for line in machine_lines(record["machine"])]
    lines += [f"- {graphs_line(record['summary'])}", ""]
    lines += table(GRAPH_COLUMNS, [graph_row(each) for each in record["graphs"]])
    return "\n".join(lines) + "\n"


def graph_row(each: dict[str, Any]) -> list[str]:
    """One graph, as text by `GRAPH_COLUMNS`."""
    mine, scipy = (each["contenders"].get(name) for name in ("cairn", "scipy"))
    return [
        each["graph"],
        f"{each['nodes']:,}",
        f"{each['links']:,}",
        times(each["ratio_scipy"]),
        spread(mine, "_ms"),
        number(mine["ns_per_link"]),
        times(each["two_threads"], 2),
        spread(scipy, "_ms"),
    ]


def graphs_line(summary: dict[str, Any]) -> str:
    """What all graphs come to."""
    agree = "every answer equal to the bit" if summary["agree"] else "ANSWERS DIFFER"
    return (
        f"scipy ÷ Cairn: geometric mean {times(summary['geometric_mean_ratio_scipy'])}, "
        f"both end to end in Python; {agree}"
    )


REPAIR_COLUMNS = (
    "map", "size", "change", "anew ÷ repair", "there ms", "back ms", "anew ms", "gave up",
)  # fmt: skip


def repairs_section(record: dict[str, Any], command: str) -> str:
    """What `cairn bench repair` found."""
    lines = [f"`{command}`", ""]
    lines += [f"- {line}" for line in machine_lines(record["machine"])]
    lines += [f"- {repairs_line(record['summary'])}", ""]
    lines += table(REPAIR_COLUMNS, [repair_row(each) for each in record["maps"]])
    return "\n".join(lines) + "\n"


def repair_row(each: dict[str, Any]) -> list[str]:
    """One map, as text by `REPAIR_COLUMNS`."""
    return [
        each["class"],
        f"{each['size']}²",
        each["change"],
        times(each["ratio"]),
        *(spread(each[key], "") for key in ("there_ms", "back_ms", "full_ms")),
        f"{each['solved_anew']} of {each['changes']}",
    ]


def repairs_line(summary: dict[str, Any]) -> str:
    """What all changes come to."""
    agree = "every answer equal to the bit" if summary["agree"] else "ANSWERS DIFFER"
    return (
        f"{summary['changes']} local changes, {number(summary['median_ms'])} ms in the median; "
        f"{summary['solved_anew']} solved anew; {agree}"
    )


def table(columns: Sequence[str], rows: list[list[str]]) -> list[str]:
    """Lines of a table, the first column to the left, the others to the right."""
    head = ["| " + " | ".join(columns) + " |", "|---|" + "---:|" * (len(columns) - 1)]
    return head + ["| " + " | ".join(each) + " |" for each in rows]


MAP_COLUMNS = (
    "map", "cells", "Dial ÷ Cairn", "whole field ms", "ns per cell", "lengths met",
    "field + path in Python ms",
)  # fmt: skip


def map_row(each: dict[str, Any]) -> list[str]:
    """One map, as text by `MAP_COLUMNS`."""
    return [
        each["map"],
        "{} × {}".format(*each["shape"]),
        times(each["ratio"]),
        spread(each["cairn_ms"], ""),
        number(each["ns_per_cell"]),
        f"{each['lengths_met']} of {each['queries']}",
        number(each["query_ms"]),
    ]


def maps_line(summary: dict[str, Any]) -> str:
    """What all maps come to."""
    return (
        f"Dial ÷ Cairn: geometric mean {times(summary['geometric_mean_ratio'])}; "
        f"{summary['lengths_met']} of {summary['queries']} published lengths met"
    )


def machine_lines(machine: dict[str, Any]) -> list[str]:
    """Processor, versions and build, in two lines."""
    build, peers = machine["build"], machine["peers"]
    versions = ", ".join(f"{name} {version or '–'}" for name, version in peers.items())
    return [
        f"{machine['processor']}, {machine['cores']} cores, {machine['memory_gib']} GiB, "
        f"{machine['system']}; load {machine['load_average']}",
        f"cairn {machine['cairn']} ({build['profile']}, {build['target']}, compiled for "
        f"{build['compiled_for']}, processor has {build['processor_has']}), Python "
        f"{machine['python']}, numpy {machine['numpy']}, {versions}",
    ]


def summary_lines(summary: dict[str, Any]) -> list[str]:
    """What it comes to, in few lines."""
    by_size = summary["geometric_mean_ratio_by_size"]
    sizes = ", ".join(f"{times(ratio)} at {size}²" for size, ratio in by_size.items())
    lines = [
        f"Dial ÷ Cairn: geometric mean {times(summary['geometric_mean_ratio'])} ({sizes}); "
        f"lowest {times(summary['lowest_ratio'])} ({summary['lowest_ratio_case']})",
    ]
    if summary["geometric_mean_ratio_scipy"]:
        lines.append(f"scipy ÷ Cairn: {times(summary['geometric_mean_ratio_scipy'])}")
    if summary["aims"]:
        lines.append(f"aims met: {summary['aims_met']} of {summary['aims']}")
    agree = "every answer agrees" if summary["agree"] else "; ".join(summary["differs"])
    return [*lines, f"answers: {agree}"]


def row(case: dict[str, Any]) -> list[str]:
    """One case, as text by `COLUMNS`."""
    found = case["contenders"]
    return [
        case["class"],
        f"{case['size']}²",
        "cutting" if case["corner_cutting"] else "strict",
        times(case["ratio"]),
        spread(found.get("cairn")),
        number(case["aim_ns_per_cell"]) + (" ✓" if case["aim_met"] else ""),
        number(case["python_ns_per_cell"]),
        times(case["two_threads"], 2),
        percent(case["copy_share"]),
        times(case["memory_share"], 1),
        spread(found.get("dial")),
        *(
            number((found.get(name) or {}).get("median_ns_per_cell"))
            for name in ("dial-wide", "heap", "scipy", "scikit-image", "xarray-spatial")
        ),
    ]


def skipped(record: dict[str, Any]) -> list[tuple[str, int]]:
    """(peer and why it was left out, how many cases) of a record."""
    counts: dict[str, int] = {}
    for case in record["cases"]:
        for name, why in case["skipped"].items():
            line = why if name in why else f"{name}: {why}"
            counts[line] = counts.get(line, 0) + 1
    return list(counts.items())


def number(value: float | None) -> str:
    """Three figures that matter."""
    if value is None:
        return "–"
    return f"{value:.0f}" if value >= 99.5 else f"{value:.1f}" if value >= 9.95 else f"{value:.2f}"


def spread(timing: dict[str, Any] | None, unit: str = "_ns_per_cell") -> str:
    """Median, with least and most."""
    if timing is None:
        return "–"
    median, low, high = (number(timing[key + unit]) for key in ("median", "least", "most"))
    return f"{median} ({low}–{high})"


def times(value: float | None, decimals: int = 1) -> str:
    """A ratio."""
    return "–" if value is None else f"{value:.{decimals}f}×"


def percent(value: float | None) -> str:
    """A share."""
    return "–" if value is None else f"{100 * value:.0f} %"
