use super::label::Label;
use super::shares;
use crate::plan::{Cost, Graph};

/// The links of a graph by the node they lead to, with costs of type `W`.
pub struct Incoming<W> {
    starts: Vec<u32>,
    links: Vec<Link<W>>,
    /// Mean cost of a link.
    pub mean: f64,
}

/// A link into a node: where it comes from and what it costs. A pair, as pairs of zeros come from the
/// system for nothing, to be touched first by the thread that fills them.
pub type Link<W> = (u32, W);

/// The most threads that read all links, each to keep its own: more would only read.
const MOST_READERS: usize = 8;

impl<W: Label> Incoming<W> {
    /// Turns every link round, by counting: each thread those into nodes of its own. Links into a node
    /// are in the order of the nodes they come from.
    pub fn new<C: Cost>(graph: &Graph<C>, threads: usize, narrow: impl Fn(C) -> W + Sync) -> Self {
        let nodes = graph.nodes();
        let share = nodes.div_ceil(threads.min(MOST_READERS)).max(1);
        let mut starts = vec![0_u32; nodes + 1];
        shares::run(starts[1..].chunks_mut(share).enumerate(), |(part, counts)| {
            count(graph, part * share, counts);
        });
        for node in 0..nodes {
            starts[node + 1] += starts[node];
        }
        let mut links = vec![(0, W::ZERO); graph.links()];
        let mut free = &mut links[..];
        let parts = (0..nodes).step_by(share).map(|first| {
            let places = &starts[first..(first + share).min(nodes) + 1];
            let begin = places[0];
            let (own, rest) =
                std::mem::take(&mut free).split_at_mut((places[places.len() - 1] - begin) as usize);
            free = rest;
            let places: Vec<u32> = places.iter().map(|&place| place - begin).collect();
            (first, places, own)
        });
        let parts: Vec<_> = parts.collect();
        let sums =
            shares::run(parts.into_iter(), |(first, places, own)| fill(graph, &narrow, first, places, own));
        let mean = sums.iter().sum::<f64>() / graph.links().max(1) as f64;
        Self { starts, links, mean }
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.starts.len() - 1
    }

    /// The links into `node`.
    #[inline]
    pub fn into(&self, node: u32) -> &[Link<W>] {
        &self.links[self.starts[node as usize] as usize..self.starts[node as usize + 1] as usize]
    }
}

/// Counts the links into each node from `first` on.
fn count<C: Cost>(graph: &Graph<C>, first: usize, counts: &mut [u32]) {
    for &target in graph.arrays().1 {
        if let Some(count) = counts.get_mut((target as usize).wrapping_sub(first)) {
            *count += 1;
        }
    }
}

/// Puts the links into each node from `first` on where the node's place is; returns the sum of their costs.
fn fill<C: Cost, W: Label>(
    graph: &Graph<C>,
    narrow: impl Fn(C) -> W,
    first: usize,
    mut places: Vec<u32>,
    links: &mut [Link<W>],
) -> f64 {
    let (starts, targets, costs) = graph.arrays();
    let mut sum = 0.0;
    // The last place is the end, and no node's own.
    places.pop();
    for node in 0..graph.nodes() {
        let range = starts[node] as usize..starts[node + 1] as usize;
        for (&target, &cost) in targets[range.clone()].iter().zip(&costs[range]) {
            if let Some(place) = places.get_mut((target as usize).wrapping_sub(first)) {
                let cost = narrow(cost);
                sum += cost.to_f64();
                links[*place as usize] = (node as u32, cost);
                *place += 1;
            }
        }
    }
    sum
}
