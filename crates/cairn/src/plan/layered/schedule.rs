use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use serde::{Deserialize, Serialize};

use super::Engine;
use super::layers::Layers;
use crate::plan::Cost;

/// In what order several threads take the operations of the layered solution graph [Maalouf06 §3.3].
/// Neither changes a bit of the result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Schedule {
    /// (a) One front after the other, all of its layers at once. A front of the levelled engine is a
    /// level. In place that would be a race: there a front is all of level i, layer j with equal
    /// (r + 1)·i + j, r the greatest rise.
    Fronts,
    /// (b) Every layer of every level as soon as what it reads is final, and what it overwrites was
    /// read: a wave across levels.
    Wavefront,
}

/// All operations of one layer at one level, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Task {
    /// Level, from 1.
    pub level: u32,
    /// Layer whose nodes choose, from 1.
    pub layer: u32,
}

/// What the task of a layer waits for: the same layer's, or another's, of `lag` levels before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Wait {
    /// The layer waited for.
    pub layer: u32,
    /// 0: at the same level; 1: at the level before.
    pub lag: u32,
}

/// What the tasks of each layer 1..=K wait for.
///
/// Levelled: level i reads level i − 1 alone, and writes over what level i − 1 read. In place, the
/// order is that of the serial engine: a layer below was done at this level, one above at the last.
pub fn waits<C: Cost>(layers: &Layers<C>, engine: Engine) -> Vec<Vec<Wait>> {
    let mut waits: Vec<Vec<Wait>> = vec![Vec::new(); layers.count()];
    let mut both = |layer: usize, other: usize| {
        let lag = u32::from(engine != Engine::InPlace || other >= layer);
        waits[layer - 1].push(Wait { layer: other as u32, lag });
    };
    for layer in 1..=layers.count() {
        both(layer, layer);
        for &next in layers.next_layers(layer) {
            both(layer, next); // reads it
            both(next, layer); // overwrites what it read
        }
    }
    for waits in &mut waits {
        waits.sort_unstable();
        waits.dedup();
    }
    waits
}

/// The tasks that may run now, and what is done.
pub struct Board {
    waits: Vec<Vec<Wait>>,
    /// For each layer those that wait for it.
    wakes: Vec<Vec<u32>>,
    schedule: Schedule,
    /// Levels between neighbours of a front; 0 where a front is a level.
    slope: u64,
    max_levels: u32,
    early_stop: bool,
    ready: BinaryHeap<Reverse<Task>>,
    /// Last level done of every layer, and whether the next one is ready or running.
    done: Vec<u32>,
    taken: Vec<bool>,
    running: usize,
    front: u64,
    /// (tasks left, whether any changed a cost) of each level from `levels` + 1 on.
    open: VecDeque<(usize, bool)>,
    /// Levels complete.
    pub levels: u32,
    /// Whether a level beyond K changed nothing.
    pub settled: bool,
    pub finished: bool,
}

impl Board {
    pub fn new(
        waits: Vec<Vec<Wait>>,
        schedule: Schedule,
        slope: usize,
        max_levels: usize,
        early_stop: bool,
    ) -> Self {
        let count = waits.len();
        let mut wakes = vec![Vec::new(); count];
        for (layer, waits) in waits.iter().enumerate() {
            for wait in waits {
                wakes[wait.layer as usize - 1].push(layer as u32 + 1);
            }
        }
        let max_levels = u32::try_from(max_levels).unwrap_or(u32::MAX);
        let mut board = Self {
            waits,
            wakes,
            schedule,
            slope: slope as u64,
            max_levels,
            early_stop,
            ready: BinaryHeap::new(),
            done: (0..count as u32).collect(),
            taken: vec![false; count],
            running: 0,
            front: 0,
            open: VecDeque::new(),
            levels: 0,
            settled: false,
            finished: count == 0 || max_levels == 0,
        };
        if !board.finished {
            match schedule {
                Schedule::Fronts => board.next_front(),
                Schedule::Wavefront => board.offer(1),
            }
        }
        if count == 0 {
            // Levels without a layer: the first changes nothing.
            board.levels = if early_stop { max_levels.min(1) } else { max_levels };
            board.settled = early_stop && max_levels > 0;
        }
        board
    }

    /// A task that may run, the earliest by (level, layer).
    pub fn take(&mut self) -> Option<Task> {
        let Reverse(task) = self.ready.pop()?;
        self.running += 1;
        Some(task)
    }

    pub fn waiting(&self) -> usize {
        self.ready.len()
    }

    /// Notes that a task is done, and offers what may run after it.
    pub fn complete(&mut self, task: Task, changed: bool) {
        self.running -= 1;
        if self.finished {
            return; // of a level that nobody needs any more
        }
        let layer = task.layer as usize;
        (self.done[layer - 1], self.taken[layer - 1]) = (task.level, false);
        let ahead = (task.level - self.levels - 1) as usize;
        while self.open.len() <= ahead {
            let level = self.levels as usize + 1 + self.open.len();
            self.open.push_back((level.min(self.waits.len()), false));
        }
        self.open[ahead].0 -= 1;
        self.open[ahead].1 |= changed;
        while let Some(&(0, changed)) = self.open.front() {
            self.open.pop_front();
            self.levels += 1;
            self.settled = self.early_stop && !changed && self.levels as usize > self.waits.len();
            if self.settled || self.levels == self.max_levels {
                self.finished = true;
                self.ready.clear();
                return;
            }
        }
        match self.schedule {
            Schedule::Wavefront => {
                for at in 0..self.wakes[layer - 1].len() {
                    self.offer(self.wakes[layer - 1][at] as usize);
                }
            }
            Schedule::Fronts if self.running == 0 && self.ready.is_empty() => self.next_front(),
            Schedule::Fronts => {}
        }
    }

    /// Offers the next task of a layer if all it waits for is done.
    fn offer(&mut self, layer: usize) {
        let level = self.done[layer - 1] + 1;
        let free = |wait: &Wait| self.done[wait.layer as usize - 1] + wait.lag >= level;
        if level <= self.max_levels && !self.taken[layer - 1] && self.waits[layer - 1].iter().all(free) {
            self.taken[layer - 1] = true;
            self.ready.push(Reverse(Task { level, layer: layer as u32 }));
        }
    }

    /// Offers every task of the next front that has any.
    fn next_front(&mut self) {
        let count = self.waits.len() as u64;
        while self.ready.is_empty() {
            self.front += 1;
            let front = self.front;
            if self.slope == 0 {
                self.ready.extend(
                    (1..=front.min(count))
                        .map(|layer| Reverse(Task { level: front as u32, layer: layer as u32 })),
                );
                continue;
            }
            // slope·i + j = front with 1 <= j <= min(i, K)
            let lowest = front.saturating_sub(count).div_ceil(self.slope).max(1);
            let highest = ((front - 1) / self.slope).min(u64::from(self.max_levels));
            for level in lowest..=highest {
                let layer = front - self.slope * level;
                if layer <= level.min(count) {
                    self.ready.push(Reverse(Task { level: level as u32, layer: layer as u32 }));
                }
            }
        }
    }
}
