//! Which tile is visited next, and by whom.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::board::News;
use super::lanes::TileCost;

/// Tiles that wait for a visit; the one that was offered the least number is first.
///
/// No order is needed for the result to be exact: numbers only fall, until none can. This one makes
/// most tiles need few visits.
#[derive(Debug)]
pub struct Queue<T: TileCost> {
    heap: BinaryHeap<Reverse<(T::Key, u32)>>,
    waiting: Vec<(Option<T::Key>, News)>,
    /// Whether a tile was ever visited.
    pub visited: Vec<bool>,
    /// Tiles being visited, with their keys.
    in_flight: Vec<(u32, T::Key)>,
    deferred: Vec<(T::Key, u32)>,
    tile_cols: usize,
    /// Visits so far.
    pub visits: usize,
}

/// What there is to do.
pub enum Next {
    /// Visit this tile.
    Visit {
        /// The tile.
        tile: usize,
        /// What it has not looked at.
        news: News,
        /// Whether it is its first visit.
        first: bool,
    },
    /// Nothing until a visit under way has ended.
    Wait,
    /// Nothing any more.
    Done,
}

/// Tiles looked at for one that may be visited while others are.
const MOST_DEFERRED: usize = 32;

impl<T: TileCost> Default for Queue<T> {
    fn default() -> Self {
        Self {
            heap: BinaryHeap::new(),
            waiting: Vec::new(),
            visited: Vec::new(),
            in_flight: Vec::new(),
            deferred: Vec::new(),
            tile_cols: 1,
            visits: 0,
        }
    }
}

impl<T: TileCost> Queue<T> {
    /// Forgets everything.
    pub fn reset(&mut self, tile_rows: usize, tile_cols: usize) {
        let tiles = tile_rows * tile_cols;
        self.heap.clear();
        self.waiting.clear();
        self.waiting.resize(tiles, (None, 0));
        self.visited.clear();
        self.visited.resize(tiles, false);
        self.in_flight.clear();
        self.tile_cols = tile_cols;
        self.visits = 0;
    }

    /// A tile was offered something.
    pub fn add(&mut self, tile: usize, news: News, offered: T) {
        let (key, waiting) = &mut self.waiting[tile];
        *waiting |= news;
        if key.is_none_or(|key| offered.key() < key) {
            *key = Some(offered.key());
            self.heap.push(Reverse((offered.key(), tile as u32)));
        }
    }

    /// Whether a tile is being visited.
    pub fn is_in_flight(&self, tile: usize) -> bool {
        self.in_flight.iter().any(|&(other, _)| other as usize == tile)
    }

    /// The next visit, apart from the tiles being visited and their neighbours. Nothing that was offered
    /// more than `bound` is done once no visit under way could still lower that.
    pub fn take(&mut self, bound: Option<T::Key>) -> Next {
        let bound = bound.filter(|bound| self.in_flight.iter().all(|(_, key)| key > bound));
        let taken = loop {
            let Some(Reverse((key, tile))) = self.heap.pop() else { break None };
            if self.waiting[tile as usize].0 != Some(key) {
                continue; // a lesser offer was taken up
            }
            if bound.is_some_and(|bound| key > bound) {
                self.deferred.push((key, tile));
                break None;
            }
            if self.is_beside_one_in_flight(tile) {
                self.deferred.push((key, tile));
                if self.deferred.len() == MOST_DEFERRED {
                    break None;
                }
                continue;
            }
            break Some((key, tile));
        };
        self.heap.extend(self.deferred.drain(..).map(Reverse));
        let Some((key, tile)) = taken else {
            return if self.in_flight.is_empty() { Next::Done } else { Next::Wait };
        };
        let (waiting, news) = &mut self.waiting[tile as usize];
        *waiting = None;
        let news = std::mem::take(news);
        self.in_flight.push((tile, key));
        self.visits += 1;
        let tile = tile as usize;
        Next::Visit { tile, news, first: !std::mem::replace(&mut self.visited[tile], true) }
    }

    /// The tile that will probably be visited next.
    pub fn soon(&self) -> Option<usize> {
        self.heap.peek().map(|&Reverse((_, tile))| tile as usize)
    }

    /// A visit ended.
    pub fn ended(&mut self, tile: usize) {
        self.in_flight.retain(|&(other, _)| other as usize != tile);
    }

    fn is_beside_one_in_flight(&self, tile: u32) -> bool {
        let place = |tile: u32| (tile as usize / self.tile_cols, tile as usize % self.tile_cols);
        let (row, col) = place(tile);
        self.in_flight.iter().any(|&(other, _)| {
            let (other_row, other_col) = place(other);
            row.abs_diff(other_row) <= 1 && col.abs_diff(other_col) <= 1
        })
    }
}
