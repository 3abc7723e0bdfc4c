//! A field made right again after costs changed.

use std::sync::Arc;

use super::field::Native;
use super::solve::{GridPlanner, PlanOptions, is_safe, plan_costs};
use super::tiles::{CellNumber, FreeBits, FreeGrid, MeanGrid, Repair, Repaired, Simd, TileCost, repair};
use super::{Crossed, Field, PlanError, Values};
use crate::world::{Cell, Grid, GridGeometry};

/// What a field was solved on, as it is now.
#[derive(Clone, Debug)]
pub enum Basis {
    /// Nothing that it could be repaired with.
    None,
    /// Free cells of unit cost.
    Free {
        /// The cells.
        bits: FreeBits,
        /// How it was solved.
        options: PlanOptions,
        /// What solving it took.
        work: usize,
    },
    /// Costs in single precision.
    F32(CostBasis<f32>),
    /// Costs in double precision.
    F64(CostBasis<f64>),
}

/// Costs that a field was solved on.
#[derive(Clone, Debug)]
pub struct CostBasis<T> {
    /// The costs.
    pub costs: Arc<Grid<T>>,
    /// How it was solved.
    pub options: PlanOptions,
    /// A range that all finite costs lie in.
    pub range: [T; 2],
    /// Whether no sum lost a link or went beyond the type.
    pub safe: bool,
    /// What solving it took.
    pub work: usize,
}

/// A number type that has its basis.
pub trait HasBasis: Sized {
    /// The basis in this type.
    fn basis(basis: CostBasis<Self>) -> Basis;
    /// The basis, if it is in this type.
    fn in_basis(basis: &mut Basis) -> Option<&mut CostBasis<Self>>;
    /// The numbers, if they are of this type.
    fn in_values(values: &mut Values) -> Option<&mut Vec<Self>>;
    /// The planner's part for this type, and its spare codes.
    fn in_planner(planner: &mut GridPlanner) -> (&mut super::solve::Desk<Self>, &mut Vec<i8>)
    where
        Self: TileCost;
}

macro_rules! has_basis {
    ($type:ident, $variant:ident, $desk:ident) => {
        impl HasBasis for $type {
            fn basis(basis: CostBasis<Self>) -> Basis {
                Basis::$variant(basis)
            }
            fn in_basis(basis: &mut Basis) -> Option<&mut CostBasis<Self>> {
                if let Basis::$variant(basis) = basis { Some(basis) } else { None }
            }
            fn in_values(values: &mut Values) -> Option<&mut Vec<Self>> {
                if let Values::$variant(values) = values { Some(values) } else { None }
            }
            fn in_planner(planner: &mut GridPlanner) -> (&mut super::solve::Desk<Self>, &mut Vec<i8>) {
                (&mut planner.$desk, &mut planner.codes)
            }
        }
    };
}
has_basis!(f32, F32, in_f32);
has_basis!(f64, F64, in_f64);

/// The planner that a field is repaired with; a copy of the field starts with an empty one.
#[derive(Debug, Default)]
pub struct Workshop(Box<GridPlanner>);

impl Clone for Workshop {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// New costs of some cells, in the kind that the field was solved on.
#[derive(Clone, Copy, Debug)]
pub enum NewCosts<'a> {
    /// Whether they are free, at unit cost.
    Free(&'a [bool]),
    /// Costs in single precision, infinite where blocked.
    F32(&'a [f32]),
    /// Costs in double precision, infinite where blocked.
    F64(&'a [f64]),
}

/// What an update took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Update {
    /// Whether the field was solved anew.
    pub anew: bool,
    /// Cells whose cost really changed.
    pub changed: usize,
    /// Cells that were forgotten because their way became dearer; 0 if solved anew.
    pub forgotten: usize,
    /// Visits to tiles; 0 if solved anew.
    pub visits: usize,
}

impl Field {
    /// Changes the costs of some cells and makes the field right again, policy included: it equals the field
    /// solved anew, to the bit. Of a cell given twice, the last cost counts.
    ///
    /// Repairing gives up and solves anew when its work, counted in visits to tiles, passes the share
    /// `give_up` of what the last solution took (0.1 is a good one).
    ///
    /// # Errors
    /// [`PlanError::CellOutsideGrid`], [`UpdateLengthMismatch`](PlanError::UpdateLengthMismatch),
    /// [`GoalBlocked`](PlanError::GoalBlocked), [`CellCostNan`](PlanError::CellCostNan),
    /// [`CellCostNegative`](PlanError::CellCostNegative), [`CellCostZero`](PlanError::CellCostZero),
    /// [`LinkCostAbsorbed`](PlanError::LinkCostAbsorbed), [`CostToGoOverflow`](PlanError::CostToGoOverflow);
    /// [`FieldNotUpdatable`](PlanError::FieldNotUpdatable) if it was solved for one start only, on costs of
    /// another kind, or on terrain or costs per move. The field is as it was then.
    pub fn update(&mut self, cells: &[Cell], costs: NewCosts<'_>, give_up: f64) -> Result<Update, PlanError> {
        match costs {
            NewCosts::Free(free) => self.update_free(cells, free, give_up),
            NewCosts::F32(costs) => self.update_costs(cells, costs, give_up),
            NewCosts::F64(costs) => self.update_costs(cells, costs, give_up),
        }
    }

    fn update_free(&mut self, cells: &[Cell], free: &[bool], give_up: f64) -> Result<Update, PlanError> {
        self.check_cells(cells, free.len())?;
        for (cell, _) in cells.iter().zip(free).filter(|&(_, &free)| !free) {
            self.check_not_goal(*cell)?;
        }
        let GridGeometry { rows, cols, .. } = self.geometry;
        let Basis::Free { bits, options, work } = &mut self.basis else {
            return Err(self.not_of_this_kind());
        };
        check_whole(options)?;
        let mut changed = Vec::new();
        for (cell, &free) in cells.iter().zip(free) {
            if bits.is_free(cell.row, cell.col) != free {
                bits.set(cell.row, cell.col, free);
                changed.push((cell.row, cell.col));
            }
        }
        let update = Update { changed: changed.len(), ..Update::default() };
        if changed.is_empty() {
            return Ok(update);
        }
        if let Values::U32(values) = &mut self.values {
            let (straight, diagonal) = options.steps.lengths();
            let simd = options.simd.unwrap_or_else(Simd::widest);
            let room = &mut self.planner.0.in_u32.room;
            let codes = &mut self.next_codes;
            let most_work = share(*work, give_up);
            macro_rules! repaired {
                ($cut:literal) => {{
                    let links = &FreeGrid::<u32, $cut> { free: bits, straight, diagonal };
                    repair(
                        room,
                        simd,
                        Repair { links, rows, cols, changed: &changed, values, codes, most_work },
                    )
                }};
            }
            let repaired = if options.corner_cutting { repaired!(true) } else { repaired!(false) };
            if let Some(repaired) = repaired.filter(|repaired| repaired.largest.sum(diagonal) < u32::FAR) {
                return Ok(done(update, &repaired));
            }
        }
        let (bits, options) = (std::mem::take(bits), options.clone());
        let planner = &mut self.planner.0;
        let spoilt = std::mem::replace(&mut self.values, Values::U32(Vec::new()));
        planner.keep_arrays(spoilt, std::mem::take(&mut self.next_codes));
        let anew = planner.plan_bits(bits, self.geometry, &self.goals, &options);
        (self.values, self.next_codes, self.basis) = anew.into_arrays();
        Ok(Update { anew: true, ..update })
    }

    fn update_costs<T>(&mut self, cells: &[Cell], costs: &[T], give_up: f64) -> Result<Update, PlanError>
    where
        T: CellNumber + Native + HasBasis,
    {
        self.check_cells(cells, costs.len())?;
        for (cell, &cost) in cells.iter().zip(costs) {
            let (Cell { row, col }, value) = (*cell, cost.to_f64());
            if cost.is_nan() {
                return Err(PlanError::CellCostNan { row, col, value });
            } else if cost < T::ZERO {
                return Err(PlanError::CellCostNegative { row, col, value });
            } else if cost == T::ZERO {
                return Err(PlanError::CellCostZero { row, col, value });
            } else if cost == T::UNREACHABLE {
                self.check_not_goal(*cell)?;
            }
        }
        let geometry = self.geometry;
        let GridGeometry { rows, cols, .. } = geometry;
        let Some(basis) = T::in_basis(&mut self.basis) else { return Err(self.not_of_this_kind()) };
        check_whole(&basis.options)?;
        let range_before = basis.range;
        let grid = Arc::make_mut(&mut basis.costs);
        let (mut changed, mut before) = (Vec::new(), Vec::new());
        for (cell, &cost) in cells.iter().zip(costs) {
            let there = &mut grid.values[geometry.index(*cell)];
            if *there != cost {
                before.push((geometry.index(*cell), *there));
                changed.push((cell.row, cell.col));
                *there = cost;
                let [least, most] = &mut basis.range;
                if cost < T::UNREACHABLE {
                    *least = if cost < *least { cost } else { *least };
                    *most = if cost > *most { cost } else { *most };
                }
            }
        }
        let update = Update { changed: changed.len(), ..Update::default() };
        if changed.is_empty() {
            return Ok(update);
        }
        let planner = &mut self.planner.0;
        if let Some(values) = T::in_values(&mut self.values).filter(|_| basis.safe) {
            let simd = basis.options.simd.unwrap_or_else(Simd::widest);
            let room = &mut T::in_planner(planner).0.room;
            let codes = &mut self.next_codes;
            let most_work = share(basis.work, give_up);
            let costs = &grid.values;
            macro_rules! repaired {
                ($cut:literal) => {{
                    let links = &MeanGrid::<T, $cut> { costs, rows, cols };
                    repair(
                        room,
                        simd,
                        Repair { links, rows, cols, changed: &changed, values, codes, most_work },
                    )
                }};
            }
            let repaired = if basis.options.corner_cutting { repaired!(true) } else { repaired!(false) };
            if let Some(repaired) = repaired.filter(|repaired| is_safe(repaired.largest, basis.range)) {
                return Ok(done(update, &repaired));
            }
        }
        let spoilt = std::mem::replace(&mut self.values, Values::U32(Vec::new()));
        planner.keep_arrays(spoilt, std::mem::take(&mut self.next_codes));
        let (desk, codes) = T::in_planner(planner);
        let options = basis.options.clone();
        let refused = match plan_costs(desk, codes, basis.costs.clone(), &self.goals, &options) {
            Ok(anew) => {
                (self.values, self.next_codes, self.basis) = anew.into_arrays();
                return Ok(Update { anew: true, ..update });
            }
            Err(refused) => refused,
        };
        let grid = Arc::make_mut(&mut basis.costs);
        for (index, cost) in before.into_iter().rev() {
            grid.values[index] = cost;
        }
        basis.range = range_before;
        let as_it_was = plan_costs(desk, codes, basis.costs.clone(), &self.goals, &options)?;
        (self.values, self.next_codes, self.basis) = as_it_was.into_arrays();
        Err(refused)
    }

    /// What the ways of this field cross, and whether corners may be cut, as [`any_angle_path`] asks for it;
    /// None if it was solved on terrain or on costs per move.
    ///
    /// [`any_angle_path`]: Self::any_angle_path
    pub fn crossed(&self) -> Option<(Crossed<'_>, bool)> {
        match &self.basis {
            Basis::None => None,
            Basis::Free { options, .. } => Some((Crossed::Free, options.corner_cutting)),
            Basis::F32(basis) => Some((Crossed::F32(&basis.costs.values), basis.options.corner_cutting)),
            Basis::F64(basis) => Some((Crossed::F64(&basis.costs.values), basis.options.corner_cutting)),
        }
    }

    fn check_cells(&self, cells: &[Cell], costs: usize) -> Result<(), PlanError> {
        if cells.len() != costs {
            return Err(PlanError::UpdateLengthMismatch { cells: cells.len(), costs });
        }
        let GridGeometry { rows, cols, .. } = self.geometry;
        match cells.iter().find(|cell| cell.row >= rows || cell.col >= cols) {
            Some(&Cell { row, col }) => {
                Err(PlanError::CellOutsideGrid { row: row as i64, col: col as i64, rows, cols })
            }
            None => Ok(()),
        }
    }

    fn check_not_goal(&self, cell: Cell) -> Result<(), PlanError> {
        let Cell { row, col } = cell;
        if self.goals.contains(&cell) { Err(PlanError::GoalBlocked { row, col }) } else { Ok(()) }
    }

    fn not_of_this_kind(&self) -> PlanError {
        let reason = match self.basis {
            Basis::None => "it was solved on terrain or on costs per move; plan anew",
            Basis::Free { .. } => "it was solved on free and blocked cells; give bools",
            Basis::F32(_) => "it was solved on costs in single precision; give f32",
            Basis::F64(_) => "it was solved on costs in double precision; give f64",
        };
        PlanError::FieldNotUpdatable { reason }
    }
}

fn check_whole(options: &PlanOptions) -> Result<(), PlanError> {
    if options.start.is_none() {
        return Ok(());
    }
    let reason = "it was solved for one start only; plan without start, or plan anew";
    Err(PlanError::FieldNotUpdatable { reason })
}

fn share(work: usize, share: f64) -> usize {
    (work as f64 * share) as usize // as large as can be for infinity, 0 for NaN
}

fn done<T>(update: Update, repaired: &Repaired<T>) -> Update {
    Update { forgotten: repaired.forgotten, visits: repaired.visits, ..update }
}
