//! What moving over terrain costs, in figures that a person can check: parameters and their sources.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use serde::{Deserialize, Serialize};

use crate::plan::PlanError;

/// The steepest grade of a P3-AT, 35 %, as an angle \[rad\].
const P3AT_GRADE_RAD: f64 = 0.336_674_819_386_727_2;

/// A Pioneer P3-AT on natural ground; energy and time of a move share these parameters.
///
/// Over a horizontal run x, a rise z (falls are negative) and roughness ρ, with m = `mass_kg` + `payload_kg`:
///
/// * work of the motors against gravity and the ground  W = m g (z + (μ + κ ρ) x)   \[J\], the friction and
///   gravity model of \[Rowe90\] and \[Sun05\]: weight across the slope times μ is m g μ x whatever the slope;
/// * time  T = max(l (1 + σ ρ) / v, W / P)   \[s\], l = √(x² + z²) the way along the slope: the speed is the
///   greatest one v, less on rough ground, and no more than the drive's power P allows;
/// * energy from the battery  E = H T + max(W, 0) / η   \[J\]: what electronics take while it lasts, and the
///   drive's work over its efficiency. Nothing is won back downhill.
///
/// Turning is not priced: a cell of the field has no heading.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct P3at {
    /// Mass with one battery \[kg\]: 12, Webots' guide to the Pioneer 3-AT.
    pub mass_kg: f64,
    /// What it carries \[kg\]; the same guide allows 12 on a floor.
    pub payload_kg: f64,
    /// g \[m/s²\].
    pub gravity_mps2: f64,
    /// μ: rolling resistance over weight. 0.08 on medium hard soil; 0.01 on asphalt, 0.04 on loose gravel,
    /// 0.1 to 0.2 on sand \[Carvill93\].
    pub rolling_resistance: f64,
    /// κ: what roughness adds to μ. 1: every bump's height is climbed and braked away behind it (ours).
    pub roughness_resistance: f64,
    /// v: greatest speed \[m/s\]: 0.7, datasheet.
    pub max_speed_mps: f64,
    /// σ: how roughness slows. 5: ground with bumps a fifth as high as they are long halves the speed (ours).
    pub roughness_slowdown: f64,
    /// P: mechanical power of the drive \[W\]. Not published; 20 (ours) gives full speed up to a grade of 16 % and
    /// 0.42 m/s at 35 %; climbing on then empties three batteries (259 Wh) in 3.7 h, the guide says 2 to 4 h.
    pub drive_power_w: f64,
    /// η: work at the wheels over energy from the battery. Not published; 0.5 (ours).
    pub drive_efficiency: f64,
    /// H: power of computer, sensors and electronics \[W\]. Not published; 30 (ours). \[Mei05\] found that on a
    /// Pioneer 3-DX motion takes less than half of all power.
    pub hotel_power_w: f64,
    /// Steepest way up \[rad\]: 35 %, Webots' guide. π/2 is no limit.
    pub max_climb_rad: f64,
    /// Steepest way down \[rad\]: as up. π/2 is no limit.
    pub max_descent_rad: f64,
    /// Steepest slope across the way \[rad\]: as up, far from tipping (ours). π/2 is no limit.
    pub max_roll_rad: f64,
    /// Roughest ground that may be entered; infinite is no limit.
    pub max_roughness: f64,
}

impl Default for P3at {
    fn default() -> Self {
        Self {
            mass_kg: 12.0,
            payload_kg: 0.0,
            gravity_mps2: 9.80665,
            rolling_resistance: 0.08,
            roughness_resistance: 1.0,
            max_speed_mps: 0.7,
            roughness_slowdown: 5.0,
            drive_power_w: 20.0,
            drive_efficiency: 0.5,
            hotel_power_w: 30.0,
            max_climb_rad: P3AT_GRADE_RAD,
            max_descent_rad: P3AT_GRADE_RAD,
            max_roll_rad: P3AT_GRADE_RAD,
            max_roughness: f64::INFINITY,
        }
    }
}

/// A person on foot: Tobler's hiking function \[Tobler93\].
///
/// Walking speed is 6 exp(-3.5 |s + 0.05|) km/h on footpaths, s the rise over the horizontal run; off the path
/// it is 3/5 of that. 5.04 km/h on the level, at most 6 km/h, where the way falls by 5 %. A move takes its
/// horizontal run over that speed \[s\]. Roughness plays no part but for its limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Tobler {
    /// Whether to walk off the path, at 3/5 of the speed.
    pub off_path: bool,
    /// Steepest way up \[rad\]. π/4 (ours), 33 times slower than the level; π/2 is no limit.
    pub max_climb_rad: f64,
    /// Steepest way down \[rad\]: as up.
    pub max_descent_rad: f64,
    /// Steepest slope across the way \[rad\]. π/2: no limit.
    pub max_roll_rad: f64,
    /// Roughest ground that may be entered; infinite is no limit.
    pub max_roughness: f64,
}

impl Default for Tobler {
    fn default() -> Self {
        Self {
            off_path: false,
            max_climb_rad: FRAC_PI_4,
            max_descent_rad: FRAC_PI_4,
            max_roll_rad: FRAC_PI_2,
            max_roughness: f64::INFINITY,
        }
    }
}

/// What a move over terrain costs and which moves are allowed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum TerrainModel {
    /// Energy of a P3-AT \[J\].
    P3atEnergy(P3at),
    /// Time of a P3-AT \[s\].
    P3atTime(P3at),
    /// Time of a person on foot \[s\].
    Tobler(Tobler),
}

/// Steepest slopes \[rad\] and roughest ground that a model allows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limits {
    pub climb_rad: f64,
    pub descent_rad: f64,
    pub roll_rad: f64,
    pub roughness: f64,
}

/// Sizes that are told apart from nonsense and keep every constant of a model inside f32.
const POSITIVE: (f64, f64) = (1e-6, 1e6);
const NOT_NEGATIVE: (f64, f64) = (0.0, 1e6);
const ANGLE: (f64, f64) = (0.0, FRAC_PI_2);

impl TerrainModel {
    pub(super) fn limits(&self) -> Limits {
        match *self {
            Self::P3atEnergy(p) | Self::P3atTime(p) => Limits {
                climb_rad: p.max_climb_rad,
                descent_rad: p.max_descent_rad,
                roll_rad: p.max_roll_rad,
                roughness: p.max_roughness,
            },
            Self::Tobler(t) => Limits {
                climb_rad: t.max_climb_rad,
                descent_rad: t.max_descent_rad,
                roll_rad: t.max_roll_rad,
                roughness: t.max_roughness,
            },
        }
    }

    /// Checks every parameter.
    ///
    /// # Errors
    /// [`PlanError::TerrainValueOutOfRange`] names the first that is not usable.
    pub fn check(&self) -> Result<(), PlanError> {
        let mut parameters = Vec::new();
        if let Self::P3atEnergy(p) | Self::P3atTime(p) = self {
            parameters.extend([
                ("mass_kg", p.mass_kg, POSITIVE),
                ("payload_kg", p.payload_kg, NOT_NEGATIVE),
                ("gravity_mps2", p.gravity_mps2, POSITIVE),
                ("rolling_resistance", p.rolling_resistance, NOT_NEGATIVE),
                ("roughness_resistance", p.roughness_resistance, NOT_NEGATIVE),
                ("max_speed_mps", p.max_speed_mps, POSITIVE),
                ("roughness_slowdown", p.roughness_slowdown, NOT_NEGATIVE),
                ("drive_power_w", p.drive_power_w, POSITIVE),
                ("drive_efficiency", p.drive_efficiency, (1e-6, 1.0)),
                ("hotel_power_w", p.hotel_power_w, POSITIVE),
            ]);
        }
        let limits = self.limits();
        parameters.extend([
            ("max_climb_rad", limits.climb_rad, ANGLE),
            ("max_descent_rad", limits.descent_rad, ANGLE),
            ("max_roll_rad", limits.roll_rad, ANGLE),
            ("max_roughness", limits.roughness, (0.0, f64::INFINITY)),
        ]);
        match parameters.into_iter().find(|&(_, value, (least, most))| !(least <= value && value <= most)) {
            Some((key, value, (least, most))) => {
                Err(PlanError::TerrainValueOutOfRange { key: key.to_owned(), value, least, most })
            }
            None => Ok(()),
        }
    }
}

/// Refuses a cell size outside 1 mm to 1000 km, or NaN.
pub(super) fn checked_cell_size(cell_size_m: f64) -> Result<f64, PlanError> {
    let (least, most) = (1e-3, 1e6);
    if least <= cell_size_m && cell_size_m <= most {
        Ok(cell_size_m)
    } else {
        Err(PlanError::CellSizeOutOfRange { value: cell_size_m, least, most })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_models_are_valid_and_the_grade_is_35_per_cent() {
        for model in [
            TerrainModel::P3atEnergy(P3at::default()),
            TerrainModel::P3atTime(P3at::default()),
            TerrainModel::Tobler(Tobler::default()),
        ] {
            model.check().unwrap();
        }
        assert!((P3AT_GRADE_RAD - 0.35_f64.atan()).abs() < 1e-15);
    }

    #[test]
    fn a_parameter_that_is_not_usable_is_named() {
        let nan = P3at { drive_power_w: f64::NAN, ..P3at::default() };
        let error = TerrainModel::P3atTime(nan).check().unwrap_err();
        assert!(matches!(error, PlanError::TerrainValueOutOfRange { ref key, .. } if key == "drive_power_w"));
        let steep = Tobler { max_roll_rad: 1.6, ..Tobler::default() };
        let error = TerrainModel::Tobler(steep).check().unwrap_err();
        assert!(matches!(error, PlanError::TerrainValueOutOfRange { ref key, .. } if key == "max_roll_rad"));
    }
}
