use super::buckets::Buckets;
use super::incoming::Incoming;
use super::label::{Label, Width};

/// Cost-to-go and next node of one node, side by side in memory.
#[derive(Clone, Copy)]
pub struct Node<W> {
    pub cost_to_go: W,
    pub next: u32,
}

/// What a search found.
pub struct Found<W> {
    pub nodes: Vec<Node<W>>,
    /// Whether a link cost nothing where it mattered: then the pointers are not right yet.
    pub plateau: bool,
}

/// No next node.
pub const NONE: u32 = u32::MAX;

/// Buckets as long as a quarter of the mean link: measured flat from a half to an eighth.
pub const BUCKETS_PER_MEAN: f64 = 4.0;

/// Label-correcting search in the order of buckets \[Dial69\] [Meyer03]: within a bucket nodes may be
/// lowered again after they were looked at, and are then looked at again. None if a sum did not fit `W`.
///
/// The pointer of a node goes to the least (cost-to-go, node number) of those it is tight to: every one
/// is looked at again at its last cost, and takes over from a node that comes later.
pub fn search<W: Label>(graph: &Incoming<W>, goals: &[u32]) -> Option<Found<W>> {
    let width = Width::about(graph.mean / BUCKETS_PER_MEAN);
    let mut nodes = vec![Node { cost_to_go: W::UNREACHABLE, next: NONE }; graph.nodes()];
    let mut queue = Buckets::new();
    for &goal in goals {
        nodes[goal as usize].cost_to_go = W::ZERO;
        queue.push(W::ZERO.bucket(width), (W::ZERO, goal));
    }
    let mut plateau = false;
    let mut batch = Vec::new();
    while queue.advance(|&(value, _): &(W, u32)| value.bucket(width)) {
        while queue.take(&mut batch) {
            for &(value, node) in &batch {
                if nodes[node as usize].cost_to_go < value {
                    continue; // lowered since
                }
                for &(from, cost) in graph.into(node) {
                    let candidate = value.plus(cost)?;
                    let before = nodes[from as usize];
                    if candidate < before.cost_to_go {
                        plateau |= candidate == value;
                        nodes[from as usize] = Node { cost_to_go: candidate, next: node };
                        queue.push(candidate.bucket(width), (candidate, from));
                    } else if candidate == before.cost_to_go && before.next != NONE {
                        let rival = nodes[before.next as usize].cost_to_go;
                        if value < rival || (value == rival && node < before.next) {
                            nodes[from as usize].next = node;
                        }
                    }
                }
            }
            batch.clear();
        }
    }
    Some(Found { nodes, plateau })
}
