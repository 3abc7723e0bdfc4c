use super::moves::MOVES;
use super::update::{Basis, Workshop};
use super::{Cost, PlanError};
use crate::geometry::Point2;
use crate::world::{Cell, GridGeometry};

/// The cost-to-go of every cell, row-major, in the number type it was solved in.
///
/// Cells without a way to a goal hold the largest value of the integer types, or infinity.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Integer steps.
    U32(Vec<u32>),
    /// Integer steps too many for u32.
    U64(Vec<u64>),
    /// Single precision.
    F32(Vec<f32>),
    /// Double precision.
    F64(Vec<f64>),
}

/// What one plan yields for ALL cells: the cost of the best way to the nearest goal, and the next
/// cell on it [Maalouf06 §3.2: C⁺ and the pointer p].
///
/// A robot knocked off its path goes on from wherever it is, and any number of robots share it.
#[derive(Clone, Debug)]
pub struct Field {
    pub(super) geometry: GridGeometry,
    pub(super) goals: Vec<Cell>,
    pub(super) values: Values,
    /// Native cost of one straight step through cells of unit cost.
    unit: f64,
    pub(super) next_codes: Vec<i8>,
    /// What it was solved on.
    pub(super) basis: Basis,
    /// What [`update`](Self::update) works with.
    pub(super) planner: Workshop,
}

/// Fields are equal if they say the same of the same grid, whatever they keep for repair.
impl PartialEq for Field {
    fn eq(&self, other: &Self) -> bool {
        self.geometry == other.geometry
            && self.goals == other.goals
            && self.unit == other.unit
            && self.next_codes == other.next_codes
            && self.values == other.values
    }
}

/// A number type a field can be held in.
pub(super) trait Native: Cost {
    fn wrap(values: Vec<Self>) -> Values;
}

impl Native for u32 {
    fn wrap(values: Vec<Self>) -> Values {
        Values::U32(values)
    }
}
impl Native for u64 {
    fn wrap(values: Vec<Self>) -> Values {
        Values::U64(values)
    }
}
impl Native for f32 {
    fn wrap(values: Vec<Self>) -> Values {
        Values::F32(values)
    }
}
impl Native for f64 {
    fn wrap(values: Vec<Self>) -> Values {
        Values::F64(values)
    }
}

impl Field {
    pub(super) fn new<C: Native>(
        geometry: GridGeometry,
        goals: &[Cell],
        values: Vec<C>,
        unit: f64,
        next_codes: Vec<i8>,
    ) -> Self {
        let (basis, planner) = (Basis::None, Workshop::default());
        Self { geometry, goals: goals.to_vec(), values: C::wrap(values), unit, next_codes, basis, planner }
    }

    /// With what it was solved on.
    pub(super) fn on(self, basis: Basis) -> Self {
        Self { basis, ..self }
    }

    /// Its arrays, for reuse.
    pub(super) fn into_arrays(self) -> (Values, Vec<i8>, Basis) {
        (self.values, self.next_codes, self.basis)
    }

    /// Shape and place of the grid.
    pub fn geometry(&self) -> &GridGeometry {
        &self.geometry
    }

    /// The goals, as given.
    pub fn goals(&self) -> &[Cell] {
        &self.goals
    }

    /// The solver's own numbers, row-major; `unit()` of them are one straight step at unit cost.
    pub fn native(&self) -> &Values {
        &self.values
    }

    /// Native cost of one straight step through cells of unit cost: 985, 100 or 1.
    pub fn unit(&self) -> f64 {
        self.unit
    }

    /// Code 0..7 of the next cell (see [`MOVES`](super::MOVES)), row-major; -1 at goals and where
    /// there is none. Among equally good cells it is the one with the lowest code.
    pub fn next_codes(&self) -> &[i8] {
        &self.next_codes
    }

    /// Cost of the best way from `cell` to a goal \[cost × cells\]; times the resolution it is cost ×
    /// metres. 0 at goals; infinite where blocked, cut off or outside.
    pub fn cost_to_go(&self, cell: Cell) -> f64 {
        let Some(index) = self.index(cell) else { return f64::INFINITY };
        match &self.values {
            Values::U32(values) => values[index].to_f64() / self.unit,
            Values::U64(values) => values[index].to_f64() / self.unit,
            Values::F32(values) => values[index].to_f64() / self.unit,
            Values::F64(values) => values[index].to_f64() / self.unit,
        }
    }

    /// Every [`cost_to_go`](Self::cost_to_go) times `scale`, row-major.
    pub fn costs_to_go(&self, scale: f64) -> Vec<f64> {
        fn all<C: Cost>(values: &[C], unit: f64, scale: f64) -> Vec<f64> {
            values.iter().map(|value| value.to_f64() / unit * scale).collect()
        }
        match &self.values {
            Values::U32(values) => all(values, self.unit, scale),
            Values::U64(values) => all(values, self.unit, scale),
            Values::F32(values) => all(values, self.unit, scale),
            Values::F64(values) => all(values, self.unit, scale),
        }
    }

    /// Whether a way leads from `cell` to a goal.
    pub fn is_reachable(&self, cell: Cell) -> bool {
        self.cost_to_go(cell).is_finite()
    }

    /// The next cell on the best way from `cell`; None at goals, where there is no way, and outside.
    pub fn next(&self, cell: Cell) -> Option<Cell> {
        let code = usize::try_from(self.next_codes[self.index(cell)?]).ok()?;
        let (down, right) = MOVES[code];
        Some(Cell::new(cell.row.wrapping_add_signed(down), cell.col.wrapping_add_signed(right)))
    }

    /// The cells of the best way from `start` to a goal, both ends included; None where there is none.
    pub fn path(&self, start: Cell) -> Option<Vec<Cell>> {
        if !self.is_reachable(start) {
            return None;
        }
        // Every next cell is strictly nearer to the goal, so this ends.
        Some(std::iter::successors(Some(start), |&cell| self.next(cell)).collect())
    }

    /// The way from a point of the world to the goal it ends at \[m\]: `start_in_world` itself, the
    /// centres of the cells between, and the point of `goals_in_world` that lies in the last cell
    /// (its centre if none does). No point is repeated. None where there is no way.
    ///
    /// # Errors
    /// [`PlanError::StartOutsideMap`].
    pub fn path_in_world(
        &self,
        start_in_world: Point2,
        goals_in_world: &[Point2],
    ) -> Result<Option<Vec<Point2>>, PlanError> {
        let Some(start) = self.geometry.cell_at(start_in_world) else {
            return Err(PlanError::StartOutsideMap {
                x_m: start_in_world.x,
                y_m: start_in_world.y,
                rows: self.geometry.rows,
                cols: self.geometry.cols,
                resolution_m: self.geometry.resolution_m,
            });
        };
        let Some(cells) = self.path(start) else { return Ok(None) };
        let last = cells[cells.len() - 1];
        let goal = goals_in_world
            .iter()
            .copied()
            .find(|&goal| self.geometry.cell_at(goal) == Some(last))
            .unwrap_or_else(|| self.geometry.center(last));
        let inner = cells.iter().skip(1).take(cells.len().saturating_sub(2));
        let mut points = vec![start_in_world];
        points.extend(inner.map(|&cell| self.geometry.center(cell)));
        points.push(goal);
        points.dedup();
        Ok(Some(points))
    }

    fn index(&self, cell: Cell) -> Option<usize> {
        (cell.row < self.geometry.rows && cell.col < self.geometry.cols).then(|| self.geometry.index(cell))
    }
}
