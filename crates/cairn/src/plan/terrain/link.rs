//! The cost of one move, branch-free in plain f32, so that loops over it become SIMD of any width with the
//! same bits: sums, products, one square root, comparisons; nothing fused, nothing from a maths library.
//!
//! Constants are computed from the parameters in f64 and rounded once to f32; after that every operation
//! below is rounded to f32 as written. `run` is the cell size for straight and √2 of it for diagonal moves.

use std::f64::consts::{LOG2_E, SQRT_2};

use super::exp2::exp2;
use super::model::{P3at, Tobler};

/// What one move costs.
pub trait LinkCost: Copy + Send + Sync {
    /// Whether roughness enters the cost; if not, its arguments are not looked at.
    const USES_ROUGHNESS: bool;

    /// Cost of a move that rises by `rise_m` (> 0 up) between cells of these roughnesses; > 0.
    ///
    /// Meant for moves that are allowed; for others it gives some value or NaN, and never traps.
    fn link<const DIAGONAL: bool>(&self, rise_m: f32, roughness_from: f32, roughness_to: f32) -> f32;

    /// A bound below every link's cost, > 0.
    fn least(&self) -> f32;

    /// A bound above the costs of links that rise or fall by at most `rise_m` between cells no rougher.
    fn most(&self, rise_m: f32, roughness: f32) -> f32 {
        let straight = self.link::<false>(rise_m, roughness, roughness);
        1.001 * larger(straight, self.link::<true>(rise_m, roughness, roughness))
    }
}

/// Horizontal lengths of a straight and a diagonal move \[m\].
pub(super) fn runs(cell_size_m: f64) -> [f64; 2] {
    [cell_size_m, cell_size_m * SQRT_2]
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// [`P3at`] for one cell size. With r = roughness_from + roughness_to:
///
/// ```text
/// work   = weight * rise + (drag + rough_drag * r)              weight = m g, drag = m g μ run, rough_drag = 0.5 m g κ run
/// length = sqrt(run2 + rise * rise)                             run2 = run run
/// time   = max(length * (pace + rough_pace * r), work * per_power)   pace = 1/v, rough_pace = 0.5 σ/v, per_power = 1/P
/// ```
#[derive(Clone, Copy, Debug)]
struct Drive {
    weight: f32,
    drag: [f32; 2],
    rough_drag: [f32; 2],
    run2: [f32; 2],
    pace: f32,
    rough_pace: f32,
    per_power: f32,
}

impl Drive {
    fn new(p: &P3at, cell_size_m: f64) -> Self {
        let weight = (p.mass_kg + p.payload_kg) * p.gravity_mps2;
        let runs = runs(cell_size_m);
        Self {
            weight: weight as f32,
            drag: runs.map(|run| (weight * p.rolling_resistance * run) as f32),
            rough_drag: runs.map(|run| (0.5 * weight * p.roughness_resistance * run) as f32),
            run2: runs.map(|run| (run * run) as f32),
            pace: (1.0 / p.max_speed_mps) as f32,
            rough_pace: (0.5 * p.roughness_slowdown / p.max_speed_mps) as f32,
            per_power: (1.0 / p.drive_power_w) as f32,
        }
    }

    /// (work \[J\], time \[s\]).
    #[inline(always)]
    fn work_and_time<const DIAGONAL: bool>(&self, rise_m: f32, from: f32, to: f32) -> (f32, f32) {
        let way = DIAGONAL as usize;
        let rough = from + to;
        let work = self.weight * rise_m + (self.drag[way] + self.rough_drag[way] * rough);
        let length = (self.run2[way] + rise_m * rise_m).sqrt();
        let time = larger(length * (self.pace + self.rough_pace * rough), work * self.per_power);
        (work, time)
    }

    fn least_time(&self) -> f32 {
        self.run2[0].sqrt() * self.pace
    }
}

/// Time of a P3-AT \[s\], see [`P3at`].
#[derive(Clone, Copy, Debug)]
pub struct P3atTimeLinks(Drive);

impl P3atTimeLinks {
    /// For cells of this size \[m\].
    pub fn new(parameters: &P3at, cell_size_m: f64) -> Self {
        Self(Drive::new(parameters, cell_size_m))
    }
}

impl LinkCost for P3atTimeLinks {
    const USES_ROUGHNESS: bool = true;

    #[inline(always)]
    fn link<const DIAGONAL: bool>(&self, rise_m: f32, roughness_from: f32, roughness_to: f32) -> f32 {
        self.0.work_and_time::<DIAGONAL>(rise_m, roughness_from, roughness_to).1
    }

    fn least(&self) -> f32 {
        self.0.least_time()
    }
}

/// Energy of a P3-AT \[J\], see [`P3at`]: `hotel * time + effort * max(work, 0)`, effort = 1/η.
#[derive(Clone, Copy, Debug)]
pub struct P3atEnergyLinks {
    drive: Drive,
    hotel: f32,
    effort: f32,
}

impl P3atEnergyLinks {
    /// For cells of this size \[m\].
    pub fn new(parameters: &P3at, cell_size_m: f64) -> Self {
        Self {
            drive: Drive::new(parameters, cell_size_m),
            hotel: parameters.hotel_power_w as f32,
            effort: (1.0 / parameters.drive_efficiency) as f32,
        }
    }
}

impl LinkCost for P3atEnergyLinks {
    const USES_ROUGHNESS: bool = true;

    #[inline(always)]
    fn link<const DIAGONAL: bool>(&self, rise_m: f32, roughness_from: f32, roughness_to: f32) -> f32 {
        let (work, time) = self.drive.work_and_time::<DIAGONAL>(rise_m, roughness_from, roughness_to);
        self.hotel * time + self.effort * larger(work, 0.0)
    }

    fn least(&self) -> f32 {
        self.hotel * self.drive.least_time()
    }
}

/// Time on foot \[s\], see [`Tobler`]: `base * 2^|rise * per_rise + offset|` by [`exp2`], with
/// base = 0.6 run / factor (6 km/h are 0.6 s/m; the factor is 1, off the path 0.6),
/// per_rise = 3.5 log2(e) / run, offset = 3.5 log2(e) 0.05.
#[derive(Clone, Copy, Debug)]
pub struct ToblerLinks {
    base: [f32; 2],
    per_rise: [f32; 2],
    offset: f32,
}

impl ToblerLinks {
    /// For cells of this size \[m\].
    pub fn new(parameters: &Tobler, cell_size_m: f64) -> Self {
        let factor = if parameters.off_path { 0.6 } else { 1.0 };
        let runs = runs(cell_size_m);
        Self {
            base: runs.map(|run| (0.6 * run / factor) as f32),
            per_rise: runs.map(|run| (3.5 * LOG2_E / run) as f32),
            offset: (3.5 * LOG2_E * 0.05) as f32,
        }
    }
}

impl LinkCost for ToblerLinks {
    const USES_ROUGHNESS: bool = false;

    #[inline(always)]
    fn link<const DIAGONAL: bool>(&self, rise_m: f32, _roughness_from: f32, _roughness_to: f32) -> f32 {
        let way = DIAGONAL as usize;
        self.base[way] * exp2((rise_m * self.per_rise[way] + self.offset).abs())
    }

    fn least(&self) -> f32 {
        0.999 * self.base[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kmh(model: &Tobler, slope: f64) -> f64 {
        let links = ToblerLinks::new(model, 10.0);
        let straight = 10.0 / f64::from(links.link::<false>((slope * 10.0) as f32, 0.0, 0.0)) * 3.6;
        let run = 10.0 * SQRT_2;
        let diagonal = run / f64::from(links.link::<true>((slope * run) as f32, 0.0, 0.0)) * 3.6;
        assert!((straight / diagonal - 1.0).abs() < 1e-6);
        straight
    }

    #[test]
    fn toblers_speeds_are_those_published() {
        let path = Tobler::default();
        assert!((kmh(&path, -0.05) - 6.0).abs() < 1e-5);
        assert!((kmh(&path, 0.0) - 5.0367).abs() < 1e-4);
        // Slope [deg], speed [km/h] of the table usually printed with the function.
        for (degrees, speed) in [
            (-50.0, 0.11),
            (-40.0, 0.38),
            (-30.0, 0.95),
            (-25.0, 1.40),
            (-20.0, 2.00),
            (-15.0, 2.80),
            (-10.0, 3.86),
            (-5.0, 5.26),
            (0.0, 5.04),
            (1.0, 4.74),
            (5.0, 3.71),
            (10.0, 2.72),
            (15.0, 1.97),
            (20.0, 1.41),
            (25.0, 0.98),
            (30.0, 0.67),
            (40.0, 0.27),
            (50.0, 0.08_f64),
        ] {
            let slope = f64::to_radians(degrees).tan();
            assert!((kmh(&path, slope) - speed).abs() < 0.0051, "{degrees}");
            let off = kmh(&Tobler { off_path: true, ..path }, slope);
            assert!((off / kmh(&path, slope) - 0.6).abs() < 1e-6);
        }
    }

    #[test]
    fn toblers_function_is_met_within_a_millionth_up_to_45_degrees() {
        let links = ToblerLinks::new(&Tobler::default(), 30.0);
        for i in -3000..=3000 {
            let rise = i as f32 * 0.01;
            let exact = 0.6 * 30.0 * (3.5 * (f64::from(rise) / 30.0 + 0.05).abs()).exp();
            let cost = f64::from(links.link::<false>(rise, 0.0, 0.0));
            assert!((cost / exact - 1.0).abs() < 1e-6, "{rise}");
        }
    }

    #[test]
    fn a_p3at_takes_what_the_formula_says_worked_by_hand() {
        let p = P3at::default();
        let (time, energy) = (P3atTimeLinks::new(&p, 10.0), P3atEnergyLinks::new(&p, 10.0));
        let near = |a: f32, b: f64| assert!((f64::from(a) / b - 1.0).abs() < 1e-5, "{a} {b}");
        // Level: 10 m at 0.7 m/s; 117.6798 N x 0.08 x 10 m.
        near(time.link::<false>(0.0, 0.0, 0.0), 14.285_714);
        near(energy.link::<false>(0.0, 0.0, 0.0), 30.0 * 14.285_714 + 94.143_84 / 0.5);
        // 30 % up: 117.6798 x (3 + 0.8) = 447.18324 J at 20 W.
        near(time.link::<false>(3.0, 0.0, 0.0), 22.359_162);
        near(energy.link::<false>(3.0, 0.0, 0.0), 30.0 * 22.359_162 + 447.183_24 / 0.5);
        // 30 % down: the brakes hold; sqrt(109) m at 0.7 m/s.
        near(time.link::<false>(-3.0, 0.0, 0.0), 14.914_723);
        near(energy.link::<false>(-3.0, 0.0, 0.0), 30.0 * 14.914_723);
        // Roughness 0.2 halves the speed and adds 0.2 to the resistance.
        near(time.link::<false>(0.0, 0.2, 0.2), 28.571_429);
        near(energy.link::<false>(0.0, 0.2, 0.2), 30.0 * 28.571_429 + 117.6798 * 2.8 / 0.5);
        near(energy.link::<true>(0.0, 0.0, 0.0), SQRT_2 * (30.0 * 14.285_714 + 94.143_84 / 0.5));
    }
}
