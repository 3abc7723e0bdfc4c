"""The figures of this package as reproductions: measured, drawn, told, and compared in words."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from cairn.experiments.reproduction import Advance, Caption, Reproduction, TableOf

Record = dict[str, Any]
DATA = "python/cairn/data/controllers/p3at.toml"


def _one(measure: Callable[[], Record], name: str) -> Callable[[int, Advance], Record]:
    def run(seed: int, advance: Advance) -> Record:
        advance(name)
        return measure()

    return run


def equation_4() -> Reproduction:
    """Number of DP operations: as printed, and counted."""
    from cairn.experiments.paper import layers

    def draw(record: Record, folder: Path) -> list[Path]:
        from cairn.view.layers import draw_counts

        return [draw_counts(record, folder / "eq4.png")]

    def tables(record: Record) -> list[TableOf]:
        wanted = [row for row in record["counts"] if row["levels"] - row["layers"] in (0, 6, 12)]
        rows = [
            (str(row["layers"]), str(row["levels"]), str(row["counted"]), str(row["printed"]))
            for row in wanted
        ]
        stops = [
            (
                one["name"],
                f"{one['layers']} × {one['widest_layer']}",
                f"{one['levels']} of {one['levels_bound']}",
                f"{one['operations']:,} of {one['operations_bound']:,}",
            )
            for one in record["maps"]
        ]
        return [
            TableOf("DP operations", ("layers K", "levels N", "counted", "(4) as printed"), rows),
            TableOf(
                "until nothing changes",
                ("map", "K × M", "levels, of K·M", "operations, of worst case"),
                stops,
            ),
        ]

    def caption(record: Record) -> Caption:
        off = record["summary"]["printed_minus_counted"]
        saved = record["summary"]["least_saved_by_stopping"]
        return Caption(
            "[Maalouf06 §3.2 (4)]: the number of vector links of the layered solution graph, "
            "which is "
            "the number of DP operations, for K layers and N levels; §3.4: stopping early.",
            f"{record['summary']['graphs']} random graphs of K = 1 to 8 layers of three nodes, "
            "run by "
            "the levelled engine to N = K to K + 12 levels without stopping, every DP(i, j) "
            "recorded "
            "and counted; the three maps of `fig12`, run until a level beyond K changes nothing.",
            (
                "the count grows with K and N exactly as (4) says",
                f"stopping saves at least {100 * saved:.0f} % of the worst case on every map, as "
                "§3.4 "
                "expects",
            ),
            (
                f"as printed, (4) is more than what runs by {_list(off)} for every K and N: at "
                "the top "
                "the graph as described has one link, layer 1 to G, where (4) counts two",
            ),
        )

    steps = len(layers.LAYERS) + 1
    title = "equation (4): how many DP operations, printed and counted [Maalouf06 §3.2, §3.4]"
    return Reproduction(title, lambda: steps, layers.equation_4, draw, tables, caption)


def _list(values: list[Any]) -> str:
    return ", ".join(map(str, values))


def solution_graph(figure: int) -> Reproduction:
    """The layered solution graph (3), or layers and vector links (4)."""
    from cairn.experiments.paper import layers

    def draw(record: Record, folder: Path) -> list[Path]:
        from cairn.view import layers as view

        if figure == 3:
            return [view.draw_solution_graph(record, folder / "fig3.png")]
        return [view.draw_vector_links(record, folder / "fig4.png")]

    def tables(record: Record) -> list[TableOf]:
        rows = [(_layer(i), _layer(j), str(count)) for i, j, count in record["links"]]
        return [TableOf("links of the map", ("from", "to", "links"), rows)]

    def caption(record: Record) -> Caption:
        told = record["summary"]
        made = (
            f"a map of {told['nodes']} nodes and a goal with {told['layers']} layers, eight "
            f"neighbours, run by the levelled engine to {told['levels']} levels; what is drawn is "
            "what the engine recorded."
        )
        if figure == 3:
            return Caption(
                "[Maalouf06 Fig. 3]: levels of layers under the goal, joined by vector links.",
                made,
                (
                    "layer k at a level is linked to layers k−1, k and k+1 of the level above, "
                    "where "
                    "they are; level i holds layers 1 to min(i, K)",
                    "DP(1, G), then DP(1, 1), DP(2, 1), then on: the order that the text gives",
                ),
                (
                    f"{told['operations']} vector links run, (4) prints "
                    f"{told['operations_equation_4']}: see `eq4`",
                    "K and N of the paper's drawing are general; ours are those of the map shown",
                ),
            )
        return Caption(
            "[Maalouf06 Fig. 4]: one circle per layer, one arrow per vector link; costs and "
            "pointers "
            "are kept once per node, not once per level.",
            made,
            ("only layers next to each other are joined, both ways, and each with itself",),
            (
                "the numbers of links are ours; the paper's drawing has none",
                "links out of the goal are left out: the text says that they are unused",
            ),
        )

    titles = {
        3: "the layered solution graph, drawn from the operations that ran [Maalouf06 Fig. 3]",
        4: "layers and vector links of a real map [Maalouf06 Fig. 4]",
    }
    measure = _one(layers.graph_of_layers, "a small map")
    return Reproduction(titles[figure], lambda: 1, measure, draw, tables, caption)


def _layer(number: int) -> str:
    return f"layer {number}" if number else "G"


def parameters() -> Reproduction:
    """The controller's parameters in one posture."""
    from cairn.experiments.paper import parameters as measuring

    def draw(record: Record, folder: Path) -> list[Path]:
        from cairn.view.parameters import draw_parameters

        return [draw_parameters(record, folder / "fig5.png")]

    def tables(record: Record) -> list[TableOf]:
        rows = [
            (name, f"{record['summary'][name]:.4f}", f"{value:.4f}")
            for name, value in record["by_hand"].items()
        ]
        return [TableOf("parameters", ("", "the tracker says", "worked out anew"), rows)]

    def caption(record: Record) -> Caption:
        off = record["summary"]["most_off_by_hand"]
        return Caption(
            "[Maalouf06 Fig. 5]: the parameters of the fuzzy controller in one posture.",
            f"one step of `cairn.Tracker` beside a bend, the robot at {measuring.POSE}.",
            (
                f"dR, dθ, α₁ and α₂ are as defined in the text, to {max(off, 1e-15):.0e}"
                if off < 1e-9
                else "dR, dθ, α₁ AND α₂ ARE NOT as defined in the text",
            ),
            (
                "dR and dθ are taken from where the robot will be when the command takes hold, not "
                "from where it is: with a loop and a latency of 0.1 s it would turn too late",
                "N_i+1 is a corner here; on a smooth way the robot heads for a point that moves on "
                "with it, one step ahead",
                "path and posture are ours; the paper's drawing has no numbers",
            ),
        )

    title = "the parameters of the fuzzy controller in one posture [Maalouf06 Fig. 5]"
    measure = _one(measuring.measure, "one step")
    return Reproduction(title, lambda: 1, measure, draw, tables, caption)


def table_1() -> Reproduction:
    """Table 1 as the look-ahead module answers it."""
    from cairn.experiments.paper import rules

    def draw(record: Record, folder: Path) -> list[Path]:
        from cairn.view.sets import draw_table_1

        return [draw_table_1(record, folder / "table1.png")]

    def tables(record: Record) -> list[TableOf]:
        rows = [
            (cell["alpha2"], cell["alpha1"], cell["printed"], cell["fired"], f"{cell['C']:g}")
            for cell in record["cells"]
        ]
        return [TableOf("rules", ("α₂", "α₁", "printed", "fired", "C"), rows)]

    def caption(record: Record) -> Caption:
        told = record["summary"]
        values = sorted({cell["C"] for cell in record["cells"]})
        return Caption(
            "[Maalouf06 Table 1]: nine rules from the turns at the next two waypoints to C.",
            f"the controller shipped for the P3-AT ({DATA}), asked where each of the nine rules "
            "holds alone.",
            (
                f"{told['equal']} of {told['rules']} rules answer as printed",
                "C is between 0 (no curvature) and 5",
            ),
            (
                f"the paper prints no numbers for the four values of C; ours are {_list(values)}",
                "angles at which the sets begin and end are ours too: see `fig7`",
            ),
        )

    title = "the rules of the look-ahead curvature, asked of the controller [Maalouf06 Table 1]"
    measure = _one(rules.table_1, "nine rules")
    return Reproduction(title, lambda: 1, measure, draw, tables, caption)


def memberships(figure: int) -> Reproduction:
    """Sets of the look-ahead module (7) or of the path tracker (8)."""
    from cairn.experiments.paper import rules

    module = {7: "look_ahead", 8: "tracker"}[figure]
    names = {
        7: "parameters of the look-ahead curvature and their sets",
        8: "parameters of the path tracker and their sets",
    }

    def draw(record: Record, folder: Path) -> list[Path]:
        from cairn.view.sets import draw_sets

        said = f"as the controller shipped for the P3-AT has them ({DATA})"
        if figure == 8:
            said += "; where the outermost sets go on at 1, not all of the range is shown"
        return [
            draw_sets(record, f"Fig. {figure}: {names[figure]}", said, folder / f"fig{figure}.png")
        ]

    def tables(record: Record) -> list[TableOf]:
        rows = [(name, "input", _list(list(one["sets"]))) for name, one in record["inputs"].items()]
        for name, numbers in record["outputs"].items():
            told = _list([f"{one} {value:g}" for one, value in numbers.items()])
            if len(numbers) > 9:
                told = f"{len(numbers)} from {min(numbers.values()):g} to {max(numbers.values()):g}"
            rows.append((name, "output", told))
        return [TableOf(names[figure], ("parameter", "", "sets or numbers"), rows)]

    def caption(record: Record) -> Caption:
        sums = record["summary"]["memberships_sum_to_one"]
        shared = (
            ("memberships of every input sum to one everywhere, so outputs change smoothly",)
            if sums
            else ()
        )
        if figure == 7:
            return Caption(
                "[Maalouf06 Fig. 7]: sets of α₁ and α₂, singletons of C.",
                f"{DATA}, sampled through the fuzzy engine.",
                (
                    "three sets for each angle and four singletons for C, by the paper's names",
                    *shared,
                ),
                ("shapes and numbers are not to be read in the paper's text: ours were tuned",),
            )
        counts = record["summary"]["inputs"]
        told = ", ".join(f"{count} of {name}" for name, count in counts.items())
        return Caption(
            "[Maalouf06 Fig. 8]: sets of the path tracker's parameters C, dR, dθ, Vc.",
            f"{DATA}, sampled through the fuzzy engine.",
            ("a zero-order Sugeno system of the four inputs and two outputs of (6)", *shared),
            (
                f"number, shapes and names of the sets are not in the paper's text: ours ({told}) "
                "were designed and tuned, as docs/tracking.md tells",
            ),
        )

    title = f"{names[figure]} [Maalouf06 Fig. {figure}]"
    measure = _one(lambda: rules.sets_of(module), module.replace("_", " "))
    return Reproduction(title, lambda: 1, measure, draw, tables, caption)


def free_arcs() -> Reproduction:
    """Free lengths of arcs beside obstacles."""
    from cairn.experiments.paper import arcs

    def draw(record: Record, folder: Path) -> list[Path]:
        from cairn.view.arcs import draw_arcs

        return [draw_arcs(record, arcs.along, folder / "fig10.png")]

    def tables(record: Record) -> list[TableOf]:
        rows = [
            (
                f"{one['curvature_lo']:.2f} … {one['curvature_hi']:.2f}",
                f"{one['distance_m']:.3f}",
                f"{marched:.3f}",
            )
            for one, marched in zip(record["intervals"], record["marched_m"], strict=True)
        ]
        columns = ("curvatures [1/m]", "free length D [m]", "followed in steps [m]")
        return [TableOf("curvature intervals", columns, rows)]

    def caption(record: Record) -> Caption:
        told = record["summary"]
        v, w = told["twist"]["linear_mps"], told["twist"]["angular_radps"]
        return Caption(
            "[Maalouf06 Fig. 10] [Simmons96]: the robot on an arc, an obstacle grown by its "
            "radius, "
            "and the distance d_c before they touch.",
            f'`cairn.Cvm(profile, shape="disc")` for the P3-AT at {arcs.TWIST[0]} m/s beside three '
            f"points, goal {record['goal_bearing_rad']} rad to the left; centres keep "
            f"{told['radius_m']:.3f} m, arcs count up to L = {told['horizon_m']:g} m.",
            (
                "an arc hits an obstacle exactly between the two tangent curvatures",
                "no interval claims more free length than 21 of its arcs have when followed in "
                "steps "
                "of half a millimetre, and none more than "
                f"{1e3 * max(told['most_too_short_m'], 0):.1f} mm less than the shortest of them",
                f"chosen by (7): {v:.2f} m/s and {w:.2f} rad/s",
            ),
            (
                "as published, one distance holds for all arcs between the tangents of an "
                "obstacle, "
                "the nearer tangent point's: here up to "
                f"{100 * told['tangent_estimate_too_long_m']:.0f} cm too long; ours cuts intervals "
                "finer and takes the exact least contact in each",
                "the robot drives with its true box, not the disc, unless told otherwise",
            ),
        )

    title = "how far arcs are free beside obstacles [Maalouf06 Fig. 10]"
    measure = _one(arcs.measure, "three obstacles")
    return Reproduction(title, lambda: 1, measure, draw, tables, caption)


def state_machine() -> Reproduction:
    """The state machine, generated from the table."""
    from cairn.experiments.paper import machine

    def draw(record: Record, folder: Path) -> list[Path]:
        from cairn.view.machine import draw_machine

        return [draw_machine(record, folder / "fig11.png")]

    def tables(record: Record) -> list[TableOf]:
        rows = [tuple(str(part) for part in row) for row in record["rows"]]
        return [TableOf("every row", ("mode", "event", "next mode", "reason"), rows)]

    def caption(record: Record) -> Caption:
        told = record["summary"]
        return Caption(
            "[Maalouf06 Fig. 11, §6]: four modes and when one follows another.",
            "`cairn.navigator.transitions()`, the table that the navigator itself looks up: "
            f"{told['rows']} rows, {told['changes_of_mode']} of which change the mode.",
            (
                f"{told['modes']} modes and {told['arrows']} arrows, "
                + (
                    "exactly those that §6 tells in words"
                    if told["arrows_as_told"]
                    else "NOT those that §6 tells in words"
                ),
                *(
                    ("planning is entered only from stop",)
                    if told["planning_only_from_stop"]
                    else ()
                ),
            ),
            (
                "arrows also stand for what the paper does not name: a task called off, a new one "
                "while moving, all waypoints blocked, a robot held by what no sensor shows",
                "the table is total: every event has an answer in every mode, also where it is "
                "never "
                "perceived (marked ·)",
                "a region visited twice and a local minimum end the avoidance too: the paper says "
                "`throughout`",
            ),
        )

    title = "the state machine, generated from the transition table [Maalouf06 Fig. 11]"
    measure = _one(machine.measure, "transition table")
    return Reproduction(title, lambda: 1, measure, draw, tables, caption)


def three_cases() -> Reproduction:
    """Three maps by dynamic programming and A*."""
    from cairn.experiments.paper import cases

    def draw(record: Record, folder: Path) -> list[Path]:
        from cairn.view.layers import draw_cases

        return [draw_cases(record, folder / "fig12.png")]

    def tables(record: Record) -> list[TableOf]:
        planners = list(record["cases"][0]["costs"])
        rows = [
            (
                case["name"],
                *(f"{case['costs'][planner] / 100:.2f}" for planner in planners),
                f"{case['layers']}",
                f"{case['levels']}",
                f"{case['visited_by_a_star']} of {case['cells']}",
            )
            for case in record["cases"]
        ]
        columns = ("map", *planners, "layers", "levels", "cells A* visited")
        return [TableOf("cost of the best path", columns, rows)]

    def caption(record: Record) -> Caption:
        equal = all(one["all_equal"] for one in record["summary"].values())
        return Caption(
            "[Maalouf06 Fig. 12, §7]: three workspaces, eight directions, steps of 1 and 1.41; the "
            "paper found the costs of dynamic programming and A* exactly identical.",
            "three maps drawn in text in python/cairn/experiments/paper/cases.py; costs in whole "
            "hundredths (100 and 141), so that equal means equal; A* [Hart68] written apart.",
            (
                (
                    "levelled, in-place and phased engines, the production solver and A* give "
                    "the same "
                    "cost on all three maps"
                    if equal
                    else "THE PLANNERS DO NOT AGREE: see the table"
                ),
                "the third map is a labyrinth, as in the paper",
            ),
            (
                "the paper's maps cannot be read off its text: these are of the same kinds, not "
                "the "
                "same cells, so costs are not to be compared with its figure",
                "here a diagonal passes only between two free cells; the paper does not say",
            ),
        )

    title = "three maps planned by dynamic programming and by A* [Maalouf06 Fig. 12]"
    steps = len(cases.CASES)
    return Reproduction(
        title, lambda: steps, lambda seed, advance: cases.measure(advance), draw, tables, caption
    )
