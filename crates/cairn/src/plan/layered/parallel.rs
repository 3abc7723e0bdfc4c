use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

use serde::Serialize;

use super::layers::Layers;
use super::schedule::{Board, Task, Wait, waits};
use super::{Engine, LayeredOptions};
use crate::plan::{Cost, GraphField};

/// What the threads did, and when.
#[derive(Clone, Debug, PartialEq, Default, Serialize)]
pub struct Trace {
    /// Every task that ran, in order of its end. A few may be of levels beyond the last.
    pub tasks: Vec<Timed>,
    /// What the tasks of each layer 1..=K wait for.
    pub waits: Vec<Vec<Wait>>,
}

/// When a task ran, by the caller's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Timed {
    /// The task.
    pub task: Task,
    /// Which thread ran it, from 0.
    pub thread: usize,
    /// Its beginning.
    pub begin: u64,
    /// Its end.
    pub end: u64,
}

/// A clock that several threads read, in units of the caller's choice.
pub type Clock<'a> = &'a (dyn Fn() -> u64 + Sync);

/// What the task graph came to.
pub struct Outcome<C> {
    pub field: GraphField<C>,
    pub levels: usize,
    pub settled: bool,
    pub walks: Option<Vec<Vec<C>>>,
    pub trace: Trace,
}

/// The levelled or the in-place engine as a task graph on threads; a task is a layer at a level.
pub fn run<C: Cost>(
    layers: &Layers<C>,
    goals: &[u32],
    options: &LayeredOptions,
    max_levels: usize,
    threads: usize,
    clock: Option<Clock<'_>>,
) -> Outcome<C> {
    let waits = waits(layers, options.engine);
    let slope = if options.engine == Engine::InPlace { layers.greatest_rise + 1 } else { 0 };
    let board = Board::new(waits.clone(), options.schedule, slope, max_levels, options.early_stop);
    let work = Work {
        engine: options.engine,
        threads,
        parts: (1..=layers.count()).map(|layer| Part::new(layers, layer, options)).collect(),
        finished: AtomicBool::new(board.finished),
        waiting: AtomicUsize::new(board.waiting()),
        board: Mutex::new(board),
        wake: Condvar::new(),
        clock,
    };
    let mut timed = std::thread::scope(|scope| {
        let work = &work;
        let others: Vec<_> = (1..threads).map(|number| scope.spawn(move || work.run(number))).collect();
        let mut timed = work.run(0);
        for other in others {
            timed.extend(other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
        timed
    });
    timed.sort_by_key(|timed| (timed.end, timed.task));
    let board = work.board.into_inner().unwrap_or_else(PoisonError::into_inner);
    let (field, walks) = gather(layers, goals, work.parts, board.levels as usize, options);
    Outcome {
        field,
        levels: board.levels as usize,
        settled: board.settled,
        walks,
        trace: Trace { tasks: timed, waits },
    }
}

/// One layer: the links out of it, by the layer they lead to, and what is known of its nodes.
struct Part<C> {
    nodes: usize,
    links: Vec<Links<C>>,
    /// C⁺ and p [Maalouf06 §3.2].
    chosen: RwLock<Chosen<C>>,
    /// n_i of the levels of even and of odd number; levelled engine only.
    walks: [RwLock<Vec<C>>; 2],
    /// n_i of every level, if asked for.
    record: Option<Mutex<Vec<Vec<C>>>>,
}

/// The real links behind the vector link to a layer (0: the goals), by node, both numbered within
/// their layers.
struct Links<C> {
    next_layer: usize,
    nodes: Vec<u32>,
    ends: Vec<u32>,
    links: Vec<(u32, C)>,
    /// The number of the next node in the graph, link by link.
    names: Vec<u32>,
}

#[derive(Default)]
struct Chosen<C> {
    costs: Vec<C>,
    next: Vec<Option<u32>>,
    /// What a layer that reads itself reads; pointers of the walk at hand.
    copy: Vec<C>,
    via: Vec<Option<u32>>,
}

impl<C: Cost> Part<C> {
    fn new(layers: &Layers<C>, layer: usize, options: &LayeredOptions) -> Self {
        let nodes = layers.sizes[layer - 1];
        let unreached = || vec![C::UNREACHABLE; nodes];
        let levelled = options.engine == Engine::Levelled;
        let walk = || RwLock::new(if levelled { unreached() } else { Vec::new() });
        let to_goals = (layer == 1).then_some(0);
        let next_layers = to_goals.into_iter().chain(layers.next_layers(layer).iter().copied());
        Self {
            nodes,
            links: next_layers.map(|next| Links::new(layers, layer, next)).collect(),
            chosen: RwLock::new(Chosen {
                costs: unreached(),
                next: vec![None; nodes],
                copy: Vec::new(),
                via: if levelled { vec![None; nodes] } else { Vec::new() },
            }),
            walks: [walk(), walk()],
            record: (levelled && options.record_walks).then(Mutex::default),
        }
    }
}

impl<C: Cost> Links<C> {
    fn new(layers: &Layers<C>, layer: usize, next_layer: usize) -> Self {
        let (mut nodes, mut ends, mut links, mut names) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for fan in layers.fans(layer, next_layer) {
            nodes.push(layers.place[fan.node as usize]);
            for &(next, cost) in &fan.links {
                links.push((layers.place[next as usize], cost));
                names.push(next);
            }
            ends.push(links.len() as u32);
        }
        Self { next_layer, nodes, ends, links, names }
    }

    /// (2) and (3) [Maalouf06 §3.1] for every node that has such links; true if any cost fell.
    fn choose(&self, ahead: &[C], costs: &mut [C], next: &mut [Option<u32>]) -> bool {
        let (mut changed, mut begin) = (false, 0);
        for (&node, &end) in self.nodes.iter().zip(&self.ends) {
            let links = begin as usize..end as usize;
            begin = end;
            let mut best = costs[node as usize];
            let mut pointer = None;
            for (&(there, cost), &name) in self.links[links.clone()].iter().zip(&self.names[links]) {
                // The goals are all of cost nothing.
                let there = if self.next_layer == 0 { C::ZERO } else { ahead[there as usize] };
                if there == C::UNREACHABLE {
                    continue;
                }
                let candidate = there.plus(cost).expect("every walk fits: checked before");
                if candidate < best {
                    (best, pointer) = (candidate, Some(name));
                }
            }
            if pointer.is_some() {
                (costs[node as usize], next[node as usize]) = (best, pointer);
                changed = true;
            }
        }
        changed
    }
}

struct Work<'a, C> {
    engine: Engine,
    threads: usize,
    parts: Vec<Part<C>>,
    board: Mutex<Board>,
    wake: Condvar,
    /// Copies of what the board says, to look at without taking it.
    finished: AtomicBool,
    waiting: AtomicUsize,
    clock: Option<Clock<'a>>,
}

/// Looks at the board that a thread takes before it goes to sleep: some microseconds' worth.
const LOOKS: usize = 4000;
/// Tasks that a thread takes off the board at once.
const MOST_AT_ONCE: usize = 16;

impl<C: Cost> Work<'_, C> {
    fn run(&self, thread: usize) -> Vec<Timed> {
        let now = || self.clock.map_or(0, |clock| clock());
        let (mut timed, mut done) = (Vec::new(), Vec::new());
        let mut board = self.board();
        while !board.finished {
            // Several small tasks at once, where there are many: the board is one for all threads.
            let share = (board.waiting() / (2 * self.threads)).clamp(1, MOST_AT_ONCE);
            let tasks: Vec<Task> = std::iter::from_fn(|| board.take()).take(share).collect();
            if tasks.is_empty() {
                board = self.wait(board);
                continue;
            }
            self.waiting.store(board.waiting(), Ordering::Relaxed);
            drop(board);
            for task in tasks {
                let begin = now();
                let changed = match self.engine {
                    Engine::InPlace => self.in_place(task),
                    _ => self.levelled(task),
                };
                if self.clock.is_some() {
                    timed.push(Timed { task, thread, begin, end: now() });
                }
                done.push((task, changed));
            }
            board = self.board();
            done.drain(..).for_each(|(task, changed)| board.complete(task, changed));
            self.waiting.store(board.waiting(), Ordering::Relaxed);
            self.finished.store(board.finished, Ordering::Relaxed);
            if board.finished || board.waiting() > 2 {
                self.wake.notify_all();
            } else if board.waiting() == 2 {
                self.wake.notify_one(); // one task is this thread's
            }
        }
        timed
    }

    fn wait<'b>(&'b self, board: MutexGuard<'b, Board>) -> MutexGuard<'b, Board> {
        drop(board);
        for _ in 0..LOOKS {
            if self.waiting.load(Ordering::Relaxed) > 0 || self.finished.load(Ordering::Relaxed) {
                return self.board();
            }
            std::hint::spin_loop();
        }
        let idle = |board: &mut Board| board.waiting() == 0 && !board.finished;
        self.wake.wait_while(self.board(), idle).unwrap_or_else(PoisonError::into_inner)
    }

    fn board(&self) -> MutexGuard<'_, Board> {
        self.board.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The operations of a layer at a level on C⁺ in place; DP(j, j) reads a copy of its layer.
    fn in_place(&self, Task { level, layer }: Task) -> bool {
        let part = &self.parts[layer as usize - 1];
        let mut chosen = write(&part.chosen);
        let Chosen { costs, next, copy, .. } = &mut *chosen;
        let mut changed = false;
        for links in part.links.iter().filter(|links| is_present(links.next_layer, level)) {
            changed |= match links.next_layer {
                0 => links.choose(&[], costs, next),
                own if own == layer as usize => {
                    copy.clone_from(costs);
                    links.choose(copy, costs, next)
                }
                other => links.choose(&read(&self.parts[other - 1].chosen).costs, costs, next),
            };
        }
        changed
    }

    /// n_i of a layer from level i − 1, and C⁺ as the least of a node's duplicates so far (5).
    fn levelled(&self, Task { level, layer }: Task) -> bool {
        let part = &self.parts[layer as usize - 1];
        let mut walk = write(&part.walks[level as usize % 2]);
        let mut chosen = write(&part.chosen);
        let Chosen { costs, next, via, .. } = &mut *chosen;
        walk.fill(C::UNREACHABLE);
        for links in part.links.iter().filter(|links| is_present(links.next_layer, level)) {
            if links.next_layer == 0 {
                links.choose(&[], &mut walk, via);
            } else {
                let above = read(&self.parts[links.next_layer - 1].walks[(level as usize + 1) % 2]);
                links.choose(&above, &mut walk, via);
            }
        }
        let mut changed = false;
        for node in 0..part.nodes {
            if walk[node] < costs[node] {
                (costs[node], next[node]) = (walk[node], via[node]);
                changed = true;
            }
        }
        if let Some(record) = &part.record {
            record.lock().unwrap_or_else(PoisonError::into_inner).push(walk.clone());
        }
        changed
    }
}

/// Whether the level above holds the layer; the goals are above level 1 alone.
fn is_present(next_layer: usize, level: u32) -> bool {
    if next_layer == 0 { level == 1 } else { next_layer < level as usize }
}

fn read<T>(lock: &RwLock<T>) -> RwLockReadGuard<'_, T> {
    lock.read().unwrap_or_else(PoisonError::into_inner)
}

fn write<T>(lock: &RwLock<T>) -> RwLockWriteGuard<'_, T> {
    lock.write().unwrap_or_else(PoisonError::into_inner)
}

type Gathered<C> = (GraphField<C>, Option<Vec<Vec<C>>>);

/// The layers' costs and pointers as those of the nodes, and n_i likewise if it was recorded.
fn gather<C: Cost>(
    layers: &Layers<C>,
    goals: &[u32],
    parts: Vec<Part<C>>,
    levels: usize,
    options: &LayeredOptions,
) -> Gathered<C> {
    let nodes = layers.of_node.len();
    let mut field = GraphField { cost_to_go: vec![C::UNREACHABLE; nodes], next: vec![None; nodes] };
    goals.iter().for_each(|&goal| field.cost_to_go[goal as usize] = C::ZERO);
    let recorded = options.record_walks && options.engine == Engine::Levelled;
    let mut walks = recorded.then(|| vec![vec![C::UNREACHABLE; nodes]; levels]);
    let found: Vec<_> = parts.into_iter().map(|part| (part.chosen, part.record)).collect();
    let found: Vec<(Chosen<C>, Vec<Vec<C>>)> = found
        .into_iter()
        .map(|(chosen, record)| {
            let chosen = chosen.into_inner().unwrap_or_else(PoisonError::into_inner);
            let record = record.map(|record| record.into_inner().unwrap_or_else(PoisonError::into_inner));
            (chosen, record.unwrap_or_default())
        })
        .collect();
    for (node, layer) in layers.of_node.iter().enumerate() {
        let Some(layer) = layer.filter(|&layer| layer > 0) else { continue };
        let (chosen, record) = &found[layer as usize - 1];
        let place = layers.place[node] as usize;
        (field.cost_to_go[node], field.next[node]) = (chosen.costs[place], chosen.next[place]);
        // The first level of a layer has its number.
        for (walk, level) in record.iter().zip(layer as usize..=levels) {
            if let Some(walks) = &mut walks {
                walks[level - 1][node] = walk[place];
            }
        }
    }
    (field, walks)
}
