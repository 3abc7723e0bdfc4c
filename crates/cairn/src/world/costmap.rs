//! What it costs to drive over each cell, for one robot `[Maalouf06 §3]`.

use std::ops::Range;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::distance::{To, transform};
use super::{Cell, Grid, GridGeometry, Occupancy, OccupancyGrid};
use crate::robot::Footprint;

/// What to make of cells that were never seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum UnknownCells {
    /// As free cells.
    #[default]
    Free,
    /// As occupied cells: the robot keeps clear of them too.
    Blocked,
    /// As free cells that cost `factor` times as much.
    Priced {
        /// Greater than zero.
        factor: f64,
    },
}

/// How the factors of cost are weighed. The cost of a metre is
///
/// `distance_weight · ground + time_weight / speed + safety_weight · closeness² + Σ weight · layer`,
///
/// times the factor of unknown cells. `ground` is 1 unless given. With d the distance from a cell's
/// centre to the nearest point of an occupied cell, `closeness` falls linearly from 1 at the
/// inscribed radius to 0 at the circumscribed one plus `soft_margin_m`; `speed` rises linearly over
/// the same stretch from `near_speed_mps` to `open_speed_mps`. Up to the inscribed radius the robot
/// would touch: blocked. Beyond the grid's edge nothing is occupied.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CostmapConfig {
    /// What to make of cells that were never seen.
    pub unknown: UnknownCells,
    /// Price of a metre.
    pub distance_weight: f64,
    /// Price of a second.
    pub time_weight: f64,
    /// Price of a metre so close that the robot nearly touches.
    pub safety_weight: f64,
    /// How far beyond the circumscribed radius nearness still costs \[m\].
    pub soft_margin_m: f64,
    /// Speed at which the robot would pass an obstacle that it nearly touches \[m/s\].
    pub near_speed_mps: f64,
    /// Speed with no obstacle near \[m/s\].
    pub open_speed_mps: f64,
}

impl Default for CostmapConfig {
    /// For an office: the middle of doors and corridors, at little detour.
    fn default() -> Self {
        Self {
            unknown: UnknownCells::Free,
            distance_weight: 1.0,
            time_weight: 0.0,
            safety_weight: 8.0,
            soft_margin_m: 0.35,
            near_speed_mps: 0.15,
            open_speed_mps: 0.7,
        }
    }
}

/// A further price per metre of each cell, such as noise, slope or traffic.
#[derive(Clone, Copy, Debug)]
pub struct CostLayer<'a> {
    /// For messages.
    pub name: &'a str,
    /// One value ≥ 0 for every cell, row-major; inf blocks the cell.
    pub values: &'a [f32],
    /// What a unit of it costs.
    pub weight: f64,
}

/// Why a cost map could not be made.
#[derive(Clone, Debug, PartialEq, Error, Serialize)]
pub enum WorldError {
    /// A number of the configuration is not usable.
    #[error("costmap: {key} is {value}, must be {rule}")]
    CostmapValueOutOfRange {
        /// Key in the configuration.
        key: String,
        /// What it says.
        value: f64,
        /// What would be right.
        rule: String,
    },
    /// A layer has not one value for every cell.
    #[error("costmap: layer `{layer}` has {values} values, the grid {rows} × {cols} cells")]
    LayerShapeMismatch {
        /// Name of the layer.
        layer: String,
        /// Values it has.
        values: usize,
        /// Rows of the grid.
        rows: usize,
        /// Columns of the grid.
        cols: usize,
    },
    /// A layer holds a negative number or NaN.
    #[error("costmap: layer `{layer}` is {value} at row {row}, column {col}; must be at least 0")]
    LayerValueInvalid {
        /// Name of the layer.
        layer: String,
        /// Row of the cell.
        row: usize,
        /// Column of the cell.
        col: usize,
        /// What it says.
        value: f32,
    },
}

impl CostmapConfig {
    /// Whether the robot keeps clear of such a cell.
    pub(super) fn is_blocking(&self, seen: Occupancy) -> bool {
        match seen {
            Occupancy::Free => false,
            Occupancy::Occupied => true,
            Occupancy::Unknown => self.unknown == UnknownCells::Blocked,
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`WorldError::CostmapValueOutOfRange`] names the first key that is not usable.
    pub fn validated(self) -> Result<Self, WorldError> {
        const MOST: f64 = 1e6;
        let check = |key: &str, value: f64, least: f64, rule: &str| {
            if (least..=MOST).contains(&value) {
                return Ok(());
            }
            let rule = format!("{rule} and at most {MOST}");
            Err(WorldError::CostmapValueOutOfRange { key: key.to_owned(), value, rule })
        };
        check("distance_weight", self.distance_weight, 0.0, "at least 0")?;
        check("time_weight", self.time_weight, 0.0, "at least 0")?;
        check("safety_weight", self.safety_weight, 0.0, "at least 0")?;
        check("soft_margin_m", self.soft_margin_m, 0.0, "at least 0")?;
        check("near_speed_mps", self.near_speed_mps, 1e-3, "at least 0.001")?;
        check("open_speed_mps", self.open_speed_mps, self.near_speed_mps, "at least near_speed_mps")?;
        let metre = self.distance_weight + self.time_weight / self.open_speed_mps;
        check("distance_weight + time_weight / open_speed_mps", metre, 1e-6, "at least 1e-6")?;
        if let UnknownCells::Priced { factor } = self.unknown {
            check("unknown.priced.factor", factor, 1e-6, "at least 1e-6")?;
        }
        Ok(self)
    }
}

/// Cost per metre of every cell, > 0; inf where `footprint` cannot be without touching.
///
/// # Errors
/// [`WorldError`] when the configuration is not usable.
pub fn costmap(
    occupancy: &OccupancyGrid,
    footprint: &Footprint,
    config: &CostmapConfig,
) -> Result<Grid<f32>, WorldError> {
    costmap_with_layers(occupancy, footprint, config, None, &[])
}

/// As [`costmap`], with a price of the ground (1 is ordinary, inf blocked) that multiplies the
/// distance term, and further layers.
///
/// # Errors
/// [`WorldError`] when the configuration, the ground or a layer is not usable.
pub fn costmap_with_layers(
    occupancy: &OccupancyGrid,
    footprint: &Footprint,
    config: &CostmapConfig,
    ground: Option<&[f32]>,
    layers: &[CostLayer],
) -> Result<Grid<f32>, WorldError> {
    let config = config.validated()?;
    let ground_layer =
        ground.map(|values| CostLayer { name: "ground", values, weight: config.distance_weight });
    for layer in ground_layer.iter().chain(layers) {
        check_layer(layer, occupancy)?;
    }

    let all: Vec<&CostLayer> = ground_layer.iter().chain(layers).collect();
    let pricing = Pricing { config: &config, footprint, layers: &all, flat: ground.is_none() };
    let GridGeometry { rows, cols, .. } = occupancy.geometry;
    Ok(Grid::new(occupancy.geometry, pricing.of(occupancy, 0..rows, 0..cols)))
}

/// Everything that prices a cell, but the cells.
pub(super) struct Pricing<'a> {
    pub config: &'a CostmapConfig,
    pub footprint: &'a Footprint,
    pub layers: &'a [&'a CostLayer<'a>],
    /// No layer is the ground: a metre is a metre.
    pub flat: bool,
}

impl Pricing<'_> {
    /// Farther than this many cells nothing is dearer for what stands there.
    pub fn reach_cells(&self, resolution_m: f64) -> usize {
        let reach_m = self.footprint.circumscribed_radius_m() + self.config.soft_margin_m;
        (reach_m / resolution_m).ceil() as usize + 1
    }

    /// Costs of the cells in a window, row-major: those of the whole grid, to the bit.
    pub fn of(&self, occupancy: &OccupancyGrid, rows: Range<usize>, cols: Range<usize>) -> Vec<f32> {
        let geometry = occupancy.geometry;
        let price = Price::new(geometry.resolution_m, self.footprint, self.config, self.flat);
        // What stands farther away than this prices nothing in the window.
        let reach = self.reach_cells(geometry.resolution_m);
        let near_rows = rows.start.saturating_sub(reach)..(rows.end + reach).min(geometry.rows);
        let near_cols = cols.start.saturating_sub(reach)..(cols.end + reach).min(geometry.cols);
        let mut occupied = Vec::with_capacity(near_rows.len() * near_cols.len());
        for row in near_rows.clone() {
            let seen = &occupancy.values[row * geometry.cols..][near_cols.clone()];
            occupied.extend(seen.iter().map(|&seen| self.config.is_blocking(seen)));
        }
        let near = GridGeometry { rows: near_rows.len(), cols: near_cols.len(), ..geometry };
        let prices = transform(&Grid::new(near, occupied), To::Surface, |half_cells| price.at(half_cells));

        let mut costs = Vec::with_capacity(rows.len() * cols.len());
        for row in rows {
            let first = (row - near_rows.start) * near.cols + (cols.start - near_cols.start);
            for (&price, col) in prices[first..][..cols.len()].iter().zip(cols.clone()) {
                costs.push(self.total(price, row * geometry.cols + col, occupancy));
            }
        }
        costs
    }

    fn total(&self, price: f64, index: usize, occupancy: &OccupancyGrid) -> f32 {
        let mut cost = price;
        for layer in self.layers.iter().filter(|layer| layer.weight > 0.0) {
            cost += layer.weight * f64::from(layer.values[index]);
        }
        if let UnknownCells::Priced { factor } = self.config.unknown {
            cost *= if occupancy.values[index] == Occupancy::Unknown { factor } else { 1.0 };
        }
        if cost.is_infinite() { f32::INFINITY } else { cost.clamp(1e-12, f64::from(f32::MAX)) as f32 }
    }
}

fn check_layer(layer: &CostLayer, occupancy: &OccupancyGrid) -> Result<(), WorldError> {
    let g = occupancy.geometry;
    if layer.values.len() != g.len() {
        let (layer, values) = (layer.name.to_owned(), layer.values.len());
        return Err(WorldError::LayerShapeMismatch { layer, values, rows: g.rows, cols: g.cols });
    }
    if !(0.0..=1e6).contains(&layer.weight) {
        let (key, rule) = (format!("weight of layer `{}`", layer.name), "from 0 to 1e6".to_owned());
        return Err(WorldError::CostmapValueOutOfRange { key, value: layer.weight, rule });
    }
    if let Some(index) = layer.values.iter().position(|&value| value.is_nan() || value < 0.0) {
        let (Cell { row, col }, value) = (g.cell(index), layer.values[index]);
        return Err(WorldError::LayerValueInvalid { layer: layer.name.to_owned(), row, col, value });
    }
    Ok(())
}

/// Cost of a metre as a function of the distance to the nearest surface.
struct Price<'a> {
    config: &'a CostmapConfig,
    inscribed_m: f64,
    reach_m: f64,
    half_cell_m: f64,
    distance: f64,
}

impl<'a> Price<'a> {
    fn new(resolution_m: f64, footprint: &Footprint, config: &'a CostmapConfig, flat: bool) -> Self {
        let inscribed_m = footprint.inscribed_radius_m();
        let reach_m = footprint.circumscribed_radius_m() + config.soft_margin_m - inscribed_m;
        let distance = if flat { config.distance_weight } else { 0.0 };
        Self { config, inscribed_m, reach_m, half_cell_m: resolution_m / 2.0, distance }
    }

    fn at(&self, half_cells: f64) -> f64 {
        let clearance_m = half_cells * self.half_cell_m - self.inscribed_m;
        if clearance_m <= 0.0 {
            return f64::INFINITY;
        }
        let closeness = (1.0 - clearance_m / self.reach_m).max(0.0);
        let c = self.config;
        let speed_mps = c.open_speed_mps + (c.near_speed_mps - c.open_speed_mps) * closeness;
        self.distance + c.time_weight / speed_mps + c.safety_weight * closeness * closeness
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose2;
    use proptest::prelude::*;

    const P3AT: Footprint = Footprint { length_m: 0.626, width_m: 0.505 };

    fn world(rows: usize, cols: usize, cell: impl Fn(usize, usize) -> Occupancy) -> OccupancyGrid {
        let g = GridGeometry { rows, cols, resolution_m: 0.05, world_from_grid: Pose2::IDENTITY };
        Grid::new(g, (0..g.len()).map(|i| cell(i / cols, i % cols)).collect())
    }

    /// A wall across the middle with a door one metre wide.
    fn door() -> OccupancyGrid {
        world(60, 60, |row, col| {
            let wall = (28..31).contains(&row) && !(20..40).contains(&col);
            if wall { Occupancy::Occupied } else { Occupancy::Free }
        })
    }

    #[test]
    fn a_door_of_one_metre_is_passable_and_cheapest_in_its_middle() {
        let costs = costmap(&door(), &P3AT, &CostmapConfig::default()).unwrap();
        let row: Vec<f32> = (20..40).map(|col| *costs.at(Cell::new(29, col))).collect();
        let open = row.iter().filter(|c| c.is_finite()).count();
        // Centres 0.275 m and more from the jambs: the robot's half width is 0.2525 m.
        assert_eq!(open, 10);
        let least = row.iter().copied().fold(f32::INFINITY, f32::min);
        assert!(row[9] == least && row[10] == least && row[8] > least && row[11] > least);
    }

    #[test]
    fn beyond_the_soft_margin_a_metre_costs_the_distance_weight() {
        let costs = costmap(&door(), &P3AT, &CostmapConfig::default()).unwrap();
        assert_eq!(*costs.at(Cell::new(0, 0)), 1.0);
        assert_eq!(*costs.at(Cell::new(59, 0)), 1.0);
    }

    #[test]
    fn unknown_cells_are_free_blocked_or_priced_as_asked() {
        let seen = world(1, 40, |_, col| if col < 20 { Occupancy::Free } else { Occupancy::Unknown });
        let with =
            |unknown| costmap(&seen, &P3AT, &CostmapConfig { unknown, ..Default::default() }).unwrap().values;
        assert_eq!(with(UnknownCells::Free), vec![1.0; 40]);
        let blocked = with(UnknownCells::Blocked);
        assert!(blocked[14].is_finite() && blocked[15..].iter().all(|c| c.is_infinite()));
        let priced = with(UnknownCells::Priced { factor: 3.0 });
        assert!(priced[..20] == [1.0; 20] && priced[20..] == [3.0; 20]);
    }

    #[test]
    fn factors_add_up_as_weighed() {
        let open = world(1, 2, |_, _| Occupancy::Free);
        let config = CostmapConfig { distance_weight: 2.0, time_weight: 1.4, ..Default::default() };
        let noise = CostLayer { name: "noise", values: &[0.5, f32::INFINITY], weight: 4.0 };
        let costs = costmap_with_layers(&open, &P3AT, &config, Some(&[3.0, 1.0]), &[noise]).unwrap();
        assert_eq!(costs.values, vec![10.0, f32::INFINITY]); // 2·3 + 1.4/0.7 + 4·0.5
    }

    #[test]
    fn time_alone_is_a_cost_and_no_price_at_all_is_refused() {
        let only_time = CostmapConfig { distance_weight: 0.0, time_weight: 0.7, ..Default::default() };
        let open = world(2, 2, |_, _| Occupancy::Free);
        assert_eq!(costmap(&open, &P3AT, &only_time).unwrap().values, vec![1.0; 4]);
        let nothing = CostmapConfig { distance_weight: 0.0, ..Default::default() };
        let error = costmap(&open, &P3AT, &nothing).unwrap_err();
        assert!(matches!(error, WorldError::CostmapValueOutOfRange { value: 0.0, .. }));
    }

    #[test]
    fn bad_numbers_are_refused_by_name() {
        let open = world(2, 2, |_, _| Occupancy::Free);
        for config in [
            CostmapConfig { safety_weight: f64::NAN, ..Default::default() },
            CostmapConfig { soft_margin_m: -0.1, ..Default::default() },
            CostmapConfig { near_speed_mps: 0.0, ..Default::default() },
            CostmapConfig { open_speed_mps: 0.1, ..Default::default() },
            CostmapConfig { unknown: UnknownCells::Priced { factor: 0.0 }, ..Default::default() },
        ] {
            let error = costmap(&open, &P3AT, &config).unwrap_err();
            assert!(matches!(error, WorldError::CostmapValueOutOfRange { .. }), "{error}");
        }
        let layer = |values, weight| {
            let layers = [CostLayer { name: "noise", values, weight }];
            costmap_with_layers(&open, &P3AT, &CostmapConfig::default(), None, &layers).unwrap_err()
        };
        assert!(matches!(layer(&[0.0; 3], 1.0), WorldError::LayerShapeMismatch { values: 3, .. }));
        assert!(matches!(layer(&[0.0; 4], -1.0), WorldError::CostmapValueOutOfRange { .. }));
        let negative = layer(&[0.0, 0.0, -1.0, 0.0], 1.0);
        assert!(matches!(negative, WorldError::LayerValueInvalid { row: 1, col: 0, .. }));
    }

    proptest! {
        #[test]
        fn every_cost_is_positive_and_blocked_is_just_where_the_inscribed_disc_touches(
            things in proptest::collection::vec((0usize..30, 0usize..30), 0..12), safety in 0.0..50.0f64,
        ) {
            let grid = world(30, 30, |row, col| {
                if things.contains(&(row, col)) { Occupancy::Occupied } else { Occupancy::Free }
            });
            let config = CostmapConfig { safety_weight: safety, ..Default::default() };
            let costs = costmap(&grid, &P3AT, &config).unwrap();
            for i in 0..grid.values.len() {
                let cell = grid.geometry.cell(i);
                let gap = |a: usize, b: usize| 0.025 * (2 * a.abs_diff(b)).saturating_sub(1) as f64;
                let touched = things.iter().any(|&(row, col)| {
                    gap(row, cell.row).hypot(gap(col, cell.col)) <= P3AT.inscribed_radius_m()
                });
                prop_assert_eq!(costs.values[i].is_infinite(), touched);
                prop_assert!(costs.values[i] >= 1.0);
            }
        }
    }
}
