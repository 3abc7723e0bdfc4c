use crate::plan::moves::MOVES;
use crate::plan::{Cost, Field, GridPlanner, PlanError, PlanOptions};
use crate::world::{Cell, GridGeometry};

/// The cost of every move out of every cell: eight planes, (8, rows, cols), row-major.
///
/// Plane k holds the costs of the moves with code k (see [`MOVES`](crate::plan::MOVES)), each at the cell it leaves.
/// Infinity (for integers the largest value) is no such move; moves that leave the grid are not looked at.
/// Planes rather than eight numbers per cell: neighbouring cells of one plane are what one SIMD register holds.
#[derive(Clone, Copy, Debug)]
pub struct DirectionWeights<'a, T> {
    geometry: GridGeometry,
    planes: &'a [T],
}

impl<'a, T: Cost> DirectionWeights<'a, T> {
    /// Weights of a grid.
    ///
    /// # Errors
    /// [`PlanError::WeightCount`] unless there are 8 * rows * cols; [`WeightNan`](PlanError::WeightNan),
    /// [`WeightNegative`](PlanError::WeightNegative), [`WeightZero`](PlanError::WeightZero) with the first such
    /// weight (in the order of the planes), moves that leave the grid among them.
    pub fn new(geometry: GridGeometry, planes: &'a [T]) -> Result<Self, PlanError> {
        let GridGeometry { rows, cols, .. } = geometry;
        if planes.len() != 8 * geometry.len() {
            return Err(PlanError::WeightCount { weights: planes.len(), rows, cols });
        }
        let refused = |weight: &T| weight.is_nan() || *weight <= T::ZERO;
        if let Some(at) = planes.iter().position(refused) {
            let (code, Cell { row, col }) = (at / geometry.len(), geometry.cell(at % geometry.len()));
            let (weight, value) = (planes[at], planes[at].to_f64());
            return Err(if weight.is_nan() {
                PlanError::WeightNan { row, col, code, value }
            } else if weight < T::ZERO {
                PlanError::WeightNegative { row, col, code, value }
            } else {
                PlanError::WeightZero { row, col, code, value }
            });
        }
        Ok(Self { geometry, planes })
    }

    /// Shape and place of the grid.
    pub fn geometry(&self) -> &GridGeometry {
        &self.geometry
    }

    /// The costs of the moves with one code, row-major, each at the cell it leaves.
    pub fn plane(&self, code: usize) -> &'a [T] {
        &self.planes[code * self.geometry.len()..][..self.geometry.len()]
    }

    /// The least and the largest cost of a move that there is; (largest of the type, 0) without one.
    pub(super) fn extremes(&self) -> [T; 2] {
        self.planes.iter().fold([T::UNREACHABLE, T::ZERO], |[least, most], &cost| {
            let finite = if cost < T::UNREACHABLE { cost } else { T::ZERO };
            [if cost < least { cost } else { least }, if finite > most { finite } else { most }]
        })
    }

    /// The moves that exist, bit k of each cell for code k.
    pub fn allowed(&self) -> Vec<u8> {
        let GridGeometry { rows, cols, .. } = self.geometry;
        let mut allowed = vec![0_u8; self.geometry.len()];
        for (code, (down, right)) in MOVES.into_iter().enumerate() {
            let plane = self.plane(code);
            for row in 0..rows {
                if row.checked_add_signed(down).is_none_or(|row| row >= rows) {
                    continue;
                }
                let (first, last) = (usize::from(right < 0), cols - usize::from(right > 0));
                for index in row * cols + first..row * cols + last {
                    allowed[index] |= u8::from(plane[index] < T::UNREACHABLE) << code;
                }
            }
        }
        allowed
    }
}

/// The field of a grid of which every move has a cost of its own, in single precision, in the unit given.
///
/// The least fixed point of J(goal) = 0, J(n) = min over moves n -> m of c(n, m) + J(m), one rounded add per
/// move. A goal may lie anywhere. Corner cutting is not looked at: the weights say which moves there are.
///
/// # Errors
/// [`PlanError::EmptyGrid`], [`GridTooLarge`](PlanError::GridTooLarge), [`NoGoal`](PlanError::NoGoal),
/// [`GoalOutsideGrid`](PlanError::GoalOutsideGrid), [`NoThreads`](PlanError::NoThreads),
/// [`SimdNotAvailable`](PlanError::SimdNotAvailable), [`StartOutsideGrid`](PlanError::StartOutsideGrid);
/// [`LinkCostAbsorbed`](PlanError::LinkCostAbsorbed) and [`CostToGoOverflow`](PlanError::CostToGoOverflow)
/// where weights differ too much in size for f32.
pub fn plan_weights_f32(
    weights: &DirectionWeights<'_, f32>,
    goals: &[Cell],
    options: &PlanOptions,
) -> Result<Field, PlanError> {
    GridPlanner::default().plan_weights_f32(weights, goals, options)
}

/// [`plan_weights_f32`] in integers: u32, or u64 where a cost-to-go would not fit.
///
/// # Errors
/// As [`plan_weights_f32`], without the last two.
pub fn plan_weights_u32(
    weights: &DirectionWeights<'_, u32>,
    goals: &[Cell],
    options: &PlanOptions,
) -> Result<Field, PlanError> {
    GridPlanner::default().plan_weights_u32(weights, goals, options)
}
