//! Every way of searching against Dijkstra's algorithm with a binary heap.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::{Found, Incoming, NONE, policy, search, search_in_parallel};
use crate::plan::{Graph, GraphCost, plan_graph};

/// Costs-to-go and pointers as the textbook has them: nodes settled by (cost-to-go, node number), a
/// pointer changed only by what is strictly better.
fn textbook<C: GraphCost>(graph: &Graph<C>, goals: &[u32]) -> (Vec<C>, Vec<Option<u32>>) {
    let reversed = graph.reversed();
    let (mut costs, mut next) = (vec![C::UNREACHABLE; graph.nodes()], vec![None; graph.nodes()]);
    let mut open = BinaryHeap::new();
    for &goal in goals {
        costs[goal as usize] = C::ZERO;
        open.push(Reverse((C::ZERO.key(), goal)));
    }
    while let Some(Reverse((key, node))) = open.pop() {
        let value = costs[node as usize];
        if value.key() < key {
            continue;
        }
        for (before, cost) in reversed.links_from(node as usize) {
            let candidate = value.plus(cost).unwrap();
            if candidate < costs[before] {
                (costs[before], next[before]) = (candidate, Some(node));
                open.push(Reverse((candidate.key(), before as u32)));
            }
        }
    }
    (costs, next)
}

struct Random(u64);

impl Random {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % limit
    }
}

fn random_graph<C: GraphCost>(
    random: &mut Random,
    most_nodes: u64,
    cost: impl Fn(&mut Random) -> C,
) -> (Graph<C>, Vec<u32>) {
    let nodes = 1 + random.below(most_nodes);
    let links = random.below(5 * nodes);
    let node = |random: &mut Random| random.below(nodes) as usize;
    let edges: Vec<_> = (0..links).map(|_| (node(random), node(random), cost(random))).collect();
    let mut goals: Vec<u32> = (0..1 + random.below(3)).map(|_| node(random) as u32).collect();
    goals.sort_unstable();
    goals.dedup();
    (Graph::from_edges(nodes as usize, &edges).unwrap(), goals)
}

fn check<C: GraphCost>(cost: impl Fn(&mut Random) -> C) {
    let mut random = Random(7);
    for round in 0..300 {
        let (graph, goals) = random_graph(&mut random, if round % 10 == 0 { 400 } else { 12 }, &cost);
        let (costs, next) = textbook(&graph, &goals);
        let planned =
            plan_graph(&graph, &goals.iter().map(|&goal| goal as usize).collect::<Vec<_>>(), None).unwrap();
        assert_eq!((&planned.cost_to_go, &planned.next), (&costs, &next));
        for threads in 1..=3 {
            assert_eq!(policy(&graph, &goals, &costs, threads), next);
            let incoming = Incoming::new(&graph, threads, |cost| cost);
            assert_eq!(search_in_parallel(&incoming, &goals, threads).unwrap(), costs);
            let Found { nodes, plateau } = search(&incoming, &goals).unwrap();
            assert!(nodes.iter().map(|node| node.cost_to_go).eq(costs.iter().copied()));
            if !plateau {
                assert!(nodes.iter().map(|n| (n.next != NONE).then_some(n.next)).eq(next.iter().copied()));
            }
        }
    }
}

#[test]
fn every_search_is_dijkstras_in_integers_with_ties_and_links_of_no_cost() {
    check(|random| random.below(4) as u32);
    check(|random| random.below(3) * random.below(1000));
    check(|_| 0_u64);
    check(|_| 1_u32);
}

#[test]
fn every_search_is_dijkstras_in_floats_where_costs_are_lost_in_rounding() {
    check(|random| 10.0_f32.powi(random.below(19) as i32 - 9));
    check(|random| 10.0_f64.powi(random.below(40) as i32 - 20) * random.below(3) as f64);
    check(|random| random.below(1000) as f64 / 7.0);
    check(|random| if random.below(2) == 0 { f32::MIN_POSITIVE / 8.0 } else { 1.0 });
}

#[test]
fn every_search_is_dijkstras_where_costs_span_the_type() {
    check(|random| random.below(1 << 40) >> random.below(40));
    check(|random| (1_u64 << random.below(50)) + random.below(3));
}

#[test]
fn a_sum_beyond_32_bits_is_found_out_and_added_up_in_64() {
    let dear = (1_u64 << 27) - 1;
    let edges: Vec<_> = (0..100_usize).map(|node| (node + 1, node, dear)).collect();
    let graph = Graph::from_edges(101, &edges).unwrap();
    let narrow = Incoming::new(&graph, 1, |cost| cost as u32);
    assert!(search(&narrow, &[0]).is_none());
    assert!(search_in_parallel(&narrow, &[0], 2).is_none());
    assert_eq!(plan_graph(&graph, &[0], None).unwrap().cost_to_go[100], 100 * dear);
}

#[test]
fn a_large_graph_gives_the_same_bits_for_every_number_of_threads() {
    let mut random = Random(3);
    let nodes = 30_000;
    let edges: Vec<_> = (0..120_000)
        .map(|_| (random.below(nodes) as usize, random.below(nodes) as usize, random.below(50)))
        .collect();
    let whole = Graph::<u64>::from_edges(nodes as usize, &edges).unwrap();
    let (costs, next) = textbook(&whole, &[5, 77]);
    for threads in [1, 2, 3, 8] {
        let field = plan_graph(&whole, &[77, 5], Some(threads)).unwrap();
        assert_eq!((&field.cost_to_go, &field.next), (&costs, &next), "{threads} threads");
    }
}
