use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::shares;
use crate::plan::{Cost, Graph};

/// The pointer of every node, from the cost-to-go alone: the one that Dijkstra's algorithm sets that
/// settles nodes by (cost-to-go, node number) as they come up. It is the tight link to the node that
/// was settled first.
///
/// Nodes of one cost-to-go are settled in the order of their numbers, but for those that are only
/// reached by links of no cost, or of one lost in rounding: they come up late, from within their plateau.
pub fn policy<C: Cost>(
    graph: &Graph<C>,
    goals: &[u32],
    costs_to_go: &[C],
    threads: usize,
) -> Vec<Option<u32>> {
    let nodes = costs_to_go.len();
    let share = nodes.div_ceil(threads).max(1);
    let mut next = vec![None; nodes];
    let parts = next.chunks_mut(share).enumerate();
    let flat =
        shares::run(parts, |(part, next)| descend(graph, costs_to_go, |node| node, part * share, next));
    let mut flat = flat.concat();
    flat.retain(|node| goals.binary_search(node).is_err());
    if !flat.is_empty() {
        let (ranks, across) = settle_plateaus(graph, costs_to_go, &flat);
        let parts = next.chunks_mut(share).enumerate();
        shares::run(parts, |(part, next)| {
            descend(graph, costs_to_go, |node| ranks[node as usize], part * share, next)
        });
        across.into_iter().for_each(|(node, ahead)| next[node as usize] = Some(ahead));
    }
    next
}

/// Points nodes from `first` on at that node below them, of those they are tight to, which is the first
/// by (cost-to-go, rank); returns those that have a way and none such.
fn descend<C: Cost>(
    graph: &Graph<C>,
    costs_to_go: &[C],
    rank: impl Fn(u32) -> u32,
    first: usize,
    next: &mut [Option<u32>],
) -> Vec<u32> {
    let mut flat = Vec::new();
    for (node, next) in (first..).zip(next) {
        let value = costs_to_go[node];
        if value == C::UNREACHABLE {
            continue;
        }
        let (mut lowest, mut best) = (value, None);
        for (ahead, cost) in graph.links_from(node) {
            let there = costs_to_go[ahead];
            // What is no lower cannot win, least of all a node without a way.
            if there > lowest || there == value || there.plus(cost) != Some(value) {
                continue;
            }
            let ahead = ahead as u32;
            if there < lowest || best.is_none_or(|best| rank(ahead) < rank(best)) {
                (lowest, best) = (there, Some(ahead));
            }
        }
        *next = best;
        if best.is_none() {
            flat.push(node as u32);
        }
    }
    flat
}

/// Settles every plateau that has nodes of `flat`: nodes below which there is none they are tight to.
/// The rank of every node, in the order of settling among those of its cost-to-go, and the pointers of
/// `flat`.
fn settle_plateaus<C: Cost>(
    graph: &Graph<C>,
    costs_to_go: &[C],
    flat: &[u32],
) -> (Vec<u32>, Vec<(u32, u32)>) {
    let key = |node: u32| costs_to_go[node as usize].key();
    let mut heights: Vec<C::Key> = flat.iter().map(|&node| key(node)).collect();
    heights.sort_unstable();
    heights.dedup();
    // (next node, node) of every link that costs nothing there, by next node.
    let mut level: Vec<(u32, u32)> = Vec::new();
    for &node in flat {
        let value = costs_to_go[node as usize];
        for (ahead, cost) in graph.links_from(node as usize) {
            if costs_to_go[ahead] == value && value.plus(cost) == Some(value) {
                level.push((ahead as u32, node));
            }
        }
    }
    level.sort_unstable();
    let mut unseen = vec![false; costs_to_go.len()];
    flat.iter().for_each(|&node| unseen[node as usize] = true);
    let mut heap: BinaryHeap<Reverse<(C::Key, u32)>> = (0..costs_to_go.len() as u32)
        .filter(|&node| !unseen[node as usize] && heights.binary_search(&key(node)).is_ok())
        .map(|node| Reverse((key(node), node)))
        .collect();

    let mut ranks: Vec<u32> = (0..costs_to_go.len() as u32).collect();
    let mut across = Vec::with_capacity(flat.len());
    let mut settled = 0;
    while let Some(Reverse((key, ahead))) = heap.pop() {
        ranks[ahead as usize] = settled;
        settled += 1;
        let begin = level.partition_point(|&(to, _)| to < ahead);
        for &(_, node) in level[begin..].iter().take_while(|&&(to, _)| to == ahead) {
            if std::mem::take(&mut unseen[node as usize]) {
                across.push((node, ahead));
                heap.push(Reverse((key, node)));
            }
        }
    }
    (ranks, across)
}
