use super::layers::Layers;
use super::{Engine, LayeredOptions, Operation};
use crate::plan::{Cost, GraphField};

/// What the engines work on: C⁺ and p of every node [Maalouf06 §3.2], and a record of the work.
pub struct State<'a, C> {
    layers: &'a Layers<C>,
    pub field: GraphField<C>,
    pub levels: usize,
    pub operations: u64,
    pub sequence: Option<Vec<Operation>>,
    pub walks: Option<Vec<Vec<C>>>,
    /// The copy of its own layer that DP(j, j) reads.
    copy: Vec<C>,
}

impl<'a, C: Cost> State<'a, C> {
    pub fn new(layers: &'a Layers<C>, goals: &[u32], options: &LayeredOptions) -> Self {
        let nodes = layers.of_node.len();
        let mut field = GraphField { cost_to_go: vec![C::UNREACHABLE; nodes], next: vec![None; nodes] };
        for &goal in goals {
            field.cost_to_go[goal as usize] = C::ZERO;
        }
        Self {
            layers,
            copy: field.cost_to_go.clone(),
            field,
            levels: 0,
            operations: 0,
            sequence: options.record_sequence.then(Vec::new),
            walks: (options.record_walks && options.engine == Engine::Levelled).then(Vec::new),
        }
    }

    /// DP(1, G), DP(2, 1), .. DP(K, K − 1) [Maalouf06 §3.1].
    pub fn classical(&mut self) -> bool {
        self.levels = 1;
        for layer in 1..=self.layers.count() {
            self.dp(layer, layer - 1);
        }
        true
    }

    /// Falling, within, rising; again until nothing changes. True if nothing more can change.
    pub fn phased(&mut self, max_levels: usize, early_stop: bool) -> bool {
        let count = self.layers.count();
        while self.levels < max_levels {
            self.levels += 1;
            let mut changed = false;
            for layer in 1..=count {
                changed |= self.dp(layer, layer - 1);
            }
            for layer in 1..=count {
                changed |= self.dp(layer, layer);
            }
            for layer in (1..=count).rev() {
                for &next in self.layers.next_layers(layer).iter().filter(|&&next| next > layer) {
                    changed |= self.dp(layer, next);
                }
            }
            if early_stop && !changed {
                return true;
            }
        }
        false
    }

    /// The operations of the layered solution graph in its order, each on the newest costs.
    pub fn in_place(&mut self, max_levels: usize, early_stop: bool) -> bool {
        let layers = self.layers;
        while self.levels < max_levels {
            self.levels += 1;
            let mut changed = false;
            for (layer, next) in operations_at(layers, self.levels) {
                changed |= self.dp(layer, next);
            }
            if early_stop && !changed && self.levels > layers.count() {
                return true;
            }
        }
        false
    }

    /// The layered solution graph itself: `n_i` of level i is read from level i − 1 alone, and C⁺ is
    /// the least of a node's duplicates so far (5).
    pub fn levelled(&mut self, max_levels: usize, early_stop: bool) -> bool {
        let layers = self.layers;
        let nodes = layers.of_node.len();
        let mut above = self.field.cost_to_go.clone(); // level 0: the goal alone
        let mut walk = GraphField { cost_to_go: vec![C::UNREACHABLE; nodes], next: vec![None; nodes] };
        while self.levels < max_levels {
            self.levels += 1;
            walk.cost_to_go.fill(C::UNREACHABLE);
            for (layer, next) in operations_at(layers, self.levels) {
                self.record(layer, next);
                choose(layers, layer, next, &above, &mut walk);
            }
            let mut changed = false;
            for node in 0..nodes {
                if walk.cost_to_go[node] < self.field.cost_to_go[node] {
                    self.field.cost_to_go[node] = walk.cost_to_go[node];
                    self.field.next[node] = walk.next[node];
                    changed = true;
                }
            }
            if let Some(walks) = &mut self.walks {
                walks.push(walk.cost_to_go.clone());
            }
            std::mem::swap(&mut above, &mut walk.cost_to_go);
            if early_stop && !changed && self.levels > layers.count() {
                return true;
            }
        }
        false
    }

    /// DP(layer, next) on C⁺ in place; DP(j, j) reads a copy of its layer. True if any C⁺ fell.
    fn dp(&mut self, layer: usize, next: usize) -> bool {
        self.record(layer, next);
        if layer != next {
            return choose_in_place(self.layers, layer, next, &mut self.field);
        }
        for fan in self.layers.fans(layer, layer) {
            self.copy[fan.node as usize] = self.field.cost_to_go[fan.node as usize];
            for &(target, _) in &fan.links {
                self.copy[target as usize] = self.field.cost_to_go[target as usize];
            }
        }
        choose(self.layers, layer, layer, &self.copy, &mut self.field)
    }

    fn record(&mut self, layer: usize, next: usize) {
        self.operations += 1;
        if let Some(sequence) = &mut self.sequence {
            let (level, layer, next_layer) = (self.levels as u32, layer as u32, next as u32);
            sequence.push(Operation { level, layer, next_layer });
        }
    }
}

/// (2) and (3) for every node of `layer` with its next node in `next`: a choice is replaced only by
/// a strictly better one, so pointers never cycle.
fn choose<C: Cost>(
    layers: &Layers<C>,
    layer: usize,
    next: usize,
    ahead: &[C],
    chosen: &mut GraphField<C>,
) -> bool {
    let mut changed = false;
    for fan in layers.fans(layer, next) {
        for &(target, cost) in &fan.links {
            changed |= improve(chosen, fan.node, target, ahead[target as usize], cost);
        }
    }
    changed
}

/// As [`choose`], reading what it writes; `layer` and `next` differ, so it reads no node it writes.
fn choose_in_place<C: Cost>(
    layers: &Layers<C>,
    layer: usize,
    next: usize,
    chosen: &mut GraphField<C>,
) -> bool {
    let mut changed = false;
    for fan in layers.fans(layer, next) {
        for &(target, cost) in &fan.links {
            changed |= improve(chosen, fan.node, target, chosen.cost_to_go[target as usize], cost);
        }
    }
    changed
}

#[inline]
fn improve<C: Cost>(chosen: &mut GraphField<C>, node: u32, target: u32, ahead: C, cost: C) -> bool {
    if ahead == C::UNREACHABLE {
        return false;
    }
    let candidate = ahead.plus(cost).expect("every walk fits: checked before");
    let better = candidate < chosen.cost_to_go[node as usize];
    if better {
        chosen.cost_to_go[node as usize] = candidate;
        chosen.next[node as usize] = Some(target);
    }
    better
}

/// The operations of one level of the layered solution graph, in the paper's order: DP(1, G) alone at
/// level 1; below it layers 1..=min(level, K) ascending, each with the layers it has vector links to
/// that level − 1 holds, ascending.
fn operations_at<C: Cost>(
    layers: &Layers<C>,
    level: usize,
) -> impl Iterator<Item = (usize, usize)> + use<'_, C> {
    let at_top = (level == 1 && layers.count() > 0).then_some((1, 0));
    let present = level.min(layers.count());
    let present_above = (level - 1).min(layers.count());
    at_top.into_iter().chain((1..=present).flat_map(move |layer| {
        let next_layers = layers.next_layers(layer).iter().copied();
        next_layers.filter(move |&next| next <= present_above).map(move |next| (layer, next))
    }))
}

/// The operations of so many levels, in their order.
pub fn sequence_of<C: Cost>(layers: &Layers<C>, levels: usize) -> Vec<Operation> {
    let at = |level: usize| {
        let named = move |(layer, next)| Operation {
            level: level as u32,
            layer: layer as u32,
            next_layer: next as u32,
        };
        operations_at(layers, level).map(named)
    };
    (1..=levels).flat_map(at).collect()
}

/// The number of operations of so many levels, counted on the graph as described.
pub fn operations_of<C: Cost>(layers: &Layers<C>, engine: Engine, levels: usize) -> u64 {
    let count = layers.count();
    let vector_links = |layer: usize| layers.next_layers(layer).len() as u64;
    match engine {
        Engine::Classical => count as u64,
        // Every vector link, and the one from layer 1 to the goal, at each repetition.
        Engine::Phased => {
            let all: u64 = (1..=count).map(vector_links).sum();
            levels as u64 * (all + u64::from(count > 0))
        }
        Engine::Levelled | Engine::InPlace => {
            let building: u64 =
                (1..=levels.min(count)).map(|level| operations_at(layers, level).count() as u64).sum();
            let all: u64 = (1..=count).map(vector_links).sum();
            // The level after the last new layer is the first that every vector link is at.
            building + levels.saturating_sub(count) as u64 * all
        }
    }
}
