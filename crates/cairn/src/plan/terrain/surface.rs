//! What is read off an elevation grid once: roughness, and the moves that each cell allows.

use crate::plan::PlanError;
use crate::plan::moves::MOVES;
use crate::plan::tiles::{Loops, at_widest};
use crate::world::{Cell, Grid, GridGeometry};

use super::link::runs;
use super::model::Limits;

/// The least and the largest of numbers, NaN left out; (inf, -inf) of none.
pub(super) fn range(values: &[f32]) -> [f32; 2] {
    at_widest(Range(values))
}

struct Range<'a>(&'a [f32]);

impl Loops for Range<'_> {
    type Result = [f32; 2];

    #[inline(always)]
    fn run(self) -> [f32; 2] {
        least_and_most(self.0)
    }
}

#[inline(always)]
fn least_and_most(values: &[f32]) -> [f32; 2] {
    const AT_ONCE: usize = 16;
    let (chunks, rest) = values.as_chunks::<AT_ONCE>();
    let (mut least, mut most) = ([f32::INFINITY; AT_ONCE], [f32::NEG_INFINITY; AT_ONCE]);
    for chunk in chunks {
        for i in 0..AT_ONCE {
            least[i] = if chunk[i] < least[i] { chunk[i] } else { least[i] };
            most[i] = if chunk[i] > most[i] { chunk[i] } else { most[i] };
        }
    }
    let least = least.iter().chain(rest).fold(f32::INFINITY, |least, &value| least.min(value));
    let most = most.iter().chain(rest).fold(f32::NEG_INFINITY, |most, &value| most.max(value));
    [least, most]
}

/// The range of elevations; refuses them if one is infinite. NaN is no data.
pub(super) fn check_elevation(elevation: &Grid<f32>) -> Result<[f32; 2], PlanError> {
    let [least, most] = range(&elevation.values);
    if least > f32::NEG_INFINITY && most < f32::INFINITY {
        return Ok([least, most]);
    }
    match elevation.values.iter().position(|height| height.is_infinite()) {
        Some(index) => {
            let Cell { row, col } = elevation.geometry.cell(index);
            Err(PlanError::ElevationInfinite { row, col, value: f64::from(elevation.values[index]) })
        }
        None => Ok([least, most]),
    }
}

/// The range of roughness; refuses it if it is of another shape, infinite or negative. NaN is no data.
pub(super) fn check_roughness(
    roughness: &Grid<f32>,
    elevation: &GridGeometry,
) -> Result<[f32; 2], PlanError> {
    let GridGeometry { rows, cols, .. } = roughness.geometry;
    if (rows, cols) != (elevation.rows, elevation.cols) {
        let (elevation_rows, elevation_cols) = (elevation.rows, elevation.cols);
        return Err(PlanError::RoughnessShape { rows, cols, elevation_rows, elevation_cols });
    }
    let [least, most] = range(&roughness.values);
    if !(least < 0.0 || most == f32::INFINITY) {
        return Ok([least, most]);
    }
    match roughness.values.iter().position(|&value| value < 0.0 || value == f32::INFINITY) {
        Some(index) => {
            let Cell { row, col } = elevation.cell(index);
            let value = f64::from(roughness.values[index]);
            Err(PlanError::RoughnessOutOfRange { row, col, value })
        }
        None => Ok([least, most]),
    }
}

/// Rows of a grid with a border of NaN, so that no loop asks where the grid ends.
struct Padded<'a> {
    values: &'a [f32],
    rows: usize,
    cols: usize,
}

impl<'a> Padded<'a> {
    #[inline(always)]
    fn new(geometry: &GridGeometry, values: &'a [f32]) -> Self {
        Self { values, rows: geometry.rows, cols: geometry.cols }
    }

    /// A line of only NaN.
    #[inline(always)]
    fn line(&self) -> Vec<f32> {
        vec![f32::NAN; self.cols + 2]
    }

    /// Copies a row between the two borders of `line`; a row outside is NaN.
    #[inline(always)]
    fn read(&self, row: Option<usize>, line: &mut [f32]) {
        let inner = &mut line[1..=self.cols];
        match row.filter(|&row| row < self.rows) {
            Some(row) => inner.copy_from_slice(&self.values[row * self.cols..][..self.cols]),
            None => inner.fill(f32::NAN),
        }
    }
}

/// Roughness of every cell, without unit: how far a cell lies off the middle of its opposite neighbours, over
/// the cell size. 0 on any plane; 0.1 where a cell of 1 m sticks out by 10 cm.
///
/// For each of the four pairs of opposite neighbours that have data (columns, main diagonal, rows, other
/// diagonal), e = h - (a + b) * 0.5; the roughness is sqrt(mean of e²) * (1 / cell size), the mean being the sum,
/// in that order, over the number of pairs, and 0 without any. All in f32, 1 / cell size rounded once.
/// Where there is no elevation it is NaN.
///
/// It measures what the grid shows: bumps of about a cell. Finer ones must be measured otherwise and given.
///
/// # Errors
/// [`PlanError::ElevationInfinite`], [`PlanError::CellSizeOutOfRange`].
pub fn roughness_of(elevation: &Grid<f32>) -> Result<Grid<f32>, PlanError> {
    Ok(Grid::new(elevation.geometry, roughness_in(Vec::new(), elevation)?))
}

/// [`roughness_of`] in memory that was used before.
pub(super) fn roughness_in(memory: Vec<f32>, elevation: &Grid<f32>) -> Result<Vec<f32>, PlanError> {
    check_elevation(elevation)?;
    let per_cell = (1.0 / super::model::checked_cell_size(elevation.geometry.resolution_m)?) as f32;
    Ok(at_widest(RoughnessOf { elevation, per_cell, memory }))
}

struct RoughnessOf<'a> {
    elevation: &'a Grid<f32>,
    per_cell: f32,
    memory: Vec<f32>,
}

impl Loops for RoughnessOf<'_> {
    type Result = Vec<f32>;

    #[inline(always)]
    fn run(self) -> Vec<f32> {
        let Self { elevation, per_cell, memory: mut values } = self;
        let grid = Padded::new(&elevation.geometry, &elevation.values);
        let cols = grid.cols;
        let (mut before, mut here, mut after) = (grid.line(), grid.line(), grid.line());
        values.resize(elevation.values.len(), 0.0);
        for row in 0..grid.rows {
            grid.read(row.checked_sub(1), &mut before);
            grid.read(Some(row), &mut here);
            grid.read(Some(row + 1), &mut after);
            let out = &mut values[row * cols..][..cols];
            let (b, h, a) = (&before[..cols + 2], &here[..cols + 2], &after[..cols + 2]);
            for col in 0..cols {
                let height = h[col + 1];
                let pairs = [
                    (h[col], h[col + 2]),
                    (b[col], a[col + 2]),
                    (b[col + 1], a[col + 1]),
                    (b[col + 2], a[col]),
                ];
                let (mut sum, mut count) = (0.0_f32, 0.0_f32);
                for (first, second) in pairs {
                    let off = height - (first + second) * 0.5;
                    let known = !off.is_nan();
                    sum += if known { off * off } else { 0.0 };
                    count += if known { 1.0 } else { 0.0 };
                }
                let most = if count > 1.0 { count } else { 1.0 };
                let rough = (sum / most).sqrt() * per_cell;
                out[col] = if height.is_nan() { f32::NAN } else { rough };
            }
        }
        values
    }
}

/// The limits in f32 for one cell size: tan(limit) * run in f64, rounded once, at most the largest f32.
#[derive(Clone, Copy)]
struct Bounds {
    climb: [f32; 2],
    descent: [f32; 2],
    /// Greatest difference of the heights to both sides, which are 2 cells (straight) or √2 (diagonal) apart.
    across: [f32; 2],
}

impl Bounds {
    fn new(limits: &Limits, cell_size_m: f64) -> Self {
        let [straight, diagonal] = runs(cell_size_m);
        let bound = |angle: f64, run: f64| {
            let free = angle >= std::f64::consts::FRAC_PI_2;
            if free { f32::MAX } else { ((angle.tan() * run) as f32).min(f32::MAX) }
        };
        Self {
            climb: [straight, diagonal].map(|run| bound(limits.climb_rad, run)),
            descent: [straight, diagonal].map(|run| bound(limits.descent_rad, run)),
            across: [2.0 * straight, diagonal].map(|run| bound(limits.roll_rad, run)),
        }
    }
}

impl Limits {
    /// No allowed move rises or falls by more \[m\].
    pub(super) fn steepest(&self, cell_size_m: f64) -> f32 {
        let Bounds { climb, descent, .. } = Bounds::new(self, cell_size_m);
        climb[1].max(descent[1])
    }
}

/// Whether the slope across a move stays within its bound.
///
/// `left`, `right`: heights to both sides of its middle, NaN where there is none; `middle`: its own height.
/// With only one side known the slope is taken from the middle to it, with none it counts as level.
#[inline(always)]
fn upright(left: f32, right: f32, middle: f32, bound: f32) -> bool {
    let (has_left, has_right) = (!left.is_nan(), !right.is_nan());
    let across = if has_left { left } else { middle } - if has_right { right } else { middle };
    let full = if has_left & has_right { across } else { across + across };
    full.abs() <= bound
}

/// The moves that each cell allows, bit k for code k of [`MOVES`]. They need not be allowed back.
///
/// A cell with neither elevation nor roughness, or rougher than the limit, is blocked: no move enters or leaves
/// it, and its height is not used below. A move from n to m is allowed if
///
/// * both are on the grid and not blocked, and for a diagonal one, unless corners may be cut, so are the two
///   cells beside it;
/// * its rise h(m) - h(n) is at most tan(climb limit) run and at least -tan(descent limit) run;
/// * the slope across it is at most tan(roll limit): straight, between the means (a + b) * 0.5 of the two cells to
///   its left and of those to its right, two cells apart (a side counts only if both its cells do); diagonal,
///   between the two cells beside it, √2 cells apart. Where one side is missing, twice the difference to the
///   middle (h(n) + h(m)) * 0.5 stands in; where both are, it is level.
///
/// They are written to `memory`, which may have been used before.
pub(super) fn allowed_moves(
    geometry: &GridGeometry,
    elevation: &[f32],
    roughness: Option<&[f32]>,
    limits: &Limits,
    corner_cutting: bool,
    memory: Vec<u8>,
) -> Vec<u8> {
    at_widest(AllowedMoves { geometry, elevation, roughness, limits, corner_cutting, memory })
}

struct AllowedMoves<'a> {
    geometry: &'a GridGeometry,
    elevation: &'a [f32],
    roughness: Option<&'a [f32]>,
    limits: &'a Limits,
    corner_cutting: bool,
    memory: Vec<u8>,
}

/// Reads a row of heights, NaN where it is rougher than `most`.
#[inline(always)]
fn read_known(
    heights: &Padded<'_>,
    rough: Option<&Padded<'_>>,
    most: f32,
    row: Option<usize>,
    scratch: &mut [f32],
    line: &mut [f32],
) {
    heights.read(row, line);
    let Some(rough) = rough else { return };
    rough.read(row, scratch);
    for (height, &rough) in line.iter_mut().zip(&*scratch) {
        *height = if rough <= most { *height } else { f32::NAN };
    }
}

impl Loops for AllowedMoves<'_> {
    type Result = Vec<u8>;

    #[inline(always)]
    fn run(self) -> Vec<u8> {
        let Self { geometry, elevation, roughness, limits, corner_cutting, memory: mut allowed } = self;
        let bounds = Bounds::new(limits, geometry.resolution_m);
        let most = limits.roughness as f32;
        let (heights, rough) =
            (Padded::new(geometry, elevation), roughness.map(|rough| Padded::new(geometry, rough)));
        let (rough, cols) = (rough.as_ref(), geometry.cols);
        let mut scratch = heights.line();
        let (mut before, mut here, mut after) = (heights.line(), heights.line(), heights.line());
        read_known(&heights, rough, most, Some(0), &mut scratch, &mut here);
        read_known(&heights, rough, most, Some(1), &mut scratch, &mut after);
        allowed.clear();
        allowed.resize(elevation.len(), 0);
        let mut backs = vec![0_u8; cols];
        for row in 0..geometry.rows {
            let (this, next) = allowed[row * cols..].split_at_mut(cols);
            let pairs =
                Pairs { before: &before, here: &here, after: &after, bounds: &bounds, corner_cutting };
            pairs.right(this, &mut backs);
            if row + 1 < geometry.rows {
                pairs.down(this, &mut next[..cols]);
                pairs.diagonal::<1>(this, &mut next[..cols]);
                pairs.diagonal::<-1>(this, &mut next[..cols]);
            }
            std::mem::swap(&mut before, &mut here);
            std::mem::swap(&mut here, &mut after);
            read_known(&heights, rough, most, Some(row + 2), &mut scratch, &mut after);
        }
        allowed
    }
}

/// Three padded rows: moves between cells of the middle one and those right of or below them, both ways.
struct Pairs<'a> {
    before: &'a [f32],
    here: &'a [f32],
    after: &'a [f32],
    bounds: &'a Bounds,
    corner_cutting: bool,
}

impl Pairs<'_> {
    /// (there, back): bits `code` and `code + 4` where a move that rises so is allowed that way.
    #[inline(always)]
    fn bits<const WAY: usize>(&self, rise: f32, fits: bool, code: u8) -> (u8, u8) {
        let (climb, descent) = (self.bounds.climb[WAY], self.bounds.descent[WAY]);
        let there = fits & (rise <= climb) & (-rise <= descent);
        let back = fits & (-rise <= climb) & (rise <= descent);
        ((there as u8) << code, (back as u8) << (code + 4))
    }

    /// Codes 0 and 4.
    #[inline(always)]
    fn right(&self, row: &mut [u8], backs: &mut [u8]) {
        let cols = row.len();
        let (b, h, a) = (&self.before[..cols + 2], &self.here[..cols + 2], &self.after[..cols + 2]);
        let backs = &mut backs[..cols];
        for col in 0..cols {
            let (n, m) = (h[col + 1], h[col + 2]);
            let (left, right) = ((a[col + 1] + a[col + 2]) * 0.5, (b[col + 1] + b[col + 2]) * 0.5);
            let fits = upright(left, right, (n + m) * 0.5, self.bounds.across[0]);
            let (there, back) = self.bits::<0>(m - n, fits, 0);
            row[col] |= there;
            backs[col] = back;
        }
        // Apart from the loop above, so that none of its steps waits for the one before.
        for (cell, back) in row[1..].iter_mut().zip(&*backs) {
            *cell |= back;
        }
    }

    /// Codes 2 and 6.
    #[inline(always)]
    fn down(&self, row: &mut [u8], below: &mut [u8]) {
        let cols = row.len();
        let (h, a) = (&self.here[..cols + 2], &self.after[..cols + 2]);
        for col in 0..cols {
            let (n, m) = (h[col + 1], a[col + 1]);
            let (left, right) = ((h[col] + a[col]) * 0.5, (h[col + 2] + a[col + 2]) * 0.5);
            let fits = upright(left, right, (n + m) * 0.5, self.bounds.across[0]);
            let (there, back) = self.bits::<0>(m - n, fits, 2);
            row[col] |= there;
            below[col] |= back;
        }
    }

    /// Codes 1 and 5 to the right (`SIDE` 1), or 3 and 7 to the left (-1).
    #[inline(always)]
    fn diagonal<const SIDE: isize>(&self, row: &mut [u8], below: &mut [u8]) {
        let cols = row.len();
        let (h, a) = (&self.here[..cols + 2], &self.after[..cols + 2]);
        // `far` is the column of the cell below and to the side, `near` of the one above it.
        let (shift_near, shift_far, code) = if SIDE == 1 { (0, 1, 1) } else { (1, 0, 3) };
        debug_assert_eq!(MOVES[code as usize].1, SIDE);
        for pair in 0..cols - 1 {
            let (near, far) = (pair + shift_near, pair + shift_far);
            let (n, m) = (h[near + 1], a[far + 1]);
            let (left, right) = (h[far + 1], a[near + 1]);
            let free = self.corner_cutting | !(left.is_nan() | right.is_nan());
            let fits = free & upright(left, right, (n + m) * 0.5, self.bounds.across[1]);
            let (there, back) = self.bits::<1>(m - n, fits, code);
            row[near] |= there;
            below[far] |= back;
        }
    }
}
