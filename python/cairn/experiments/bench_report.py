"""A benchmark's record as Markdown."""

from __future__ import annotations

from typing import Any

HEAD = """# Benchmarks

The field of every cell to one goal: cost-to-go and next cell. The command above a table makes it
again. Figures are medians, with the least and most of the runs in brackets.

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
"""

COLUMNS = (
    "map", "size", "corners", "Dial ÷ Cairn", "Cairn ns", "aim ns", "Python ns", "2 threads",
    "copy", "memory", "Dial ns", "wide ns", "heap ns", "scipy ns", "scikit-image ns",
    "xarray-spatial ns",
)  # fmt: skip


def markdown(record: dict[str, Any], command: str) -> str:
    """BENCHMARKS.md of a record of `cairn bench plan`."""
    machine, summary = record["machine"], record["summary"]
    lines = [HEAD, "## Plans on grids", "", f"`{command}`", ""]
    lines += [f"- {line}" for line in machine_lines(machine)]
    lines += ["", *(f"- {line}" for line in summary_lines(summary)), ""]
    lines += [
        "| " + " | ".join(COLUMNS) + " |",
        "|---|" + "---:|" * (len(COLUMNS) - 1),
    ]
    lines += ["| " + " | ".join(row(case)) + " |" for case in record["cases"]]
    left_out = skipped(record)
    if left_out:
        lines += ["", "Left out: " + "; ".join(f"{why} ({count})" for why, count in left_out) + "."]
    return "\n".join(lines) + "\n"


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


def spread(times_ns: dict[str, Any] | None) -> str:
    """Median, with least and most."""
    if times_ns is None:
        return "–"
    low, high = times_ns["least_ns_per_cell"], times_ns["most_ns_per_cell"]
    return f"{number(times_ns['median_ns_per_cell'])} ({number(low)}–{number(high)})"


def times(value: float | None, decimals: int = 1) -> str:
    """A ratio."""
    return "–" if value is None else f"{value:.{decimals}f}×"


def percent(value: float | None) -> str:
    """A share."""
    return "–" if value is None else f"{100 * value:.0f} %"
