use std::collections::{BTreeMap, VecDeque};

use crate::plan::{Cost, Graph};

/// The nodes of a graph by layer, and the links between layers as vector links [Maalouf06 §3.2, Fig. 2].
///
/// The layer of a node is the least number of links from it to a goal. All goals form layer 0; their
/// own links are unused. Nodes that cannot reach a goal have no layer.
pub struct Layers<C> {
    /// Layer of every node.
    pub of_node: Vec<Option<u32>>,
    /// Number of every node within its layer, in the order of the nodes.
    pub place: Vec<u32>,
    /// Number of nodes in layers 1..=K.
    pub sizes: Vec<usize>,
    /// The real links behind each vector link (layer, next layer).
    vector_links: BTreeMap<(usize, usize), Vec<Fan<C>>>,
    /// For each layer 1..=K the next layers its vector links lead to, ascending, the goal layer excepted.
    next_layers: Vec<Vec<usize>>,
    /// The greatest rise of any link, at least 1.
    pub greatest_rise: usize,
}

/// The links of one node into one layer.
pub struct Fan<C> {
    pub node: u32,
    pub links: Vec<(u32, C)>,
}

impl<C: Cost> Layers<C> {
    /// Breadth-first search from the goals over reversed links.
    pub fn new(graph: &Graph<C>, goals: &[u32]) -> Self {
        let reversed = graph.reversed();
        let mut of_node: Vec<Option<u32>> = vec![None; graph.nodes()];
        let mut sizes = Vec::new();
        let mut queue = VecDeque::new();
        for &goal in goals {
            of_node[goal as usize] = Some(0);
            queue.push_back((goal as usize, 0_u32));
        }
        while let Some((node, layer)) = queue.pop_front() {
            for (before, _) in reversed.links_from(node) {
                if of_node[before].is_none() {
                    of_node[before] = Some(layer + 1);
                    if sizes.len() == layer as usize {
                        sizes.push(0);
                    }
                    sizes[layer as usize] += 1;
                    queue.push_back((before, layer + 1));
                }
            }
        }
        let vector_links = vector_links(graph, &of_node);
        let greatest_rise =
            vector_links.keys().map(|&(from, to)| to.saturating_sub(from)).max().unwrap_or(1).max(1);
        let next_layers = next_layers(sizes.len(), vector_links.keys().copied());
        Self {
            place: places(&of_node, sizes.len()),
            of_node,
            sizes,
            vector_links,
            next_layers,
            greatest_rise,
        }
    }

    /// Number of layers, K.
    pub fn count(&self) -> usize {
        self.sizes.len()
    }

    /// Size of the largest layer, M.
    pub fn widest(&self) -> usize {
        self.sizes.iter().copied().max().unwrap_or(0)
    }

    /// The next layers of the vector links out of `layer` >= 1: the one below, its own, the one above,
    /// whether or not a real link is behind them, and those further up that real links rise to.
    pub fn next_layers(&self, layer: usize) -> &[usize] {
        &self.next_layers[layer - 1]
    }

    /// The real links behind DP(layer, next): one fan per node of `layer` that has any.
    pub fn fans(&self, layer: usize, next: usize) -> &[Fan<C>] {
        self.vector_links.get(&(layer, next)).map_or(&[], Vec::as_slice)
    }
}

fn places(of_node: &[Option<u32>], count: usize) -> Vec<u32> {
    let mut free = vec![0; count + 1];
    let place = |layer: &Option<u32>| {
        layer.map_or(0, |layer| {
            free[layer as usize] += 1;
            free[layer as usize] - 1
        })
    };
    of_node.iter().map(place).collect()
}

fn vector_links<C: Cost>(graph: &Graph<C>, of_node: &[Option<u32>]) -> BTreeMap<(usize, usize), Vec<Fan<C>>> {
    let mut vector_links: BTreeMap<(usize, usize), Vec<Fan<C>>> = BTreeMap::new();
    for (node, &layer) in of_node.iter().enumerate() {
        let Some(layer) = layer.filter(|&layer| layer > 0) else { continue };
        let mut by_layer: BTreeMap<usize, Vec<(u32, C)>> = BTreeMap::new();
        for (next, cost) in graph.links_from(node) {
            if let Some(next_layer) = of_node[next] {
                by_layer.entry(next_layer as usize).or_default().push((next as u32, cost));
            }
        }
        for (next_layer, links) in by_layer {
            let fan = Fan { node: node as u32, links };
            vector_links.entry((layer as usize, next_layer)).or_default().push(fan);
        }
    }
    vector_links
}

fn next_layers(count: usize, real: impl Iterator<Item = (usize, usize)>) -> Vec<Vec<usize>> {
    let drawn = |layer: usize| (layer - 1).max(1)..=(layer + 1).min(count);
    let mut next_layers: Vec<Vec<usize>> = (1..=count).map(|layer| drawn(layer).collect()).collect();
    for (layer, next) in real {
        if next > layer + 1 {
            next_layers[layer - 1].push(next); // keys ascend, so these do too
        }
    }
    next_layers
}
