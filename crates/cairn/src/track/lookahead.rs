use super::{TrackError, Waypoints};
use crate::fuzzy::{Evaluation, FuzzyConfig, FuzzySystem};

/// The first module of the controller: turns at the next two waypoints → look-ahead curvature C in
/// [0, 5] `[Maalouf06 §4, Table 1]`.
#[derive(Clone, Debug)]
pub struct LookAhead {
    system: FuzzySystem,
}

impl LookAhead {
    /// A system with inputs `alpha1`, `alpha2` and output `C`.
    ///
    /// # Errors
    /// [`TrackError::ControllerInvalid`], [`TrackError::ControllerMismatch`].
    pub fn new(config: &FuzzyConfig) -> Result<Self, TrackError> {
        Ok(Self { system: system_with("look_ahead", config, &["alpha1", "alpha2"], &["C"])? })
    }

    /// (α1, α2): absolute turns at N_{i+1} and N_{i+2}, in [0, π], 0 past the end \[rad\].
    pub fn angles(waypoints: &Waypoints, index: usize) -> (f64, f64) {
        (waypoints.turn_rad(index + 1), waypoints.turn_rad(index + 2))
    }

    /// C and how it came about.
    ///
    /// # Errors
    /// [`TrackError::ControllerInvalid`] when an angle is not a finite number.
    pub fn curvature(&self, alpha1_rad: f64, alpha2_rad: f64) -> Result<(f64, Evaluation), TrackError> {
        let evaluation = self
            .system
            .evaluate(&[alpha1_rad, alpha2_rad])
            .map_err(|cause| TrackError::ControllerInvalid { system: "look_ahead".to_owned(), cause })?;
        Ok((evaluation.outputs["C"], evaluation))
    }

    /// The fuzzy system itself.
    pub fn system(&self) -> &FuzzySystem {
        &self.system
    }
}

/// A system whose inputs and outputs are exactly those named, both in order of name.
pub(super) fn system_with(
    name: &str,
    config: &FuzzyConfig,
    inputs: &[&str],
    outputs: &[&str],
) -> Result<FuzzySystem, TrackError> {
    let system = FuzzySystem::new(config)
        .map_err(|cause| TrackError::ControllerInvalid { system: name.to_owned(), cause })?;
    let found_inputs: Vec<&str> = system.input_names().collect();
    let found_outputs: Vec<&str> = system.output_names().collect();
    for (kind, found, needed) in [("inputs", found_inputs, inputs), ("outputs", found_outputs, outputs)] {
        if found != needed {
            return Err(TrackError::ControllerMismatch {
                system: name.to_owned(),
                kind: kind.to_owned(),
                found: found.join(", "),
                needed: needed.join(", "),
            });
        }
    }
    Ok(system)
}
