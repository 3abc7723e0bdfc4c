use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::{Cost, Graph, PlanError};

/// Cost-to-go and next node of every node of a graph.
#[derive(Clone, Debug, PartialEq)]
pub struct GraphField<C> {
    /// Cost of the best way from each node to a goal: 0 at goals, `UNREACHABLE` where there is none.
    pub cost_to_go: Vec<C>,
    /// The next node on it; None at goals and where there is no way.
    pub next: Vec<Option<u32>>,
}

impl<C: Cost> GraphField<C> {
    /// The nodes from `start` to a goal, both included; None where there is no way or no such node.
    pub fn path(&self, start: usize) -> Option<Vec<usize>> {
        self.cost_to_go.get(start).filter(|&&cost| cost < C::UNREACHABLE)?;
        // Pointers change only on strict improvement, so they never cycle, zero costs or not.
        Some(std::iter::successors(Some(start), |&node| self.next[node].map(|next| next as usize)).collect())
    }
}

/// The field of a graph by Dijkstra's algorithm from the goals backwards.
///
/// Sums run from the goal, one rounded add per link. Costs may be zero: nodes are settled in the
/// order of (cost-to-go, node number) as they come up, a pointer changes only on strict improvement,
/// so among equally good next nodes the one settled first stays and pointers never cycle.
///
/// # Errors
/// [`PlanError::NoGoal`], [`GoalNotANode`](PlanError::GoalNotANode),
/// [`GraphCostOverflow`](PlanError::GraphCostOverflow).
pub fn plan_graph<C: Cost>(graph: &Graph<C>, goals: &[usize]) -> Result<GraphField<C>, PlanError> {
    let goals = graph.checked_goals(goals)?;
    graph.check_walks_of(graph.nodes())?;
    let reversed = graph.reversed();
    let mut field =
        GraphField { cost_to_go: vec![C::UNREACHABLE; graph.nodes()], next: vec![None; graph.nodes()] };
    let mut open = BinaryHeap::new();
    for &goal in &goals {
        field.cost_to_go[goal as usize] = C::ZERO;
        open.push(Reverse((C::ZERO.key(), goal)));
    }
    while let Some(Reverse((key, node))) = open.pop() {
        let value = field.cost_to_go[node as usize];
        if value.key() < key {
            continue;
        }
        for (before, cost) in reversed.links_from(node as usize) {
            let candidate = value.plus(cost).expect("every walk fits: checked above");
            if candidate < field.cost_to_go[before] {
                field.cost_to_go[before] = candidate;
                field.next[before] = Some(node);
                open.push(Reverse((candidate.key(), before as u32)));
            }
        }
    }
    Ok(field)
}
