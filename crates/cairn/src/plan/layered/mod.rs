//! The planner of the paper on any directed graph [Maalouf06 §3]: four engines, equal in result
//! wherever the problem is theirs. The reference that faster solvers are held against.

mod count;
mod engines;
#[cfg(test)]
mod laws;
mod layers;
mod parallel;
mod playout;
mod schedule;

use serde::{Deserialize, Serialize};

use super::{Cost, Graph, GraphField, PlanError};
pub use count::equation_4;
use engines::State;
use layers::Layers;
pub use parallel::{Clock, Timed, Trace};
pub use playout::play_out;
pub use schedule::{Schedule, Task, Wait};

/// In which order DP(i, j) is applied, and to which values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Engine {
    /// §3.1: links that fall one layer, once, from layer 1 up. Optimal only if no best way needs others.
    Classical,
    /// §3.2, first description: all falling links (layers ascending), then all links within layers
    /// (ascending), then all rising ones (descending), repeated.
    Phased,
    /// §3.2, the layered solution graph: level i reads only level i − 1.
    Levelled,
    /// §3.2, Fig. 4: the operations of the layered solution graph in its order, on one cost per node.
    InPlace,
}

/// How to run the layered planner.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LayeredOptions {
    /// The engine.
    pub engine: Engine,
    /// Levels of the solution graph (repetitions of the phased engine). None: K·M, which always
    /// suffices and can be needed, K the number of layers and M the size of the largest.
    pub max_levels: Option<usize>,
    /// Whether to stop after a level beyond K (any repetition) that changed no C⁺ [Maalouf06 §3.4].
    pub early_stop: bool,
    /// Whether to record every DP(i, j).
    pub record_sequence: bool,
    /// Whether the levelled engine records n_i of every level: the best walk of exactly i links.
    pub record_walks: bool,
    /// Threads that share the levelled or the in-place engine's work as a task graph [Maalouf06 §3.3].
    /// None: the serial engine. The other engines are serial. The result does not depend on it.
    pub threads: Option<usize>,
    /// In what order they take it.
    pub schedule: Schedule,
}

impl Default for LayeredOptions {
    fn default() -> Self {
        Self {
            engine: Engine::InPlace,
            max_levels: None,
            early_stop: true,
            record_sequence: false,
            record_walks: false,
            threads: None,
            schedule: Schedule::Wavefront,
        }
    }
}

/// DP(layer, next_layer) at a level; next layer 0 is the goal layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Operation {
    /// Level (repetition of the phased engine), from 1.
    pub level: u32,
    /// Layer whose nodes choose, from 1.
    pub layer: u32,
    /// Layer they choose from; 0 is the goal layer.
    pub next_layer: u32,
}

/// What the layered planner found, and what it did for it.
#[derive(Clone, Debug, PartialEq)]
pub struct LayeredPlan<C> {
    /// C⁺ and pointer of every node [Maalouf06 (5)]. Equal to C* if `converged` (and not classical).
    /// Ties: the pointer that was found first in the engine's order stays.
    pub field: GraphField<C>,
    /// Layer of every node: least number of links to a goal; None where there is no way.
    pub layer: Vec<Option<u32>>,
    /// Number of layers, K.
    pub layers: usize,
    /// Size of the largest layer, M.
    pub widest_layer: usize,
    /// Greatest rise r of any link, at least 1 (two-way graphs: 1).
    pub greatest_rise: usize,
    /// Levels really done.
    pub levels: usize,
    /// Levels allowed.
    pub max_levels: usize,
    /// Whether no further level can change any C⁺: it stopped early, or K·M levels were done. For the
    /// classical engine: whether the field happens to be optimal.
    pub converged: bool,
    /// Operations DP(i, j) really done.
    pub operations: u64,
    /// Operations of `max_levels` levels.
    pub operations_worst_case: u64,
    /// The printed equation (4) for the levels really done; None where it does not hold: fewer levels
    /// than layers, links that rise by more than one layer, or an engine without levels.
    pub equation_4: Option<u64>,
    /// The printed equation (4) for `max_levels` levels; None as above.
    pub equation_4_worst_case: Option<u64>,
    /// Every operation in order, if asked for.
    pub sequence: Option<Vec<Operation>>,
    /// n_i for i = 1..=levels, if asked for: the best walk of exactly i links that meets no goal
    /// before its end.
    pub walks: Option<Vec<Vec<C>>>,
}

/// Cost-to-go and next node of every node by the paper's own algorithm.
///
/// J(goal) = 0; J(s) = min over x of C_{s,x} + J(x) [Maalouf06 (2), (3), (5)], layers numbered from
/// the goal. Links may fall one layer, stay, or rise by any number of layers.
///
/// # Errors
/// [`PlanError::NoGoal`], [`GoalNotANode`](PlanError::GoalNotANode), [`NoLevels`](PlanError::NoLevels),
/// [`NoThreads`](PlanError::NoThreads),
/// [`GraphCostOverflow`](PlanError::GraphCostOverflow) where a walk of as many links as there are
/// nodes, or levels of the levelled engine, might not fit the cost type.
pub fn plan_layered<C: Cost>(
    graph: &Graph<C>,
    goals: &[usize],
    options: &LayeredOptions,
) -> Result<LayeredPlan<C>, PlanError> {
    Ok(planned(graph, goals, options, None)?.0)
}

/// [`plan_layered`] with a record of when each task ran, by a clock of the caller's. The record is
/// empty for an engine that is serial.
///
/// # Errors
/// As `plan_layered`.
pub fn trace_layered<C: Cost>(
    graph: &Graph<C>,
    goals: &[usize],
    options: &LayeredOptions,
    clock: Clock<'_>,
) -> Result<(LayeredPlan<C>, Trace), PlanError> {
    planned(graph, goals, options, Some(clock))
}

fn planned<C: Cost>(
    graph: &Graph<C>,
    goals: &[usize],
    options: &LayeredOptions,
    clock: Option<Clock<'_>>,
) -> Result<(LayeredPlan<C>, Trace), PlanError> {
    let goals = graph.checked_goals(goals)?;
    if options.max_levels == Some(0) {
        return Err(PlanError::NoLevels);
    }
    if options.threads == Some(0) {
        return Err(PlanError::NoThreads);
    }
    let layers = Layers::new(graph, &goals);
    let suffices = layers.count() * layers.widest();
    let max_levels = match options.engine {
        Engine::Classical => 1,
        _ => options.max_levels.unwrap_or(suffices),
    };
    // C⁺ never exceeds the cost of the falling links that first gave it; n_i has i links.
    let longest = if options.engine == Engine::Levelled { max_levels } else { 0 };
    graph.check_walks_of(longest.max(graph.nodes()))?;

    let has_levels = matches!(options.engine, Engine::Levelled | Engine::InPlace);
    let (done, trace) = match options.threads.filter(|_| has_levels) {
        Some(threads) => {
            let threads = threads.min(MOST_THREADS);
            let found = parallel::run(&layers, &goals, options, max_levels, threads, clock);
            (Done::of(&layers, options, found.field, found.levels, found.settled, found.walks), found.trace)
        }
        None => (Done::by_one(&layers, &goals, options, max_levels), Trace::default()),
    };
    let converged = match options.engine {
        Engine::Classical => is_fixed_point(graph, &goals, &done.field.cost_to_go),
        _ => done.settled || done.levels >= suffices,
    };
    let printed = |levels| {
        if has_levels && layers.greatest_rise == 1 { equation_4(layers.count(), levels) } else { None }
    };
    let plan = LayeredPlan {
        layers: layers.count(),
        widest_layer: layers.widest(),
        greatest_rise: layers.greatest_rise,
        levels: done.levels,
        max_levels,
        converged,
        operations: done.operations,
        operations_worst_case: engines::operations_of(&layers, options.engine, max_levels),
        equation_4: printed(done.levels),
        equation_4_worst_case: printed(max_levels),
        sequence: done.sequence,
        walks: done.walks,
        field: done.field,
        layer: layers.of_node,
    };
    Ok((plan, trace))
}

/// More threads than a schedule has use for; a number that any system starts.
const MOST_THREADS: usize = 64;

/// What an engine did.
struct Done<C> {
    field: GraphField<C>,
    levels: usize,
    settled: bool,
    operations: u64,
    sequence: Option<Vec<Operation>>,
    walks: Option<Vec<Vec<C>>>,
}

impl<C: Cost> Done<C> {
    fn by_one(layers: &Layers<C>, goals: &[u32], options: &LayeredOptions, max_levels: usize) -> Self {
        let mut state = State::new(layers, goals, options);
        let settled = match options.engine {
            Engine::Classical => state.classical(),
            Engine::Phased => state.phased(max_levels, options.early_stop),
            Engine::Levelled => state.levelled(max_levels, options.early_stop),
            Engine::InPlace => state.in_place(max_levels, options.early_stop),
        };
        let State { field, levels, operations, sequence, walks, .. } = state;
        Self { field, levels, settled, operations, sequence, walks }
    }

    /// Of the task graph: its levels hold the operations of the serial engines' levels.
    fn of(
        layers: &Layers<C>,
        options: &LayeredOptions,
        field: GraphField<C>,
        levels: usize,
        settled: bool,
        walks: Option<Vec<Vec<C>>>,
    ) -> Self {
        let operations = engines::operations_of(layers, options.engine, levels);
        let sequence = options.record_sequence.then(|| engines::sequence_of(layers, levels));
        Self { field, levels, settled, operations, sequence, walks }
    }
}

fn is_fixed_point<C: Cost>(graph: &Graph<C>, goals: &[u32], values: &[C]) -> bool {
    (0..graph.nodes()).filter(|&node| goals.binary_search(&(node as u32)).is_err()).all(|node| {
        let better = |(next, cost): (usize, C)| {
            values[next] < C::UNREACHABLE && values[next].plus(cost).is_some_and(|sum| sum < values[node])
        };
        !graph.links_from(node).any(better)
    })
}
