import itertools

import numpy as np
import pytest

import cairn
from plan_oracles import (
    Case,
    check_pointers,
    joined,
    random_graph,
    scipy_cost_to_go,
    textbook_cost_to_go,
    textbook_pointers,
    two_way_graph,
)

ENGINES = ["phased", "levelled", "in_place"]
KINDS = ["ties", "integers", "floats"]
GRAPHS_PER_KIND = 3400  # three kinds: 10 200 graphs for every engine


def random_cases(kind, count, seed=1):
    rng = np.random.default_rng(seed)
    return [random_graph(rng, kind) for _ in range(count)]


@pytest.fixture(scope="module", params=KINDS)
def answered(request):
    """Ten thousand small graphs in all, the same side by side as one, and scipy's answer."""
    cases = random_cases(request.param, GRAPHS_PER_KIND)
    whole = joined(cases)
    return cases, whole, scipy_cost_to_go(whole)


def planned(cases, plan):
    """Cost-to-go and pointers of all cases side by side."""
    fields = [plan(case) for case in cases]
    offsets = np.concatenate([[0], np.cumsum([case.nodes for case in cases])])[:-1]
    values = np.concatenate([field.cost_to_go for field in fields])
    pairs = zip(fields, offsets, strict=True)
    shifted = [np.where(f.next_node >= 0, f.next_node + at, -1) for f, at in pairs]
    return fields, values, np.concatenate(shifted)


def test_the_two_oracles_agree_also_where_links_cost_nothing():
    for kind in KINDS:
        cases = random_cases(kind, 300, seed=2)
        number = float if kind == "floats" else int
        textbook = np.concatenate([textbook_cost_to_go(case, number) for case in cases])
        np.testing.assert_array_equal(scipy_cost_to_go(joined(cases)), textbook)


def test_plan_graph_equals_dijkstra_and_its_pointers_walk_the_field(answered):
    cases, whole, truth = answered
    _, values, next_node = planned(cases, lambda case: cairn.plan_graph(*case.csr, case.goals))
    np.testing.assert_array_equal(values, truth)
    check_pointers(whole, values, next_node)


def test_plan_graph_gives_the_same_bits_and_pointers_for_every_number_of_threads(answered):
    cases, _, _ = answered
    large = joined([case for case in cases for _ in range(4)])  # large enough for threads
    alone = cairn.plan_graph(*large.csr, large.goals)
    for threads in (2, 3, 7):
        several = cairn.plan_graph(*large.csr, large.goals, threads=threads)
        np.testing.assert_array_equal(several.native, alone.native)
        np.testing.assert_array_equal(several.next_node, alone.next_node)


@pytest.mark.parametrize("cheapest", [0, 1])
def test_among_equally_good_next_nodes_the_one_settled_first_stays(cheapest):
    rng = np.random.default_rng(11)
    for _ in range(300):
        case = random_graph(rng, "ties", most_nodes=30)
        case.costs = np.maximum(case.costs, cheapest)
        field = cairn.plan_graph(*case.csr, case.goals)
        assert field.next_node.tolist() == textbook_pointers(case)


@pytest.mark.parametrize("engine", ENGINES)
def test_every_engine_equals_dijkstra_and_its_pointers_walk_the_field(answered, engine):
    cases, whole, truth = answered

    def plan(case):
        return cairn.plan_layered(*case.csr, case.goals, engine=engine)

    results, values, next_node = planned(cases, plan)
    np.testing.assert_array_equal(values, truth)
    check_pointers(whole, values, next_node)
    assert all(result.converged for result in results)
    assert all(result.levels <= result.layers * result.widest_layer for result in results)
    assert all(result.operations <= result.operations_worst_case for result in results)


@pytest.mark.parametrize("engine", ["levelled", "in_place"])
@pytest.mark.parametrize("schedule", ["fronts", "wavefront"])
def test_threads_and_schedules_give_the_serial_engines_bits(engine, schedule):
    rng = np.random.default_rng(12)
    for kind in KINDS:
        for _ in range(60):
            case = random_graph(rng, kind, most_nodes=40)
            how = {"engine": engine, "record_walks": True, "record_sequence": True}
            serial = cairn.plan_layered(*case.csr, case.goals, **how)
            for threads in (1, 2, 4):
                several = cairn.plan_layered(
                    *case.csr, case.goals, **how, threads=threads, schedule=schedule
                )
                for name, value in vars(serial).items():
                    np.testing.assert_array_equal(getattr(several, name), value)


def test_a_trace_tells_when_each_task_ran_and_what_it_waited_for():
    result = cairn.plan_layered(
        *chain(3), 0, max_levels=5, early_stop=False, threads=2, record_trace=True
    )
    trace = result.trace
    assert trace.waits == [[(1, 1), (2, 1)], [(1, 0), (2, 1), (3, 1)], [(2, 0), (3, 1)]]
    tasks = list(zip(trace.level.tolist(), trace.layer.tolist(), strict=True))
    assert sorted(tasks) == [(i, j) for i in range(1, 6) for j in range(1, min(i, 3) + 1)]
    assert (trace.begin_ns <= trace.end_ns).all()
    begin, end = (dict(zip(tasks, t, strict=True)) for t in (trace.begin_ns, trace.end_ns))
    for (level, layer), began in begin.items():
        for other, lag in trace.waits[layer - 1]:
            if (level - lag, other) in end and (level - lag, other) != (level, layer):
                assert end[level - lag, other] <= began


def test_layers_are_the_least_number_of_links_to_a_goal(answered):
    cases, whole, _ = answered
    results = [cairn.plan_layered(*case.csr, case.goals, engine="classical") for case in cases]
    layers = np.concatenate([result.layer for result in results]).astype(float)
    layers[layers < 0] = np.inf
    np.testing.assert_array_equal(layers, scipy_cost_to_go(whole, unweighted=True))


def test_classical_is_the_optimum_over_falling_links_and_says_when_that_is_not_the_optimum(
    answered,
):
    cases, whole, truth = answered

    def plan(case):
        return cairn.plan_layered(*case.csr, case.goals, engine="classical")

    results, values, next_node = planned(cases, plan)
    layers = np.concatenate([result.layer for result in results])
    falls = (layers[whole.tails] > 0) & (layers[whole.heads] == layers[whole.tails] - 1)
    falling = Case(
        whole.nodes, whole.tails[falls], whole.heads[falls], whole.costs[falls], whole.goals
    )
    np.testing.assert_array_equal(values, scipy_cost_to_go(falling))
    check_pointers(falling, values, next_node)
    ends = np.cumsum([case.nodes for case in cases])[:-1]
    optimal = [
        np.array_equal(a, b)
        for a, b in zip(*(np.split(v, ends) for v in (values, truth)), strict=True)
    ]
    assert [result.converged for result in results] == optimal
    assert not all(optimal)


@pytest.mark.parametrize("engine", ENGINES)
def test_float32_costs_are_added_in_float32(engine):
    for case in random_cases("floats", 700, seed=3):
        case.costs = case.costs.astype(np.float32)
        result = cairn.plan_layered(*case.csr, case.goals, engine=engine)
        assert result.native.dtype == np.float32
        np.testing.assert_array_equal(result.native, textbook_cost_to_go(case, np.float32))


# ---- classical dynamic programming is not enough [Maalouf06 §3.2] ---


def test_classical_misses_a_way_through_its_own_layer_and_one_through_a_higher_layer():
    # 0 is the goal; 1 and 2 reach it in one link, 3 in two. Straight in from 1 is dear.
    within = cairn.graph_from_edges(3, [(1, 0), (1, 2), (2, 0)], [10, 1, 1])
    rising = cairn.graph_from_edges(4, [(1, 0), (1, 3), (3, 2), (2, 0)], [10, 1, 1, 1])
    for graph, best in ((within, 2), (rising, 3)):
        classical = cairn.plan_layered(*graph, 0, engine="classical")
        assert classical.native[1] == 10
        assert not classical.converged
        for engine in ENGINES:
            assert cairn.plan_layered(*graph, 0, engine=engine).native[1] == best


# ---- the layered solution graph ---


def chain(layers, width=1):
    """A two-way graph of `layers` layers of `width` nodes, all linked to the next layer."""
    edges = []
    for layer in range(1, layers + 1):
        nodes = range(1 + (layer - 1) * width, 1 + layer * width)
        below = [0] if layer == 1 else range(1 + (layer - 2) * width, 1 + (layer - 1) * width)
        edges += [(a, b) for a in nodes for b in below] + [(b, a) for a in nodes for b in below]
    return cairn.graph_from_edges(1 + layers * width, edges, np.ones(len(edges), int))


@pytest.mark.parametrize("engine", ["levelled", "in_place"])
def test_operations_run_in_the_papers_order(engine):
    def sequence(layers, levels):
        result = cairn.plan_layered(
            *chain(layers),
            0,
            engine=engine,
            max_levels=levels,
            early_stop=False,
            record_sequence=True,
        )
        assert len(result.sequence) == result.operations
        return result.sequence

    assert sequence(1, 3) == [(1, 1, 0), (2, 1, 1), (3, 1, 1)]
    assert sequence(2, 3) == [
        *[(1, 1, 0)],
        *[(2, 1, 1), (2, 2, 1)],
        *[(3, 1, 1), (3, 1, 2), (3, 2, 1), (3, 2, 2)],
    ]
    assert sequence(3, 4) == [
        *[(1, 1, 0)],
        *[(2, 1, 1), (2, 2, 1)],
        *[(3, 1, 1), (3, 1, 2), (3, 2, 1), (3, 2, 2), (3, 3, 2)],
        *[(4, 1, 1), (4, 1, 2), (4, 2, 1), (4, 2, 2), (4, 2, 3), (4, 3, 2), (4, 3, 3)],
    ]


def test_the_phased_engine_runs_falling_then_within_then_rising_links():
    result = cairn.plan_layered(*chain(3), 0, engine="phased", max_levels=1, record_sequence=True)
    falling, within, rising = [(1, 0), (2, 1), (3, 2)], [(1, 1), (2, 2), (3, 3)], [(2, 3), (1, 2)]
    assert result.sequence == [(1, i, j) for i, j in falling + within + rising]


def test_classical_runs_one_operation_per_layer():
    result = cairn.plan_layered(*chain(3), 0, engine="classical", record_sequence=True)
    assert result.sequence == [(1, 1, 0), (1, 2, 1), (1, 3, 2)]


@pytest.mark.parametrize("engine", ["levelled", "in_place"])
def test_equation_4_is_the_number_of_operations_plus_one_for_all_layers_and_levels(engine):
    printed = {(1, 1): 2, (2, 2): 4, (2, 3): 8, (3, 3): 9, (3, 5): 23, (4, 6): 37, (6, 10): 106}
    for layers, extra in itertools.product(range(1, 7), range(5)):
        levels = layers + extra
        result = cairn.plan_layered(
            *chain(layers), 0, engine=engine, max_levels=levels, early_stop=False
        )
        assert result.operations == result.operations_worst_case
        assert result.operations_equation_4 == result.operations + 1
        assert result.operations_worst_case_equation_4 == result.operations_equation_4
        if (layers, levels) in printed:
            assert result.operations_equation_4 == printed[layers, levels]


def test_a_walk_n_i_is_the_best_of_all_walks_of_exactly_i_links():
    rng = np.random.default_rng(4)
    levels = 5
    for _ in range(150):
        case = random_graph(rng, "integers", most_nodes=4)
        result = cairn.plan_layered(
            *case.csr,
            case.goals,
            engine="levelled",
            max_levels=levels,
            early_stop=False,
            record_walks=True,
        )
        links = {node: [] for node in range(case.nodes)}
        for tail, head, cost in zip(case.tails, case.heads, case.costs, strict=True):
            links[int(tail)].append((int(head), int(cost)))

        def all_walks(node, length, links=links, goals=frozenset(case.goals)):
            if length == 0:
                return [0] if node in goals else []
            if node in goals:
                return []
            return [c + rest for to, c in links[node] for rest in all_walks(to, length - 1)]

        none = np.iinfo(np.uint64).max
        for i, node in itertools.product(range(1, len(result.walks) + 1), range(case.nodes)):
            assert result.walks[i - 1, node] == min(all_walks(node, i), default=none)
        if len(result.walks):
            reached = result.layer > 0
            np.testing.assert_array_equal(  # (5)
                result.native[reached], result.walks.min(axis=0)[reached]
            )


@pytest.mark.parametrize("engine", ENGINES)
def test_an_early_stop_changes_no_bit_of_the_result(engine):
    rng = np.random.default_rng(5)
    for _ in range(300):
        case = random_graph(rng, "ties")
        early, full = (
            cairn.plan_layered(*case.csr, case.goals, engine=engine, early_stop=stop)
            for stop in (True, False)
        )
        np.testing.assert_array_equal(early.native, full.native)
        np.testing.assert_array_equal(early.next_node, full.next_node)
        assert early.operations <= full.operations == full.operations_worst_case
        assert early.converged
        assert full.levels == full.max_levels == full.layers * full.widest_layer


@pytest.mark.parametrize("engine", ENGINES)
def test_intermediate_costs_do_not_depend_on_how_the_nodes_are_numbered(engine):
    rng = np.random.default_rng(10)
    for _ in range(300):
        case = random_graph(rng, "integers")
        number = rng.permutation(case.nodes)
        edges = np.stack([number[case.tails], number[case.heads]], axis=1)
        renumbered = cairn.graph_from_edges(case.nodes, edges, case.costs)
        for levels in range(1, 6):
            a = cairn.plan_layered(*case.csr, case.goals, engine=engine, max_levels=levels)
            b = cairn.plan_layered(
                *renumbered, number[case.goals], engine=engine, max_levels=levels
            )
            np.testing.assert_array_equal(a.native, b.native[number])


@pytest.mark.parametrize("numbers", list(itertools.permutations([1, 2, 3])))
def test_in_place_an_operation_on_its_own_layer_reads_a_copy_of_it(numbers):
    # Layer 1 is a -> b -> c, cheap within, cheap to the goal from c alone.
    a, b, c = numbers
    edges = [(a, 0), (b, 0), (c, 0), (a, b), (b, c)]
    graph = cairn.graph_from_edges(4, edges, [100, 100, 1, 1, 1])
    for levels, expected in [(1, [100, 100, 1]), (2, [100, 2, 1]), (3, [3, 2, 1])]:
        result = cairn.plan_layered(*graph, 0, engine="in_place", max_levels=levels)
        assert result.native[[a, b, c]].tolist() == expected


@pytest.mark.parametrize("engine", ["levelled", "in_place"])
def test_nothing_to_improve_stops_one_level_after_the_last_layer(engine):
    result = cairn.plan_layered(*chain(4, width=5), 0, engine=engine)
    assert (result.levels, result.max_levels) == (5, 20)
    assert result.operations_equation_4 == result.operations + 1
    assert result.operations_worst_case_equation_4 == result.operations_worst_case + 1


def test_all_of_k_times_m_levels_can_be_needed():
    # One layer of four nodes, the best way through all of them: K = 1, M = 4.
    edges = [(1, 0), (2, 0), (3, 0), (4, 0), (1, 2), (2, 3), (3, 4)]
    graph = cairn.graph_from_edges(5, edges, [100, 100, 100, 1, 1, 1, 1])
    for engine in ("levelled", "in_place"):
        short = cairn.plan_layered(*graph, 0, engine=engine, max_levels=3)
        full = cairn.plan_layered(*graph, 0, engine=engine)
        assert (short.native[1], short.converged) == (100, False)
        assert (full.native[1], full.converged, full.levels) == (4, True, 4)


def test_one_way_links_may_rise_many_layers():
    # 1 is in layer 1 with a dear link to the goal; a one-way link takes it up to layer 4.
    edges = [(1, 0), (2, 0), (3, 2), (4, 3), (5, 4), (1, 5)]
    graph = cairn.graph_from_edges(6, edges, [50, 1, 1, 1, 1, 1])
    for engine in ENGINES:
        result = cairn.plan_layered(*graph, 0, engine=engine, record_sequence=True)
        assert result.greatest_rise == 3
        assert (1, 4) in {(i, j) for _, i, j in result.sequence}
        assert result.native[1] == 5
        assert result.path(1).tolist() == [1, 5, 4, 3, 2, 0]
        assert result.operations_equation_4 is None


def test_two_way_links_rise_one_layer_at_most():
    rng = np.random.default_rng(6)
    for _ in range(300):
        case = two_way_graph(rng)
        assert cairn.plan_layered(*case.csr, case.goals).greatest_rise == 1


def test_links_out_of_the_goal_and_infinite_links_are_unused():
    graph = cairn.graph_from_edges(4, [(0, 1), (1, 0), (2, 0), (3, 2)], [0.0, 1.0, np.inf, 1.0])
    for plan in (cairn.plan_graph, cairn.plan_layered):
        field = plan(*graph, 0)
        assert field.cost_to_go.tolist() == [0.0, 1.0, np.inf, np.inf]
        assert field.next_node.tolist() == [-1, 0, -1, -1]
        assert field.path(3) is None
        assert field.path(1).tolist() == [1, 0]


def test_large_integers_are_added_exactly():
    graph = cairn.graph_from_edges(3, [(2, 1), (1, 0)], np.array([2**60 + 1, 2**60]))
    assert int(cairn.plan_graph(*graph, 0).native[2]) == 2**61 + 1
    assert int(cairn.plan_layered(*graph, 0).native[2]) == 2**61 + 1


# ---- bad input ---

GOOD = ([0, 1, 2], [1, 0], [1.0, 2.0])


@pytest.mark.parametrize("plan", [cairn.plan_graph, cairn.plan_layered])
@pytest.mark.parametrize(
    ("changed", "goal", "error", "fields"),
    [
        ({0: [1, 1, 2]}, 0, "IndptrEnds", {"first": 1, "last": 2, "links": 2}),
        ({0: [0, 1, 3]}, 0, "IndptrEnds", {"first": 0, "last": 3, "links": 2}),
        ({0: []}, 0, "IndptrEnds", {"first": -1, "last": -1, "links": 2}),
        ({0: [0, 3, 2]}, 0, "IndptrFalls", {"node": 1, "begin": 3, "end": 2}),
        ({2: [1.0]}, 0, "LinkCostCount", {"costs": 1, "links": 2}),
        ({1: [1, 2]}, 0, "NodeOutOfRange", {"link": 1, "node": 2, "nodes": 2}),
        ({1: [-1, 0]}, 0, "NodeOutOfRange", {"link": 0, "node": -1, "nodes": 2}),
        ({1: [1.0, 0.0]}, 0, "GraphNotPlannable", {"array": "indices"}),
        ({2: ["a", "b"]}, 0, "GraphNotPlannable", {"array": "costs"}),
        ({2: [1.0, np.nan]}, 0, "LinkCostNan", {"link": 1, "source_node": 1, "target_node": 0}),
        ({2: [1.0, -2.0]}, 0, "LinkCostNegative", {"link": 1, "source_node": 1, "value": -2.0}),
        ({2: [-7, 2]}, 0, "LinkCostNegative", {"link": 0, "source_node": 0, "value": -7.0}),
        ({2: [2**62, 2**63 - 1]}, 0, None, {}),
        ({2: np.array([2**63, 2**63], np.uint64)}, 0, "GraphCostOverflow", {"precision": "u64"}),
        ({2: [1.0, 1e308]}, 0, "GraphCostOverflow", {"precision": "f64", "dearest": 1e308}),
        ({}, 2, "GoalNotANode", {"node": 2, "nodes": 2}),
        ({}, -1, "GoalNotANode", {"node": -1, "nodes": 2}),
        ({}, 0.5, "CellNotWhole", {"value": 0.5}),
        ({}, 2**70, "CellNotWhole", {"value": 2**70}),
        ({}, [], "NoGoal", {}),
    ],
)
def test_a_bad_graph_is_refused_by_name(plan, changed, goal, error, fields):
    graph = [changed.get(i, part) for i, part in enumerate(GOOD)]
    if error is None:
        plan(*graph, goal)
        return
    with pytest.raises(getattr(cairn.errors, error)) as caught:
        plan(*graph, goal)
    assert {name: getattr(caught.value, name) for name in fields} == fields


def test_bad_options_starts_and_edges_are_refused_by_name():
    with pytest.raises(cairn.errors.NoLevels):
        cairn.plan_layered(*GOOD, 0, max_levels=0)
    with pytest.raises(cairn.errors.UnknownPlanOption, match="'quick'"):
        cairn.plan_layered(*GOOD, 0, engine="quick")
    with pytest.raises(cairn.errors.UnknownPlanOption, match="'soon'"):
        cairn.plan_layered(*GOOD, 0, threads=2, schedule="soon")
    with pytest.raises(cairn.errors.NoThreads):
        cairn.plan_layered(*GOOD, 0, threads=0)
    with pytest.raises(cairn.errors.NoThreads):
        cairn.plan_graph(*GOOD, 0, threads=0)
    with pytest.raises(cairn.errors.StartNotANode):
        cairn.plan_graph(*GOOD, 0).path(2)
    with pytest.raises(cairn.errors.NodeOutOfRange):
        cairn.graph_from_edges(2, [(0, 2)], [1])
    with pytest.raises(cairn.errors.LinkCostCount):
        cairn.graph_from_edges(2, [(0, 1)], [1, 2])
