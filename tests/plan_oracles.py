"""Independent answers to compare the planners with: scipy's Dijkstra, a textbook one, and A*.

Nothing here uses Cairn; links of grids are built anew from the rules of the public face.
"""

import heapq
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

MOVES = [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)]
ROOT2 = np.sqrt(2.0)


@dataclass
class Case:
    """A graph as an edge list sorted by tail, with its goals."""

    nodes: int
    tails: np.ndarray
    heads: np.ndarray
    costs: np.ndarray
    goals: list[int]

    @property
    def indptr(self):
        counts = np.bincount(self.tails, minlength=self.nodes)
        return np.concatenate([[0], np.cumsum(counts)])

    @property
    def csr(self):
        return self.indptr, self.heads, self.costs


def joined(cases: list[Case]) -> Case:
    """All cases side by side in one graph: one call of the oracle answers them all."""
    offsets = np.concatenate([[0], np.cumsum([case.nodes for case in cases])])
    pairs = list(zip(cases, offsets[:-1], strict=True))
    return Case(
        int(offsets[-1]),
        np.concatenate([case.tails + at for case, at in pairs]),
        np.concatenate([case.heads + at for case, at in pairs]),
        np.concatenate([case.costs for case in cases]),
        [int(goal + at) for case, at in pairs for goal in case.goals],
    )


def scipy_cost_to_go(case: Case, *, unweighted: bool = False) -> np.ndarray:
    """Distances of all nodes to the nearest goal, by scipy on the reversed graph."""
    # The cheapest of parallel links: scipy would add them up. Zero costs stay explicit entries.
    order = np.lexsort((case.costs, case.tails, case.heads))
    tails, heads, costs = case.tails[order], case.heads[order], case.costs[order].astype(float)
    first = np.ones(len(order), bool)
    first[1:] = (np.diff(heads) != 0) | (np.diff(tails) != 0)
    counts = np.bincount(heads[first], minlength=case.nodes)
    indptr = np.concatenate([[0], np.cumsum(counts)])
    shape = (case.nodes, case.nodes)
    reversed_graph = csr_array((costs[first], tails[first], indptr), shape=shape)
    return dijkstra(reversed_graph, indices=case.goals, min_only=True, unweighted=unweighted)


def textbook_cost_to_go(case: Case, number) -> np.ndarray:
    """Dijkstra from the goals with every sum in `number` (np.float32, int, ..)."""
    into = [[] for _ in range(case.nodes)]
    for tail, head, cost in zip(case.tails, case.heads, case.costs, strict=True):
        into[head].append((int(tail), number(cost)))
    best = {}
    heap = [(number(0), goal) for goal in case.goals]
    while heap:
        value, node = heapq.heappop(heap)
        if node in best:
            continue
        best[node] = value
        for tail, cost in into[node]:
            if tail not in best:
                heapq.heappush(heap, (number(value + cost), tail))
    return np.array([float(best.get(node, np.inf)) for node in range(case.nodes)])


def textbook_pointers(case: Case) -> list[int]:
    """Pointers of Dijkstra with nodes settled by (cost, number), changed by what is better only."""
    into = [[] for _ in range(case.nodes)]
    for tail, head, cost in zip(case.tails, case.heads, case.costs, strict=True):
        into[head].append((int(tail), cost))
    best, pointer = dict.fromkeys(case.goals, 0), [-1] * case.nodes
    heap = [(0, goal) for goal in case.goals]
    heapq.heapify(heap)
    while heap:
        value, node = heapq.heappop(heap)
        if value > best[node]:
            continue
        for tail, cost in into[node]:
            if value + cost < best.get(tail, np.inf):
                best[tail], pointer[tail] = value + cost, node
                heapq.heappush(heap, (value + cost, tail))
    return pointer


def random_graph(rng: np.random.Generator, kind: str, most_nodes: int = 10) -> Case:
    """One-way links, asymmetric costs, ties, parallel links, cut-off nodes, one to three goals."""
    nodes = int(rng.integers(1, most_nodes + 1))
    links = int(rng.integers(0, 4 * nodes))
    tails = np.sort(rng.integers(0, nodes, links))
    heads = rng.integers(0, nodes, links)
    if kind == "ties":  # and zero costs
        costs = rng.integers(0, 4, links)
    elif kind == "integers":
        costs = rng.integers(0, 1_000_000, links)
    else:
        costs = rng.random(links) * 10.0 ** rng.integers(-3, 4, links)
        costs[rng.random(links) < 0.1] = 0.0
    goals = rng.choice(nodes, size=min(nodes, int(rng.integers(1, 4))), replace=False)
    return Case(nodes, tails, heads, costs, goals.tolist())


def two_way_graph(rng: np.random.Generator, most_nodes: int = 12) -> Case:
    """Every link both ways, at two costs: layers of links differ by at most one."""
    half = random_graph(rng, "integers", most_nodes)
    tails = np.concatenate([half.tails, half.heads])
    heads = np.concatenate([half.heads, half.tails])
    costs = rng.integers(0, 100, len(tails))
    order = np.argsort(tails, kind="stable")
    return Case(half.nodes, tails[order], heads[order], costs[order], half.goals[:1])


def grid_links(costs: np.ndarray, corner_cutting: bool, price) -> tuple[np.ndarray, ...]:
    """(tail, head, code, cost) of every move; `price(code, a, b)` of arrays of cell costs."""
    rows, cols = costs.shape
    free = np.pad(np.isfinite(costs), 1)
    cells = np.arange(rows * cols).reshape(rows, cols)
    found = []
    for code, (down, right) in enumerate(MOVES):
        shifted = free[1 + down : 1 + down + rows, 1 + right : 1 + right + cols]
        allowed = free[1:-1, 1:-1] & shifted
        if down and right and not corner_cutting:
            allowed = allowed & free[1 + down : 1 + down + rows, 1:-1]
            allowed = allowed & free[1:-1, 1 + right : 1 + right + cols]
        tail = cells[allowed]
        head = tail + down * cols + right
        price_of = price(code, costs.ravel()[tail], costs.ravel()[head])
        found.append((tail, head, np.full(len(tail), code), price_of))
    tails, heads, codes, prices = (np.concatenate(part) for part in zip(*found, strict=True))
    order = np.lexsort((codes, tails))
    return tails[order], heads[order], codes[order], prices[order]


def step_price(straight: int, diagonal: int):
    return lambda code, a, b: np.full(len(a), diagonal if code % 2 else straight)


def mean_price(number):
    """Length times the mean of two cells, in the arithmetic of `number`."""

    def price(code, a, b):
        half = number(ROOT2 / 2 if code % 2 else 0.5)
        return (a.astype(number) + b.astype(number)) * half

    return price


def lowest_codes(case: Case, codes: np.ndarray, values: np.ndarray) -> np.ndarray:
    """For every cell the lowest code that achieves its value exactly; -1 at goals and at inf."""
    ahead = (values[case.heads] + case.costs).astype(values.dtype)
    tight = np.isfinite(ahead) & (ahead == values[case.tails])
    lowest = np.full(case.nodes, 8)
    np.minimum.at(lowest, case.tails[tight], codes[tight])
    lowest[case.goals] = -1
    lowest[~np.isfinite(values)] = -1
    return lowest


def check_pointers(case: Case, values: np.ndarray, next_node: np.ndarray) -> None:
    """Pointers exist exactly where there is a way, never cycle, and their links sum to it."""
    is_goal = np.zeros(case.nodes, bool)
    is_goal[case.goals] = True
    has_way = np.isfinite(values) & ~is_goal
    np.testing.assert_array_equal(next_node >= 0, has_way)
    step = np.full(case.nodes, np.inf, case.costs.dtype if case.costs.dtype.kind == "f" else float)
    used = next_node[case.tails] == case.heads
    np.minimum.at(step, case.tails[used], case.costs[used])
    assert np.array_equal(step[has_way] + values[next_node[has_way]], values[has_way])
    ends = np.where(next_node >= 0, next_node, np.arange(case.nodes))
    for _ in range(int(np.ceil(np.log2(case.nodes + 1))) + 1):
        ends = ends[ends]
    assert is_goal[ends[has_way]].all(), "a pointer cycle"


def a_star(free: np.ndarray, start, goal, straight: int, diagonal: int, corner_cutting: bool):
    """Cost and cells of a best path by plain A* with the octile heuristic; (None, None) if none."""

    def octile(cell):
        down, right = abs(cell[0] - goal[0]), abs(cell[1] - goal[1])
        return straight * abs(down - right) + diagonal * min(down, right)

    def is_free(row, col):
        return 0 <= row < free.shape[0] and 0 <= col < free.shape[1] and free[row, col]

    cost, before, closed = {start: 0}, {}, set()
    heap = [(octile(start), start)]
    while heap:
        _, cell = heapq.heappop(heap)
        if cell == goal:
            path = [cell]
            while path[-1] in before:
                path.append(before[path[-1]])
            return cost[cell], path[::-1]
        if cell in closed:
            continue
        closed.add(cell)
        row, col = cell
        for code, (down, right) in enumerate(MOVES):
            there = (row + down, col + right)
            if not is_free(*there):
                continue
            sides_free = is_free(row, col + right) and is_free(row + down, col)
            if code % 2 and not corner_cutting and not sides_free:
                continue
            through = cost[cell] + (diagonal if code % 2 else straight)
            if through < cost.get(there, np.inf):
                cost[there], before[there] = through, cell
                heapq.heappush(heap, (through + octile(there), there))
    return None, None
