use std::borrow::Cow;

use crate::plan::PlanError;
use crate::plan::moves::MOVES;
use crate::world::{Grid, GridGeometry};

use super::link::{LinkCost, P3atEnergyLinks, P3atTimeLinks, ToblerLinks};
use super::model::{TerrainModel, checked_cell_size};
use super::surface::{allowed_moves, check_elevation, check_roughness, range, roughness_in};

/// The links of a terrain, ready to be priced on the fly by any engine.
///
/// Cells that no move enters or leaves may hold NaN in `elevation` and `roughness`; `allowed` says which moves
/// count, and only those may be priced.
#[derive(Clone, Debug)]
pub struct TerrainLinks<'a, M> {
    /// Shape and cell size.
    pub geometry: GridGeometry,
    /// Heights \[m\], row-major.
    pub elevation: &'a [f32],
    /// Roughness, row-major; empty if neither the model nor its limit uses it.
    pub roughness: Cow<'a, [f32]>,
    /// Rougher cells are blocked.
    pub max_roughness: f32,
    /// No cell is rougher; 0 without roughness.
    pub roughest: f32,
    /// Bit k: the move with code k out of the cell is allowed (it need not be, back).
    pub allowed: Vec<u8>,
    /// No allowed move rises or falls by more \[m\].
    pub steepest: f32,
    /// What a move costs.
    pub model: M,
}

impl<M: LinkCost> TerrainLinks<'_, M> {
    /// Costs of the eight moves out of a cell, by code; infinite where a move is not allowed.
    #[inline]
    pub fn costs_from(&self, index: usize) -> [f32; 8] {
        let allowed = self.allowed[index];
        std::array::from_fn(
            |code| if allowed >> code & 1 == 1 { self.cost(index, code) } else { f32::INFINITY },
        )
    }

    /// Whether a cell can be neither entered nor left: no data, or too rough.
    pub fn is_blocked(&self, index: usize) -> bool {
        let rough = self.roughness.get(index).copied().unwrap_or(0.0);
        self.elevation[index].is_nan() || rough.is_nan() || rough > self.max_roughness
    }

    /// Bounds below and above the costs of allowed moves.
    pub(super) fn extremes(&self) -> [f32; 2] {
        [self.model.least(), self.model.most(self.steepest, self.roughest)]
    }

    /// Cost of an allowed move.
    #[inline]
    pub fn cost(&self, index: usize, code: usize) -> f32 {
        let (down, right) = MOVES[code];
        let to = index.wrapping_add_signed(down * self.geometry.cols as isize + right);
        let rise = self.elevation[to] - self.elevation[index];
        let rough = |at: usize| if M::USES_ROUGHNESS { self.roughness[at] } else { 0.0 };
        if code % 2 == 1 {
            self.model.link::<true>(rise, rough(index), rough(to))
        } else {
            self.model.link::<false>(rise, rough(index), rough(to))
        }
    }
}

/// [`TerrainLinks`] of whichever model was asked for.
#[derive(Clone, Debug)]
pub enum AnyTerrainLinks<'a> {
    /// Energy of a P3-AT.
    P3atEnergy(TerrainLinks<'a, P3atEnergyLinks>),
    /// Time of a P3-AT.
    P3atTime(TerrainLinks<'a, P3atTimeLinks>),
    /// Time on foot.
    Tobler(TerrainLinks<'a, ToblerLinks>),
}

/// Runs an expression with `$links` bound to the links of whichever model it is.
macro_rules! with_links {
    ($any:expr, $links:ident => $body:expr) => {
        match $any {
            AnyTerrainLinks::P3atEnergy($links) => $body,
            AnyTerrainLinks::P3atTime($links) => $body,
            AnyTerrainLinks::Tobler($links) => $body,
        }
    };
}
pub(super) use with_links;

/// Memory for what is read off a terrain, kept from one plan to the next.
#[derive(Debug, Default)]
pub struct TerrainRoom {
    allowed: Vec<u8>,
    roughness: Vec<f32>,
}

impl<'a> AnyTerrainLinks<'a> {
    /// Checks elevation \[m\], roughness and model, and finds the allowed moves. Without `roughness` it is read
    /// off the elevation ([`roughness_of`](super::roughness_of)) where the model or its limits use it. The cell size is the
    /// resolution of `elevation`.
    ///
    /// # Errors
    /// [`PlanError::EmptyGrid`], [`CellSizeOutOfRange`](PlanError::CellSizeOutOfRange), [`TerrainValueOutOfRange`](PlanError::TerrainValueOutOfRange),
    /// [`ElevationInfinite`](PlanError::ElevationInfinite), [`RoughnessShape`](PlanError::RoughnessShape),
    /// [`RoughnessOutOfRange`](PlanError::RoughnessOutOfRange).
    pub fn new(
        elevation: &'a Grid<f32>,
        roughness: Option<&'a Grid<f32>>,
        model: &TerrainModel,
        corner_cutting: bool,
    ) -> Result<Self, PlanError> {
        Self::new_in(&mut TerrainRoom::default(), elevation, roughness, model, corner_cutting)
    }

    /// As [`new`](Self::new), in memory to be [given back](Self::give_back).
    pub(super) fn new_in(
        room: &mut TerrainRoom,
        elevation: &'a Grid<f32>,
        roughness: Option<&'a Grid<f32>>,
        model: &TerrainModel,
        corner_cutting: bool,
    ) -> Result<Self, PlanError> {
        let geometry = elevation.geometry;
        let GridGeometry { rows, cols, .. } = geometry;
        if geometry.is_empty() {
            return Err(PlanError::EmptyGrid { rows, cols });
        }
        let size = checked_cell_size(geometry.resolution_m)?;
        model.check()?;
        let [lowest, highest] = check_elevation(elevation)?;
        let given_range = roughness.map(|given| check_roughness(given, &geometry)).transpose()?;
        let limits = model.limits();
        let priced = !matches!(model, TerrainModel::Tobler(_));
        let roughness: Cow<'a, [f32]> = match roughness {
            Some(given) => Cow::Borrowed(&given.values),
            None if priced || limits.roughness < f64::INFINITY => {
                Cow::Owned(roughness_in(std::mem::take(&mut room.roughness), elevation)?)
            }
            None => Cow::Borrowed(&[]),
        };
        let roughest = given_range.unwrap_or_else(|| range(&roughness))[1].max(0.0);
        let known = (!roughness.is_empty()).then_some(&*roughness);
        let memory = std::mem::take(&mut room.allowed);
        let allowed = allowed_moves(&geometry, &elevation.values, known, &limits, corner_cutting, memory);
        let elevation = elevation.values.as_slice();
        let max_roughness = limits.roughness as f32;
        let steepest = limits.steepest(size).min((highest - lowest).max(0.0));
        macro_rules! links {
            ($model:expr) => {
                TerrainLinks {
                    geometry,
                    elevation,
                    roughness,
                    max_roughness,
                    roughest,
                    allowed,
                    steepest,
                    model: $model,
                }
            };
        }
        Ok(match model {
            TerrainModel::P3atEnergy(p) => Self::P3atEnergy(links!(P3atEnergyLinks::new(p, size))),
            TerrainModel::P3atTime(p) => Self::P3atTime(links!(P3atTimeLinks::new(p, size))),
            TerrainModel::Tobler(p) => Self::Tobler(links!(ToblerLinks::new(p, size))),
        })
    }
}

impl AnyTerrainLinks<'_> {
    /// Leaves memory for the next terrain.
    pub(super) fn give_back(self, room: &mut TerrainRoom) {
        with_links!(self, links => {
            room.allowed = links.allowed;
            if let Cow::Owned(roughness) = links.roughness {
                room.roughness = roughness;
            }
        });
    }

    /// The allowed moves: bit k of each cell for the move with code k out of it.
    pub fn into_allowed(self) -> Vec<u8> {
        with_links!(self, links => links.allowed)
    }
}
