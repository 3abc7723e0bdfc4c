use super::moves::Moves;
use super::solve::{PlanOptions, free_cells};
use super::tiles::CellNumber;
use super::{Cost, PlanError};
use crate::world::Grid;

/// A directed graph with a cost on every link, links of a node side by side (CSR).
///
/// Costs are >= 0; they may differ by direction. A link of infinite cost (the largest value of the
/// integer types) is no link: it is left out, as obstacles are [Maalouf06 §3.2].
#[derive(Clone, Debug, PartialEq)]
pub struct Graph<C> {
    starts: Vec<u32>,
    targets: Vec<u32>,
    costs: Vec<C>,
    dearest: C,
}

impl<C: Cost> Graph<C> {
    /// A graph from CSR arrays: node i has the links `indptr[i]..indptr[i + 1]`, link k leads to
    /// node `indices[k]` and costs `costs[k]`.
    ///
    /// # Errors
    /// [`PlanError::IndptrEnds`], [`IndptrFalls`](PlanError::IndptrFalls),
    /// [`LinkCostCount`](PlanError::LinkCostCount), [`NodeOutOfRange`](PlanError::NodeOutOfRange),
    /// [`LinkCostNan`](PlanError::LinkCostNan), [`LinkCostNegative`](PlanError::LinkCostNegative),
    /// [`GraphTooLarge`](PlanError::GraphTooLarge).
    pub fn from_csr(indptr: &[i64], indices: &[i64], costs: &[C]) -> Result<Self, PlanError> {
        Self::from_csr_of(indptr, indices, costs, |&cost| Ok(cost))
    }

    /// `cost_of` turns a given cost into this graph's, or says what negative number it is.
    fn from_csr_of<S>(
        indptr: &[i64],
        indices: &[i64],
        costs: &[S],
        cost_of: impl Fn(&S) -> Result<C, f64>,
    ) -> Result<Self, PlanError> {
        let links = indices.len();
        let (first, last) = (indptr.first().copied().unwrap_or(-1), indptr.last().copied().unwrap_or(-1));
        if first != 0 || last != links as i64 {
            return Err(PlanError::IndptrEnds { first, last, links });
        }
        if costs.len() != links {
            return Err(PlanError::LinkCostCount { costs: costs.len(), links });
        }
        for (node, ends) in indptr.windows(2).enumerate() {
            if ends[1] < ends[0] {
                return Err(PlanError::IndptrFalls { node, begin: ends[0], end: ends[1] });
            }
        }
        let nodes = indptr.len() - 1;
        let mut graph = Self::empty(nodes, links)?;
        for (source_node, ends) in indptr.windows(2).enumerate() {
            for link in ends[0] as usize..ends[1] as usize {
                let to = indices[link];
                let target_node = usize::try_from(to).ok().filter(|&target| target < nodes);
                let target_node = target_node.ok_or(PlanError::NodeOutOfRange { link, node: to, nodes })?;
                let negative = |value| PlanError::LinkCostNegative { link, source_node, target_node, value };
                graph.push(link, source_node, target_node, cost_of(&costs[link]).map_err(negative)?)?;
            }
            graph.starts.push(graph.targets.len() as u32);
        }
        Ok(graph)
    }

    /// A graph of `nodes` nodes from links (from, to, cost). Links of one node keep their order.
    ///
    /// # Errors
    /// As [`from_csr`](Self::from_csr).
    pub fn from_edges(nodes: usize, edges: &[(usize, usize, C)]) -> Result<Self, PlanError> {
        for (link, &(from, to, _)) in edges.iter().enumerate() {
            if let Some(node) = [from, to].into_iter().find(|&node| node >= nodes) {
                let node = i64::try_from(node).unwrap_or(i64::MAX);
                return Err(PlanError::NodeOutOfRange { link, node, nodes });
            }
        }
        let mut graph = Self::empty(nodes, edges.len())?;
        let mut order: Vec<usize> = (0..edges.len()).collect();
        order.sort_by_key(|&link| edges[link].0);
        let mut sorted = order.into_iter().peekable();
        for node in 0..nodes {
            while let Some(link) = sorted.next_if(|&link| edges[link].0 == node) {
                graph.push(link, node, edges[link].1, edges[link].2)?;
            }
            graph.starts.push(graph.targets.len() as u32);
        }
        Ok(graph)
    }

    fn empty(nodes: usize, links: usize) -> Result<Self, PlanError> {
        let most = u32::MAX as usize;
        if nodes >= most || links >= most {
            return Err(PlanError::GraphTooLarge { nodes, links, most });
        }
        let mut starts = Vec::with_capacity(nodes + 1);
        starts.push(0);
        let (targets, costs) = (Vec::with_capacity(links), Vec::with_capacity(links));
        Ok(Self { starts, targets, costs, dearest: C::ZERO })
    }

    fn push(&mut self, link: usize, from: usize, to: usize, cost: C) -> Result<(), PlanError> {
        let (source_node, target_node, value) = (from, to, cost.to_f64());
        if cost.is_nan() {
            return Err(PlanError::LinkCostNan { link, source_node, target_node, value });
        }
        if cost < C::ZERO {
            return Err(PlanError::LinkCostNegative { link, source_node, target_node, value });
        }
        if cost < C::UNREACHABLE {
            let cost = if cost == C::ZERO { C::ZERO } else { cost }; // -0.0 becomes 0.0
            self.targets.push(to as u32);
            self.costs.push(cost);
            if cost > self.dearest {
                self.dearest = cost;
            }
        }
        Ok(())
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of links of finite cost.
    pub fn links(&self) -> usize {
        self.targets.len()
    }

    /// (next node, cost) of the links out of `node`.
    #[inline]
    pub fn links_from(&self, node: usize) -> impl Iterator<Item = (usize, C)> + use<'_, C> {
        let range = self.starts[node] as usize..self.starts[node + 1] as usize;
        let targets = self.targets[range.clone()].iter().map(|&target| target as usize);
        targets.zip(self.costs[range].iter().copied())
    }

    /// The same graph with every link turned round.
    pub fn reversed(&self) -> Self {
        let mut starts = vec![0_u32; self.nodes() + 1];
        for &target in &self.targets {
            starts[target as usize + 1] += 1;
        }
        for node in 0..self.nodes() {
            starts[node + 1] += starts[node];
        }
        let mut free = starts.clone();
        let mut targets = vec![0_u32; self.links()];
        let mut costs = vec![C::ZERO; self.links()];
        for node in 0..self.nodes() {
            for (target, cost) in self.links_from(node) {
                let at = free[target] as usize;
                free[target] += 1;
                (targets[at], costs[at]) = (node as u32, cost);
            }
        }
        Self { starts, targets, costs, dearest: self.dearest }
    }

    /// Where the links of each node begin, their targets, their costs.
    pub(super) fn arrays(&self) -> (&[u32], &[u32], &[C]) {
        (&self.starts, &self.targets, &self.costs)
    }

    /// The cost of the dearest link.
    pub(super) fn dearest(&self) -> C {
        self.dearest
    }

    /// Refuses a graph on which a walk of `links` links might cost more than the type holds.
    pub(super) fn check_walks_of(&self, links: usize) -> Result<(), PlanError> {
        if self.dearest.fits(links) {
            return Ok(());
        }
        Err(PlanError::GraphCostOverflow { links, dearest: self.dearest.to_f64(), precision: C::NAME })
    }

    /// The goals as node numbers, ascending, each once.
    pub(super) fn checked_goals(&self, goals: &[usize]) -> Result<Vec<u32>, PlanError> {
        if goals.is_empty() {
            return Err(PlanError::NoGoal);
        }
        let nodes = self.nodes();
        if let Some(&goal) = goals.iter().find(|&&goal| goal >= nodes) {
            return Err(PlanError::GoalNotANode { node: i64::try_from(goal).unwrap_or(i64::MAX), nodes });
        }
        let mut goals: Vec<u32> = goals.iter().map(|&goal| goal as u32).collect();
        goals.sort_unstable();
        goals.dedup();
        Ok(goals)
    }
}

/// The links of a free grid with the very costs that [`plan_free`](super::plan_free) adds up: node =
/// row-major index, links of a cell in the order of their codes.
///
/// # Errors
/// [`PlanError::GraphTooLarge`].
pub fn graph_of_free(free: &Grid<bool>, options: &PlanOptions) -> Result<Graph<u32>, PlanError> {
    let moves = Moves::new(&free.geometry, &free.values, options.corner_cutting);
    let (straight, diagonal) = options.steps.lengths();
    graph_of(&moves, |_, _, code| [straight, diagonal][code % 2])
}

/// The links of a cost grid with the very costs that [`plan_costs_f32`](super::plan_costs_f32) adds up.
///
/// # Errors
/// [`PlanError::GraphTooLarge`], and what is no cost as in `plan_costs_f32`.
pub fn graph_of_costs_f32(costs: &Grid<f32>, options: &PlanOptions) -> Result<Graph<f32>, PlanError> {
    graph_of_costs(costs, options)
}

/// [`graph_of_costs_f32`] in double precision.
///
/// # Errors
/// As `graph_of_costs_f32`.
pub fn graph_of_costs_f64(costs: &Grid<f64>, options: &PlanOptions) -> Result<Graph<f64>, PlanError> {
    graph_of_costs(costs, options)
}

fn graph_of_costs<C: CellNumber>(costs: &Grid<C>, options: &PlanOptions) -> Result<Graph<C>, PlanError> {
    let free = free_cells(costs)?;
    let moves = Moves::new(&costs.geometry, &free, options.corner_cutting);
    graph_of(&moves, |from, to, code| costs.values[from].link(costs.values[to], code % 2 == 1))
}

fn graph_of<C: Cost>(moves: &Moves, link: impl Fn(usize, usize, usize) -> C) -> Result<Graph<C>, PlanError> {
    let links = (0..moves.len()).map(|index| moves.count(index)).sum();
    let mut graph = Graph::empty(moves.len(), links)?;
    for index in 0..moves.len() {
        for (code, neighbour) in moves.from(index) {
            graph.push(graph.links(), index, neighbour, link(index, neighbour, code))?;
        }
        graph.starts.push(graph.targets.len() as u32);
    }
    Ok(graph)
}

impl<C: Cost> Graph<C> {
    /// The CSR arrays (indptr, indices, costs) of the links of finite cost.
    pub fn to_csr(&self) -> (Vec<i64>, Vec<i64>, Vec<C>) {
        let wide = |numbers: &[u32]| numbers.iter().map(|&number| i64::from(number)).collect();
        (wide(&self.starts), wide(&self.targets), self.costs.clone())
    }
}

impl Graph<u64> {
    /// [`from_csr`](Self::from_csr) from signed costs.
    ///
    /// # Errors
    /// As `from_csr`.
    pub fn from_signed_csr(indptr: &[i64], indices: &[i64], costs: &[i64]) -> Result<Self, PlanError> {
        Self::from_csr_of(indptr, indices, costs, |&cost| u64::try_from(cost).map_err(|_| cost as f64))
    }
}
