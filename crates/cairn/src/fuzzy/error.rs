use serde::Serialize;
use thiserror::Error;

/// Why a fuzzy system, or an input to it, was refused.
#[derive(Clone, Debug, PartialEq, Error, Serialize)]
pub enum FuzzyError {
    /// A rule names something that the system does not have.
    #[error("{place}: there is no {kind} `{name}`; there are {known}")]
    FuzzyNameUnknown {
        /// `input`, `set`, `output` or `singleton`.
        kind: String,
        /// What was written.
        name: String,
        /// The rule it stands in.
        place: String,
        /// What could have been written.
        known: String,
    },
    /// Breakpoints of a set do not rise, or are not finite.
    #[error("set `{set}` of input `{input}`: breakpoints {breakpoints:?} must be finite and rise")]
    FuzzySetNotRising {
        /// Input of the set.
        input: String,
        /// The set.
        set: String,
        /// As written.
        breakpoints: Vec<f64>,
    },
    /// The range of an input is empty or not finite.
    #[error("input `{input}`: range {low}..{high} must be finite and rise")]
    FuzzyRangeNotRising {
        /// The input.
        input: String,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// A singleton is not a finite number, or a weight not a finite number above 0.
    #[error("{place}: {value} must be a finite number{more}")]
    FuzzyNumberInvalid {
        /// `output.singleton`, or the rule.
        place: String,
        /// What was written.
        value: f64,
        /// What else it must be.
        more: String,
    },
    /// There are no inputs, outputs, sets, singletons or rules where there must be some.
    #[error("the fuzzy system has no {missing}")]
    FuzzySystemEmpty {
        /// What is missing.
        missing: String,
    },
    /// One rule stands there twice.
    #[error("rule `{rule}` stands there twice")]
    FuzzyRuleRepeated {
        /// The rule.
        rule: String,
    },
    /// Inside the declared ranges there is a place where no rule says anything of an output.
    #[error("no rule fires for output `{output}` at {place}; add a rule or widen a set")]
    FuzzyRulesLeaveGap {
        /// The output.
        output: String,
        /// `input = value` of the place.
        place: String,
    },
    /// Too many inputs and sets to check that rules leave no gap.
    #[error("{corners} combinations of breakpoints are too many, at most {most}; use fewer sets or inputs")]
    FuzzySystemTooLarge {
        /// Combinations of breakpoints.
        corners: usize,
        /// Most that are checked.
        most: usize,
    },
    /// An input was not given a finite number.
    #[error("input `{input}` is {value}, must be a finite number")]
    FuzzyInputNotFinite {
        /// The input.
        input: String,
        /// What was given.
        value: f64,
    },
    /// Not as many inputs were given as the system has.
    #[error("{given} inputs given, the system has {known}")]
    FuzzyInputsMismatch {
        /// Inputs given.
        given: usize,
        /// Names of the inputs, in order.
        known: String,
    },
}
