use super::search::{Found, Incoming, Label, NONE, policy, search, search_in_parallel};
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

/// The field of a graph: the least fixed point of J(s) = min over links (s, n) of c(s, n) + J(n), from
/// the goals backwards \[Bellman57\].
///
/// Sums run from the goal, one rounded add per link. Costs may be zero. Pointers are those of
/// Dijkstra's algorithm \[Dijkstra59\] that settles nodes in the order of (cost-to-go, node number) as
/// they come up and changes a pointer only on strict improvement: among equally good next nodes the one
/// settled first stays, and pointers never cycle. At most `threads` threads are used (None: one), and
/// one alone on graphs too small to gain; neither costs nor pointers depend on it.
///
/// # Errors
/// [`PlanError::NoGoal`], [`GoalNotANode`](PlanError::GoalNotANode), [`NoThreads`](PlanError::NoThreads),
/// [`GraphCostOverflow`](PlanError::GraphCostOverflow).
pub fn plan_graph<C: GraphCost>(
    graph: &Graph<C>,
    goals: &[usize],
    threads: Option<usize>,
) -> Result<GraphField<C>, PlanError> {
    if threads == Some(0) {
        return Err(PlanError::NoThreads);
    }
    let goals = graph.checked_goals(goals)?;
    graph.check_walks_of(graph.nodes())?;
    Ok(C::planned(graph, &goals, threads.unwrap_or(1)))
}

/// A cost that [`plan_graph`] plans in: u32, u64, f32 or f64.
pub trait GraphCost: Label {
    /// The field of a graph whose walks all fit.
    #[doc(hidden)]
    fn planned(graph: &Graph<Self>, goals: &[u32], threads: usize) -> GraphField<Self>;
}

macro_rules! graph_cost {
    ($($type:ident),*) => {$(
        impl GraphCost for $type {
            fn planned(graph: &Graph<Self>, goals: &[u32], threads: usize) -> GraphField<Self> {
                planned_in(graph, goals, threads, |cost| cost, |value: $type| value).expect("every walk fits: checked before")
            }
        }
    )*};
}

graph_cost!(u32, f32, f64);

impl GraphCost for u64 {
    /// In u32 if every cost-to-go fits: half the memory, and memory is what takes the time.
    fn planned(graph: &Graph<Self>, goals: &[u32], threads: usize) -> GraphField<Self> {
        let narrow = |cost| u32::try_from(cost).expect("no link is dearer than the dearest");
        let widen = |value: u32| if value == u32::UNREACHABLE { u64::UNREACHABLE } else { u64::from(value) };
        let promising = graph.dearest() < DEAREST_TO_TRY_NARROW;
        promising.then(|| planned_in(graph, goals, threads, narrow, widen)).flatten().unwrap_or_else(|| {
            planned_in(graph, goals, threads, |cost| cost, |value| value).expect("every walk fits: checked")
        })
    }
}

/// Dearer links are likely to leave u32 within a few steps.
const DEAREST_TO_TRY_NARROW: u64 = 1 << 27;

/// Fewer links are done before threads have started.
const LINKS_WORTH_THREADS: usize = 1 << 16;

/// More cores than a front has room for; a number of threads that any system starts.
const MOST_THREADS: usize = 64;

/// The field, computed in costs of type `W`; None if a sum did not fit.
fn planned_in<C: Cost, W: Label>(
    graph: &Graph<C>,
    goals: &[u32],
    threads: usize,
    narrow: impl Fn(C) -> W + Sync,
    widen: impl Fn(W) -> C,
) -> Option<GraphField<C>> {
    let threads = if graph.links() < LINKS_WORTH_THREADS { 1 } else { threads.min(MOST_THREADS) };
    let incoming = Incoming::new(graph, threads, narrow);
    if threads > 1 {
        let cost_to_go: Vec<C> =
            search_in_parallel(&incoming, goals, threads)?.into_iter().map(widen).collect();
        let next = policy(graph, goals, &cost_to_go, threads);
        return Some(GraphField { cost_to_go, next });
    }
    let Found { nodes, plateau } = search(&incoming, goals)?;
    let cost_to_go: Vec<C> = nodes.iter().map(|node| widen(node.cost_to_go)).collect();
    let next = if plateau {
        policy(graph, goals, &cost_to_go, threads)
    } else {
        nodes.iter().map(|node| (node.next != NONE).then_some(node.next)).collect()
    };
    Some(GraphField { cost_to_go, next })
}
