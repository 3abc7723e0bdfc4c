use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::ground::Ground;
use super::links::{LinkCosts, Number};

/// The order in which Dijkstra's algorithm \[Dijkstra59\] takes the cells.
pub trait Queue<C: Number> {
    /// Lowers `values` (padded; zero at `starts`, `UNREACHABLE` elsewhere) to the field.
    ///
    /// False if a cost-to-go did not fit.
    fn settle<L: LinkCosts<C>>(
        &mut self,
        ground: &Ground,
        links: &L,
        starts: &[u32],
        values: &mut [C],
    ) -> bool;
}

/// Dial's buckets in a circle \[Dial69\].
///
/// A bucket may be as wide as the cheapest link and its cells still leave with their final values
/// \[Denardo79\]: no link leads from a bucket into the same one. (In floats rounding may lead into the
/// same bucket; it is then gone through again.)
#[derive(Default)]
pub struct Buckets {
    unit_wide: bool,
    circle: Vec<Vec<u32>>,
    batch: Vec<u32>,
}

impl Buckets {
    /// One bucket for every whole cost, as \[Dial69\] has it. Whole numbers only.
    pub fn unit_wide() -> Self {
        Self { unit_wide: true, ..Self::default() }
    }

    /// Buckets as wide as the largest power of two that is no larger than the cheapest link.
    pub fn wide() -> Self {
        Self::default()
    }
}

impl<C: Number> Queue<C> for Buckets {
    fn settle<L: LinkCosts<C>>(
        &mut self,
        ground: &Ground,
        links: &L,
        starts: &[u32],
        values: &mut [C],
    ) -> bool {
        let (cheapest, dearest) = links.range();
        let scale = if self.unit_wide { C::ZERO } else { C::scale(cheapest) };
        let count = (dearest.bucket(scale) + 2).next_power_of_two();
        let last = C::limit(dearest).bucket(scale);
        self.circle.iter_mut().for_each(Vec::clear);
        self.circle.resize_with(count, Vec::new);
        self.circle[0].extend_from_slice(starts);
        let (circle, mask) = (&mut self.circle[..], count - 1);
        let (mut now, mut empty) = (0_usize, 0_usize);
        while empty < count {
            let slot = now & mask;
            if circle[slot].is_empty() {
                empty += 1;
                now += 1;
                continue;
            }
            if now >= last {
                return false;
            }
            empty = 0;
            std::mem::swap(&mut self.batch, &mut circle[slot]);
            for &cell in &self.batch {
                let cell = cell as usize;
                let value = values[cell];
                if value.bucket(scale) != now {
                    continue; // a nearer way was found meanwhile
                }
                relax(ground, links, values, cell, value, |candidate, neighbour| {
                    circle[candidate.bucket(scale) & mask].push(neighbour);
                });
            }
            self.batch.clear();
        }
        true
    }
}

/// A binary heap; what it holds of cells that were lowered since is skipped when it comes up.
pub struct Heap<C: Number> {
    open: BinaryHeap<Reverse<C::Entry>>,
}

impl<C: Number> Default for Heap<C> {
    fn default() -> Self {
        Self { open: BinaryHeap::new() }
    }
}

impl<C: Number> Queue<C> for Heap<C> {
    fn settle<L: LinkCosts<C>>(
        &mut self,
        ground: &Ground,
        links: &L,
        starts: &[u32],
        values: &mut [C],
    ) -> bool {
        let limit = C::limit(links.range().1);
        self.open.clear();
        self.open.extend(starts.iter().map(|&start| Reverse(C::ZERO.entry(start))));
        while let Some(Reverse(entry)) = self.open.pop() {
            let (cell, value) = (C::cell(entry) as usize, C::value(entry));
            if values[cell] < value {
                continue;
            }
            if value >= limit {
                return false;
            }
            relax(ground, links, values, cell, value, |candidate, neighbour| {
                self.open.push(Reverse(candidate.entry(neighbour)));
            });
        }
        true
    }
}

/// Lowers the neighbours of a free cell of the grid that are nearer through it, and tells of each.
#[inline(always)]
#[allow(unsafe_code)]
fn relax<C: Number, L: LinkCosts<C>>(
    ground: &Ground,
    links: &L,
    values: &mut [C],
    cell: usize,
    value: C,
    mut lowered: impl FnMut(C, u32),
) {
    let open = ground.entered(cell);
    assert!(values.len() == ground.len());
    for code in 0..8 {
        let neighbour = ground.beside(cell, code);
        let through = value.add(links.cost(neighbour, cell, code ^ 4));
        let candidate = if open >> code & 1 == 1 { through } else { C::UNREACHABLE };
        debug_assert!(open == 0 || neighbour < values.len());
        // SAFETY: every cell that is queued is free and inside the ring, so its eight neighbours are cells
        // of the padded array. The checks would cost a plain queue up to 15 % of its time.
        let held = unsafe { values.get_unchecked_mut(neighbour) };
        if candidate < *held {
            *held = candidate;
            lowered(candidate, neighbour as u32);
        }
    }
}
