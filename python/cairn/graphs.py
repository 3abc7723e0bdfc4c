"""Planning on any directed graph, and the paper's own layered planner [Maalouf06 §3].

A graph is CSR arrays: node i has the links `indptr[i]:indptr[i + 1]`; link k leads to node
`indices[k]` and costs `costs[k]` >= 0, which may differ by direction. A link of infinite cost is no
link. Integer costs are added as uint64 and refused by name if a walk might not fit; float costs in
float64 (`plan_layered` keeps float32). Sums run from the goal, one rounded add per link.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from cairn import _brain, errors
from cairn.arguments import (
    checked_choice,
    checked_flag,
    checked_threads,
    double_precision,
    single_precision,
    two_dimensional,
    whole_number,
)
from cairn.planning import Precision, Steps

Engine = Literal["classical", "phased", "levelled", "in_place"]
Schedule = Literal["fronts", "wavefront"]
Csr = tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[Any]]


class GraphField:
    """Cost-to-go and next node of every node of a graph; made by `plan_graph`.

    Attributes:
        native: cost-to-go as it was added up: uint64 (its largest value where there is no way) or
            float64 (inf).
        next_node: int64, the next node on the best way; -1 at goals and where there is none. Among
            equally good ones, the first settled: nodes settle by (cost-to-go, node number).
        goals: the goal nodes as given.
    """

    def __init__(
        self, native: npt.NDArray[Any], next_node: npt.NDArray[np.int64], goals: list[int]
    ) -> None:
        """Wrap a solved field."""
        for array in (native, next_node):
            array.flags.writeable = False
        self.native = native
        self.next_node = next_node
        self.goals = goals
        self._cost_to_go: npt.NDArray[np.float64] | None = None

    @property
    def cost_to_go(self) -> npt.NDArray[np.float64]:
        """Cost of the best way from every node, float64; 0 at goals, inf where there is none."""
        if self._cost_to_go is None:
            self._cost_to_go = _as_float(self.native)
            self._cost_to_go.flags.writeable = False
        return self._cost_to_go

    def path(self, start: int) -> npt.NDArray[np.int64] | None:
        """Return the nodes from `start` to a goal, both included; None where there is no way.

        Raises:
            StartNotANode: the graph has no such node.
        """
        return _walk(self.cost_to_go, self.next_node, start)

    def __repr__(self) -> str:
        """Size, number type and goals."""
        return f"GraphField({len(self.next_node)} nodes, {self.native.dtype}, goals={self.goals})"


@dataclass(frozen=True, eq=False)
class Trace:
    """When each task of the layered planner's task graph ran; a task is one layer at one level.

    Args:
        level, layer, thread: int64 (tasks,), in order of their ends. Levels beyond the last
            may have been begun.
        begin_ns, end_ns: int64 (tasks,) times since the start of the call [ns].
        waits: for each layer 1..K the (layer, lag) that its task at level i waits for: that layer's
            task at level i - lag.
    """

    level: npt.NDArray[np.int64]
    layer: npt.NDArray[np.int64]
    thread: npt.NDArray[np.int64]
    begin_ns: npt.NDArray[np.int64]
    end_ns: npt.NDArray[np.int64]
    waits: list[list[tuple[int, int]]]


@dataclass(frozen=True, eq=False)
class LayeredResult:
    """What the layered planner found, and what it did for it.

    Args:
        native: C⁺ of every node [Maalouf06 (5)], in the number type it was added up in.
        next_node: int64 pointer of every node, -1 for none; a pointer changes only on strict
            improvement, so the first found in the engine's order stays, and none ever cycle.
        layer: int64 layer of every node, least number of links to a goal; -1 where there is no way.
        layers: number of layers, K.
        widest_layer: size of the largest layer, M.
        greatest_rise: most layers that any link rises, at least 1 (two-way graphs: 1).
        levels: levels really done (repetitions of the phased engine).
        max_levels: levels allowed; K·M by default, which always suffices.
        converged: whether no further level can change any cost. For the classical engine: whether
            its field happens to be optimal.
        operations: DP(i, j) really done.
        operations_worst_case: DP(i, j) of `max_levels` levels.
        operations_equation_4: the printed equation (4) for the levels done. It is one more than
            `operations`, for every K and N: the authors count two links at the top of the layered
            solution graph, where the graph as described has one (layer 1 to G). None where (4) does
            not hold: fewer levels than layers, links that rise further than one layer, or an engine
            without levels.
        operations_worst_case_equation_4: the same for `max_levels`.
        sequence: (level, i, j) of every DP(i, j) in order, j = 0 the goal layer, if recorded.
        walks: (levels, nodes) n_i, the best walk of exactly i links, if recorded (levelled engine).
        trace: when each task ran, if recorded (levelled and in-place engines with `threads`).
    """

    native: npt.NDArray[Any]
    next_node: npt.NDArray[np.int64]
    layer: npt.NDArray[np.int64]
    layers: int
    widest_layer: int
    greatest_rise: int
    levels: int
    max_levels: int
    converged: bool
    operations: int
    operations_worst_case: int
    operations_equation_4: int | None
    operations_worst_case_equation_4: int | None
    sequence: list[tuple[int, int, int]] | None
    walks: npt.NDArray[Any] | None
    trace: Trace | None

    @property
    def cost_to_go(self) -> npt.NDArray[np.float64]:
        """C⁺ of every node, float64; 0 at goals, inf where there is no way."""
        return _as_float(self.native)

    def path(self, start: int) -> npt.NDArray[np.int64] | None:
        """Return the nodes from `start` to a goal, both included; None where there is no way.

        Raises:
            StartNotANode: the graph has no such node.
        """
        return _walk(self.cost_to_go, self.next_node, start)


def plan_graph(
    indptr: npt.ArrayLike,
    indices: npt.ArrayLike,
    costs: npt.ArrayLike,
    goal: int | Sequence[int],
    *,
    threads: int | None = None,
) -> GraphField:
    """Plan from every node of a directed graph to `goal`; costs and pointers are Dijkstra's.

    Args:
        indptr: (nodes + 1,) integers, from 0 to the number of links, never falling.
        indices: (links,) integers: the node each link leads to.
        costs: (links,) integers or floats >= 0; inf is no link.
        goal: a node, or a sequence of them.
        threads: most threads to use; None: one. The result does not depend on it, not by a bit.

    Raises:
        NoThreads: `threads` is zero.
        UnknownPlanOption: `threads` is no whole number, or less than zero.
        IndptrEnds, IndptrFalls, LinkCostCount, NodeOutOfRange, GraphTooLarge: bad arrays.
        GraphNotPlannable: not one-dimensional, or not of integers (costs: real numbers).
        LinkCostNan, LinkCostNegative: with the link, its two nodes and the value.
        GraphCostOverflow: a walk through all nodes might not fit the number type.
        NoGoal, GoalNotANode: as named.
    """
    arrays = _checked(indptr, indices, costs)
    if arrays[2].dtype == np.float32:
        arrays = (*arrays[:2], arrays[2].astype(np.float64))
    goals = _nodes(goal)
    most = checked_threads(threads)
    return GraphField(*_brain.plan_graph(*arrays, goals, most), goals)


def plan_layered(
    indptr: npt.ArrayLike,
    indices: npt.ArrayLike,
    costs: npt.ArrayLike,
    goal: int | Sequence[int],
    *,
    engine: Engine = "in_place",
    max_levels: int | None = None,
    early_stop: bool = True,
    record_sequence: bool = False,
    record_walks: bool = False,
    threads: int | None = None,
    schedule: Schedule = "wavefront",
    record_trace: bool = False,
) -> LayeredResult:
    """Plan by the paper's layers and levels: the reference, not the fast way.

    Args:
        indptr, indices, costs, goal: as in `plan_graph`.
        engine: "classical" falling links only (§3.1), not optimal in general; "phased" falling
            links, links within layers, rising links, repeated; "levelled" the layered solution
            graph, level i reading only level i - 1; "in_place" its operations in its order on one
            cost per node (§3.2).
        max_levels: levels N at most; None: K·M.
        early_stop: stop after a level beyond K that changed nothing (§3.4).
        record_sequence: keep every DP(i, j) in order.
        record_walks: keep n_i of every level; levelled engine only.
        threads: threads that share the work of the levelled or the in-place engine as a task graph
            [Maalouf06 §3.3]; None: the serial engine. The other engines are serial. The result does
            not depend on it, not by a bit.
        schedule: in what order threads take the work. "fronts": (a), one level after the other, all
            its layers at once (in place: all of level i, layer j with equal (r + 1) i + j, r the
            greatest rise). "wavefront": (b), every layer of every level as soon as what it reads is
            final.
        record_trace: keep when each task ran, and on which thread.

    Raises:
        NoLevels: `max_levels` is less than 1.
        NoThreads: `threads` is zero.
        UnknownPlanOption: there is no such engine or schedule, or `threads` is no whole number.
        CairnError: whatever `plan_graph` refuses.
    """
    checked_choice("engine", engine, ("classical", "phased", "levelled", "in_place"))
    checked_choice("schedule", schedule, ("fronts", "wavefront"))
    most = None if max_levels is None else max(whole_number(max_levels), 0)
    found = _brain.plan_layered(
        *_checked(indptr, indices, costs),
        _nodes(goal),
        engine,
        most,
        early_stop,
        record_sequence,
        record_walks,
        checked_threads(threads),
        schedule,
        record_trace,
    )
    trace = found.pop("trace")
    return LayeredResult(**found, trace=None if trace is None else Trace(**trace))


def grid_graph(
    costs: npt.ArrayLike,
    *,
    corner_cutting: bool = False,
    precision: Precision | None = None,
    steps: Steps = "985/1393",
) -> Csr:
    """Return a grid as (indptr, indices, costs), with the very link costs `plan_grid` adds up.

    Node = row * cols + col; links of a cell in the order of the `next_node` codes. Costs are int64
    steps for a bool grid without `precision`, else float32 or float64.

    Raises:
        CairnError: what `plan_grid` refuses of a grid.
    """
    checked_choice("precision", precision, (None, "f32", "f64"))
    checked_choice("steps", steps, ("985/1393", "100/141"))
    corner_cutting = checked_flag("corner_cutting", corner_cutting)
    grid = two_dimensional(costs)
    if grid.dtype == bool and precision is None:
        indptr, indices, links = _brain.graph_of_free(grid, corner_cutting, steps == "100/141")
        return indptr, indices, links.astype(np.int64)
    values = np.where(grid, 1.0, np.inf) if grid.dtype == bool else grid
    if precision == "f64":
        return _brain.graph_of_costs_f64(double_precision(values), corner_cutting)
    return _brain.graph_of_costs_f32(single_precision(values), corner_cutting)


def graph_from_edges(nodes: int, edges: npt.ArrayLike, costs: npt.ArrayLike) -> Csr:
    """Return an edge list as (indptr, indices, costs); links of one node keep their order.

    Args:
        nodes: number of nodes.
        edges: (links, 2) integers: from, to.
        costs: (links,) cost of each.

    Raises:
        NodeOutOfRange: a link names a node that does not exist.
        GraphNotPlannable: `edges` is not a (links, 2) array of integers.
        LinkCostCount: there is not one cost for every link.
    """
    ends = _array("edges", edges)
    if ends.size == 0:
        ends = ends.reshape(0, 2).astype(np.int64)
    if ends.ndim != 2 or ends.shape[1] != 2 or ends.dtype.kind not in "iu":
        raise _not_plannable("edges", ends)
    prices = _array("costs", costs)
    if prices.shape != (len(ends),):
        raise errors.LinkCostCount(
            f"{prices.size} costs for {len(ends)} links; give one cost for every link",
            costs=prices.size,
            links=len(ends),
        )
    outside = np.argwhere((ends < 0) | (ends >= nodes))
    if len(outside):
        link, end = (int(i) for i in outside[0])
        node = int(ends[link, end])
        raise errors.NodeOutOfRange(
            f"link {link} names node {node}, but there are {nodes} nodes, counted from 0",
            link=link,
            node=node,
            nodes=nodes,
        )
    order = np.argsort(ends[:, 0], kind="stable")
    counts = np.bincount(ends[:, 0].astype(np.int64), minlength=nodes)
    indptr = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    return indptr, ends[order, 1].astype(np.int64), prices[order]


def _checked(indptr: Any, indices: Any, costs: Any) -> Csr:
    starts, targets = _array("indptr", indptr), _array("indices", indices)
    prices = _array("costs", costs)
    for name, array in (("indptr", starts), ("indices", targets)):
        if array.ndim != 1 or (array.size and array.dtype.kind not in "iu"):
            raise _not_plannable(name, array)
    if prices.ndim != 1 or prices.dtype.kind not in "iuf":
        raise _not_plannable("costs", prices)
    if prices.dtype.kind == "f":
        wanted: Any = np.float32 if prices.dtype == np.float32 else np.float64
    else:
        wanted = np.uint64 if prices.dtype == np.uint64 else np.int64
    return (
        np.ascontiguousarray(starts, np.int64),
        np.ascontiguousarray(targets, np.int64),
        np.ascontiguousarray(prices, wanted),
    )


def _array(name: str, values: Any) -> npt.NDArray[Any]:
    try:
        return np.asarray(values)
    except (TypeError, ValueError):  # ragged, or no array at all
        count = len(values) if hasattr(values, "__len__") else ()
        raise _not_plannable(name, np.empty(count, object)) from None


def _not_plannable(name: str, array: npt.NDArray[Any]) -> errors.GraphNotPlannable:
    return errors.GraphNotPlannable(
        f"{name} has shape {array.shape} and type {array.dtype}; give a one-dimensional array of "
        "integers (costs may be floats; edges are (links, 2))",
        array=name,
        shape=array.shape,
        dtype=str(array.dtype),
    )


def _nodes(goal: Any) -> list[int]:
    try:
        goals = [goal] if isinstance(goal, str) else list(goal)
    except TypeError:  # one node
        goals = [goal]
    return [whole_number(node) for node in goals]


def _as_float(native: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    values = native.astype(np.float64)
    if native.dtype.kind == "u":
        values[native == np.iinfo(native.dtype).max] = np.inf
    return values


def _walk(
    cost_to_go: npt.NDArray[np.float64], next_node: npt.NDArray[np.int64], start: int
) -> npt.NDArray[np.int64] | None:
    start, nodes_there = whole_number(start), len(next_node)
    if not 0 <= start < nodes_there:
        raise errors.StartNotANode(
            f"start {start} is not a node: there are {nodes_there} nodes, counted from 0",
            node=start,
            nodes=nodes_there,
        )
    if not np.isfinite(cost_to_go[start]):
        return None
    nodes = [start]
    while next_node[nodes[-1]] >= 0:
        nodes.append(int(next_node[nodes[-1]]))
    return np.array(nodes, np.int64)
