"""`cairn.plan_graph` beside scipy, end to end in Python, on graphs drawn by a seed.

Both are given CSR arrays ready; scipy searches the graph turned round, which is made beforehand and
not timed. Costs-to-go must be equal to the bit: whole numbers are exact in float64, and both add up
from the goal in float64.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

import cairn
from cairn.experiments.bench_plan import choose_goal, geometric_mean
from cairn.experiments.grids import random_obstacles
from cairn.experiments.machine import cores

Csr = tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[Any]]


def grid_graph(nodes: int, seed: int) -> tuple[Csr, int]:
    """Eight-connected grid, 20 % blocked, steps of 985 and 1393."""
    size = max(int(nodes**0.5), 8)
    free = np.asarray(random_obstacles(0.2)(size, seed))
    row, col = choose_goal(free, seed)
    return cairn.grid_graph(free), row * size + col


def random_graph(nodes: int, seed: int) -> tuple[Csr, int]:
    """Eight links from every node to any others, whole costs 1..1000."""
    rng = np.random.default_rng(seed)
    indices = rng.integers(0, nodes, 8 * nodes)
    costs = rng.integers(1, 1001, 8 * nodes)
    return (np.arange(0, 8 * nodes + 1, 8), indices, costs), 0


def near_graph(nodes: int, seed: int) -> tuple[Csr, int]:
    """Six links to nodes at most 1000 numbers away, real costs as long as the way: like roads."""
    rng = np.random.default_rng(seed)
    away = np.rint(rng.laplace(0.0, 150.0, 6 * nodes)).astype(np.int64).clip(-1000, 1000)
    tails = np.repeat(np.arange(nodes), 6)
    indices = (tails + away + (away == 0)) % nodes
    costs = (np.abs(away) + 1.0) * (1.0 + rng.random(6 * nodes))
    return (np.arange(0, 6 * nodes + 1, 6), indices, costs), nodes // 2


GRAPHS: dict[str, Callable[[int, int], tuple[Csr, int]]] = {
    "grid": grid_graph,
    "random": random_graph,
    "near": near_graph,
}


@dataclass
class GraphResult:
    """What came of one graph: seconds of every run by contender, and whether answers agreed."""

    name: str
    nodes: int
    links: int
    reached: float
    seconds: dict[str, list[float]]
    agree: bool

    def median(self, contender: str) -> float | None:
        """Median time [s], None if it did not run."""
        runs = self.seconds.get(contender)
        return statistics.median(runs) if runs else None

    def ratio(self, contender: str) -> float | None:
        """How many times longer it took than Cairn on one thread."""
        one, other = self.median("cairn"), self.median(contender)
        return None if one is None or other is None else other / one

    def to_dict(self) -> dict[str, Any]:
        """Everything, and what follows from it."""
        two = self.ratio("cairn-2-threads")
        return {
            "graph": self.name,
            "nodes": self.nodes,
            "links": self.links,
            "reached": self.reached,
            "ratio_scipy": self.ratio("scipy"),
            "two_threads": None if two is None else 1 / two,
            "agree": self.agree,
            "contenders": {
                name: {
                    "median_ms": 1e3 * statistics.median(runs),
                    "least_ms": 1e3 * min(runs),
                    "most_ms": 1e3 * max(runs),
                    "ns_per_link": 1e9 * statistics.median(runs) / self.links,
                }
                for name, runs in self.seconds.items()
                if runs
            },
        }


def measure(
    names: tuple[str, ...],
    sizes: tuple[int, ...],
    repeats: int,
    seed: int,
    tell: Callable[[str], None] = lambda _: None,
) -> Iterator[GraphResult]:
    """Time one graph after another, contenders taking turns."""
    for nodes in sizes:
        for name in names:
            tell(f"{name}: drawing {nodes} nodes")
            csr, goal = GRAPHS[name](nodes, seed)
            yield _measured(name, csr, goal, repeats, tell)


def _measured(
    name: str, csr: Csr, goal: int, repeats: int, tell: Callable[[str], None]
) -> GraphResult:
    indptr, indices, costs = csr
    nodes = len(indptr) - 1
    found: dict[str, npt.NDArray[Any]] = {}

    def mine(threads: int) -> npt.NDArray[Any]:
        return cairn.plan_graph(indptr, indices, costs, goal, threads=threads).cost_to_go

    contenders: dict[str, Callable[[], npt.NDArray[Any]]] = {"cairn": lambda: mine(1)}
    if cores() > 1:
        contenders["cairn-2-threads"] = lambda: mine(2)
    try:
        contenders["scipy"] = _scipy(csr, goal)
    except ImportError:
        tell("scipy is not there")
    seconds: dict[str, list[float]] = {each: [] for each in contenders}
    for turn in range(repeats + 1):  # the first one warms up
        for each, solve in contenders.items():
            tell(f"{name}: round {turn} of {repeats}, {each}")
            begin = time.perf_counter()
            found[each] = solve()
            if turn:
                seconds[each].append(time.perf_counter() - begin)
    truth = np.asarray(found["cairn"], np.float64)
    agree = all(np.array_equal(np.asarray(other, np.float64), truth) for other in found.values())
    reached = float(np.isfinite(truth).mean())
    return GraphResult(name, nodes, len(indices), reached, seconds, agree)


def _scipy(csr: Csr, goal: int) -> Callable[[], npt.NDArray[Any]]:
    from scipy.sparse import csgraph, csr_array

    indptr, indices, costs = csr
    nodes = len(indptr) - 1
    # Of several links between two nodes the cheapest counts; a sparse matrix would add them up.
    tails = np.repeat(np.arange(nodes), np.diff(indptr))
    order = np.lexsort((costs, tails, indices))
    heads, ends = indices[order], tails[order]
    first = np.append(True, (np.diff(heads) != 0) | (np.diff(ends) != 0))
    chosen = order[first]
    counts = np.bincount(indices[chosen], minlength=nodes)
    reversed_indptr = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
    graph = csr_array(
        (costs[chosen].astype(np.float64), tails[chosen].astype(np.int32), reversed_indptr),
        shape=(nodes, nodes),
    )

    def solve() -> npt.NDArray[Any]:
        distances, _ = csgraph.dijkstra(graph, indices=goal, return_predecessors=True)
        return distances

    return solve


def summary_of(results: list[GraphResult]) -> dict[str, Any]:
    """What it comes to over all graphs."""
    return {
        "graphs": len(results),
        "geometric_mean_ratio_scipy": geometric_mean([each.ratio("scipy") for each in results]),
        "agree": all(each.agree for each in results),
    }
