//! A cost map kept right, cell by cell, while the map that it prices changes.

use std::ops::Range;

use super::costmap::Pricing;
use super::marks::{CellSet, Marks};
use super::{
    Cell, CostLayer, CostmapConfig, Grid, GridGeometry, Occupancy, OccupancyGrid, UnknownCells, WorldError,
    costmap_with_layers,
};
use crate::robot::Footprint;

/// Costs, what they were made of, and how: equal at all times to [`costmap_with_layers`] of the same map.
#[derive(Clone, Debug)]
pub struct KeptCosts {
    footprint: Footprint,
    config: CostmapConfig,
    ground: Option<Vec<f32>>,
    seen: OccupancyGrid,
    /// Occupied cells of `seen`.
    occupied: Marks,
    costs: Grid<f32>,
}

/// Cells whose cost changed, and what they cost now.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CostChanges {
    /// The cells, by row, then column.
    pub cells: Vec<Cell>,
    /// One cost per metre for each; infinite where blocked.
    pub costs: Vec<f32>,
}

impl KeptCosts {
    /// Prices `seen`; `ground` as [`costmap_with_layers`] takes it.
    ///
    /// # Errors
    /// [`WorldError`] when the configuration or the ground is not usable.
    pub fn new(
        seen: OccupancyGrid,
        footprint: Footprint,
        config: CostmapConfig,
        ground: Option<Vec<f32>>,
    ) -> Result<Self, WorldError> {
        let costs = costmap_with_layers(&seen, &footprint, &config, ground.as_deref(), &[])?;
        let GridGeometry { rows, cols, .. } = seen.geometry;
        let occupied = Marks::of(rows, cols, &seen.values, |&seen| seen == Occupancy::Occupied);
        Ok(Self { footprint, config, ground, seen, occupied, costs })
    }

    /// Cost per metre of every cell.
    pub fn costs(&self) -> &Grid<f32> {
        &self.costs
    }

    /// What is priced.
    pub fn seen(&self) -> &OccupancyGrid {
        &self.seen
    }

    /// The occupied cells of what is priced.
    pub fn occupied(&self) -> CellSet {
        CellSet::new(self.seen.geometry, self.occupied.clone())
    }

    /// Shape and place.
    pub fn geometry(&self) -> GridGeometry {
        self.seen.geometry
    }

    /// Takes over what cells are now and prices anew what that touches. Cells outside are left out.
    pub fn update(&mut self, now: impl IntoIterator<Item = (Cell, Occupancy)>) -> CostChanges {
        let geometry = self.seen.geometry;
        let pricing = Pricing { config: &self.config, footprint: &self.footprint, layers: &[], flat: true };
        let reach = pricing.reach_cells(geometry.resolution_m);
        let mut touched = Touched { boxes: Vec::new(), reach };
        let is_priced = matches!(self.config.unknown, UnknownCells::Priced { .. });
        for (cell, now) in now {
            if cell.row >= geometry.rows || cell.col >= geometry.cols {
                continue;
            }
            let before = &mut self.seen.values[geometry.index(cell)];
            let dearer = self.config.is_blocking(*before) != self.config.is_blocking(now);
            if dearer || (is_priced && *before != now) {
                touched.push(cell);
            }
            *before = now;
            self.occupied.set(cell.row, cell.col, now == Occupancy::Occupied);
        }
        let mut changes = CostChanges::default();
        let boxes = touched.boxes();
        for &changed in &boxes {
            self.price(changed, &mut changes);
        }
        if boxes.len() > 1 {
            let mut both: Vec<(Cell, f32)> = changes.cells.into_iter().zip(changes.costs).collect();
            both.sort_unstable_by_key(|&(cell, _)| cell);
            (changes.cells, changes.costs) = both.into_iter().unzip();
        }
        changes
    }

    /// Prices a box of changed cells, grown by how far a change reaches.
    fn price(&mut self, changed: [usize; 4], changes: &mut CostChanges) {
        let [r0, r1, c0, c1] = changed;
        let geometry = self.seen.geometry;
        let ground = self.ground.as_deref().map(|values| CostLayer {
            name: "ground",
            values,
            weight: self.config.distance_weight,
        });
        let layers: Vec<&CostLayer> = ground.iter().collect();
        let Self { config, footprint, .. } = self;
        let pricing = Pricing { config, footprint, layers: &layers, flat: layers.is_empty() };
        let reach = pricing.reach_cells(geometry.resolution_m);
        let grown = |lo: usize, hi: usize, cells: usize| -> Range<usize> {
            lo.saturating_sub(reach)..(hi + reach + 1).min(cells)
        };
        let (rows, cols) = (grown(r0, r1, geometry.rows), grown(c0, c1, geometry.cols));
        let mut priced = pricing.of(&self.seen, rows.clone(), cols.clone()).into_iter();
        for row in rows {
            for col in cols.clone() {
                let Some(cost) = priced.next() else { return };
                let there = &mut self.costs.values[row * geometry.cols + col];
                if *there != cost {
                    *there = cost;
                    changes.cells.push(Cell::new(row, col));
                    changes.costs.push(cost);
                }
            }
        }
    }
}

/// Boxes around changed cells: first and last row, first and last column.
struct Touched {
    boxes: Vec<[usize; 4]>,
    /// How far a change reaches \[cells\].
    reach: usize,
}

impl Touched {
    /// Into the first box that prices cells about it anyway, or one of its own.
    fn push(&mut self, cell: Cell) {
        let Cell { row, col } = cell;
        let apart = 2 * self.reach;
        let is_near = |&&mut [r0, r1, c0, c1]: &&mut [usize; 4]| {
            row + apart >= r0 && row <= r1 + apart && col + apart >= c0 && col <= c1 + apart
        };
        match self.boxes.iter_mut().find(is_near) {
            Some([r0, r1, c0, c1]) => {
                (*r0, *r1, *c0, *c1) = ((*r0).min(row), (*r1).max(row), (*c0).min(col), (*c1).max(col));
            }
            None => self.boxes.push([row, row, col, col]),
        }
    }

    /// The boxes, or the one around all of them if that is no more to look at.
    fn boxes(self) -> Vec<[usize; 4]> {
        // Twice the reach to each side: what is priced, and what prices it.
        let beyond = 4 * self.reach + 1;
        let looked_at = |&[r0, r1, c0, c1]: &[usize; 4]| (r1 - r0 + beyond) * (c1 - c0 + beyond);
        let around =
            |a: [usize; 4], b: &[usize; 4]| [a[0].min(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].max(b[3])];
        match self.boxes.as_slice() {
            [first, rest @ ..] => {
                let all = rest.iter().fold(*first, around);
                if looked_at(&all) <= self.boxes.iter().map(looked_at).sum() { vec![all] } else { self.boxes }
            }
            [] => self.boxes,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose2;
    use proptest::prelude::*;

    const ROBOT: Footprint = Footprint { length_m: 0.3, width_m: 0.22 };
    const ROWS: usize = 24;
    const COLS: usize = 31;

    fn any_cell() -> impl Strategy<Value = (Cell, Occupancy)> {
        let seen = prop_oneof![Just(Occupancy::Free), Just(Occupancy::Occupied), Just(Occupancy::Unknown)];
        ((0..ROWS + 2, 0..COLS + 2), seen).prop_map(|((row, col), seen)| (Cell::new(row, col), seen))
    }

    proptest! {
        #[test]
        fn costs_kept_through_any_changes_are_those_of_the_map_as_it_is_to_the_bit(
            rounds in proptest::collection::vec(proptest::collection::vec(any_cell(), 0..6), 1..6),
            unknown in prop_oneof![
                Just(UnknownCells::Free), Just(UnknownCells::Blocked), Just(UnknownCells::Priced { factor: 2.5 })
            ],
            hilly in any::<bool>(),
        ) {
            let geometry =
                GridGeometry { rows: ROWS, cols: COLS, resolution_m: 0.1, world_from_grid: Pose2::IDENTITY };
            let config = CostmapConfig { unknown, soft_margin_m: 0.25, ..Default::default() };
            let ground = hilly.then(|| (0..geometry.len()).map(|i| 1.0 + (i % 7) as f32).collect::<Vec<_>>());
            let mut now = Grid::filled(geometry, Occupancy::Unknown);
            let mut kept = KeptCosts::new(now.clone(), ROBOT, config, ground.clone()).unwrap();
            for round in rounds {
                let before = kept.costs().clone();
                let changes = kept.update(round.iter().copied());
                for &(cell, seen) in round.iter().filter(|(cell, _)| cell.row < ROWS && cell.col < COLS) {
                    now.values[geometry.index(cell)] = seen;
                }
                let anew = costmap_with_layers(&now, &ROBOT, &config, ground.as_deref(), &[]).unwrap();
                prop_assert_eq!(kept.costs(), &anew);
                let occupied = kept.occupied();
                for i in 0..geometry.len() {
                    let cell = geometry.cell(i);
                    prop_assert_eq!(occupied.holds(cell), *now.at(cell) == Occupancy::Occupied);
                }
                let differ = (0..geometry.len()).filter(|&i| before.values[i] != anew.values[i]);
                let told: Vec<usize> = changes.cells.iter().map(|&cell| geometry.index(cell)).collect();
                prop_assert_eq!(differ.collect::<Vec<_>>(), told);
            }
        }
    }
}
