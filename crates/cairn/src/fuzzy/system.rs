use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::config::SingleRule;
use super::{And, FuzzyConfig, FuzzyError, FuzzySet, Singleton};

/// Most combinations of breakpoints whose coverage is checked.
const MOST_CORNERS: usize = 200_000;

/// A checked zero-order Sugeno system; inputs and outputs are in order of their names.
#[derive(Clone, Debug)]
pub struct FuzzySystem {
    and: And,
    inputs: Vec<Input>,
    outputs: Vec<String>,
    rules: Vec<Rule>,
}

#[derive(Clone, Debug)]
struct Input {
    name: String,
    range: [f64; 2],
    sets: Vec<(String, FuzzySet)>,
}

#[derive(Clone, Debug)]
struct Rule {
    sentence: String,
    when: Vec<(usize, usize)>,
    then: Vec<(usize, f64)>,
    weight: f64,
}

/// What a system made of its inputs, everything by name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Evaluation {
    /// Output values.
    pub outputs: BTreeMap<String, f64>,
    /// Degrees in [0, 1], by input and set.
    pub memberships: BTreeMap<String, BTreeMap<String, f64>>,
    /// Strengths of the rules that fired, by the rule as a sentence.
    pub rules: BTreeMap<String, f64>,
}

impl FuzzySystem {
    /// Checks `config` and makes it ready to run.
    ///
    /// # Errors
    /// A [`FuzzyError`] names the first thing that is wrong: an unknown name, breakpoints that do not
    /// rise, a number that is not one, a rule written twice, or a place inside the ranges where no
    /// rule fires for some output.
    pub fn new(config: &FuzzyConfig) -> Result<Self, FuzzyError> {
        let inputs = checked_inputs(config)?;
        checked_outputs(config)?;
        let outputs: Vec<String> = config.outputs.keys().cloned().collect();
        let mut rules = Vec::new();
        let mut seen = BTreeSet::new();
        for rule in config.single_rules() {
            let rule = looked_up(&rule, config, &inputs, &outputs)?;
            if !seen.insert(rule.sentence.clone()) {
                return Err(FuzzyError::FuzzyRuleRepeated { rule: rule.sentence });
            }
            rules.push(rule);
        }
        let system = Self { and: config.and, inputs, outputs, rules };
        system.check_coverage()?;
        Ok(system)
    }

    /// Names of the inputs, in the order that [`Self::evaluate`] takes them.
    pub fn input_names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.inputs.iter().map(|input| input.name.as_str())
    }

    /// Names of the outputs, in the order that [`Self::outputs`] gives them.
    pub fn output_names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.outputs.iter().map(String::as_str)
    }

    /// Place of the input called `name`.
    pub fn input_index(&self, name: &str) -> Option<usize> {
        self.inputs.iter().position(|input| input.name == name)
    }

    /// Place of the output called `name`.
    pub fn output_index(&self, name: &str) -> Option<usize> {
        self.outputs.iter().position(|output| output == name)
    }

    /// Output values, in order of name, for input values, in order of name; beyond its range an input
    /// counts as the nearer end.
    ///
    /// # Errors
    /// [`FuzzyError::FuzzyInputsMismatch`] and [`FuzzyError::FuzzyInputNotFinite`].
    pub fn outputs(&self, values: &[f64]) -> Result<Vec<f64>, FuzzyError> {
        let memberships = self.memberships(values)?;
        Ok(self.weighted_means(&self.strengths(&memberships)))
    }

    /// As [`Self::outputs`], with memberships and rule strengths by name.
    ///
    /// # Errors
    /// As [`Self::outputs`].
    pub fn evaluate(&self, values: &[f64]) -> Result<Evaluation, FuzzyError> {
        let memberships = self.memberships(values)?;
        let strengths = self.strengths(&memberships);
        let outputs = self.outputs.iter().cloned().zip(self.weighted_means(&strengths)).collect();
        let rules = self
            .rules
            .iter()
            .zip(&strengths)
            .filter(|&(_, &strength)| strength > 0.0)
            .map(|(rule, &strength)| (rule.sentence.clone(), strength))
            .collect();
        let memberships = self
            .inputs
            .iter()
            .zip(memberships)
            .map(|(input, degrees)| {
                let by_set = input.sets.iter().map(|(name, _)| name.clone()).zip(degrees).collect();
                (input.name.clone(), by_set)
            })
            .collect();
        Ok(Evaluation { outputs, memberships, rules })
    }

    fn memberships(&self, values: &[f64]) -> Result<Vec<Vec<f64>>, FuzzyError> {
        if values.len() != self.inputs.len() {
            let known = self.input_names().collect::<Vec<_>>().join(", ");
            return Err(FuzzyError::FuzzyInputsMismatch { given: values.len(), known });
        }
        self.inputs
            .iter()
            .zip(values)
            .map(|(input, &value)| {
                if !value.is_finite() {
                    return Err(FuzzyError::FuzzyInputNotFinite { input: input.name.clone(), value });
                }
                let value = value.clamp(input.range[0], input.range[1]);
                Ok(input.sets.iter().map(|(_, set)| set.membership(value)).collect())
            })
            .collect()
    }

    fn strengths(&self, memberships: &[Vec<f64>]) -> Vec<f64> {
        let degree = |&(input, set): &(usize, usize)| memberships[input][set];
        self.rules
            .iter()
            .map(|rule| {
                rule.weight
                    * match self.and {
                        And::Product => rule.when.iter().map(degree).product::<f64>(),
                        And::Minimum => rule.when.iter().map(degree).fold(1.0, f64::min),
                    }
            })
            .collect()
    }

    /// Sum of the strengths behind each output.
    fn total_strengths(&self, strengths: &[f64]) -> Vec<f64> {
        let mut totals = vec![0.0; self.outputs.len()];
        for (rule, strength) in self.rules.iter().zip(strengths) {
            for &(output, _) in &rule.then {
                totals[output] += strength;
            }
        }
        totals
    }

    fn weighted_means(&self, strengths: &[f64]) -> Vec<f64> {
        let totals = self.total_strengths(strengths);
        let mut means = vec![0.0; self.outputs.len()];
        for (rule, strength) in self.rules.iter().zip(strengths) {
            for &(output, singleton) in &rule.then {
                means[output] += strength / totals[output] * singleton;
            }
        }
        means
    }

    /// Strengths are checked where breakpoints of all inputs meet, which is everywhere: between
    /// these corners memberships are linear, so the total strength of product rules is the
    /// multilinear mean of the corners' totals, and minimum rules are never weaker than product ones.
    fn check_coverage(&self) -> Result<(), FuzzyError> {
        let corners: Vec<Vec<f64>> = self.inputs.iter().map(Input::corners).collect();
        let count = corners.iter().fold(1usize, |count, values| count.saturating_mul(values.len()));
        if count > MOST_CORNERS {
            return Err(FuzzyError::FuzzySystemTooLarge { corners: count, most: MOST_CORNERS });
        }
        for corner in 0..count {
            let mut rest = corner;
            let values: Vec<f64> = corners
                .iter()
                .map(|values| {
                    let value = values[rest % values.len()];
                    rest /= values.len();
                    value
                })
                .collect();
            let totals = self.total_strengths(&self.strengths(&self.memberships(&values)?));
            if let Some(output) = totals.iter().position(|&total| total < 1e-6) {
                let place = self.inputs.iter().zip(&values).map(|(input, v)| format!("{} = {v}", input.name));
                return Err(FuzzyError::FuzzyRulesLeaveGap {
                    output: self.outputs[output].clone(),
                    place: place.collect::<Vec<_>>().join(", "),
                });
            }
        }
        Ok(())
    }
}

impl Input {
    /// Ends of the range and the breakpoints between them, rising.
    fn corners(&self) -> Vec<f64> {
        let [low, high] = self.range;
        let inside = self.sets.iter().flat_map(|(_, set)| set.breakpoints()).copied();
        let mut corners: Vec<f64> = inside.filter(|&x| low < x && x < high).chain([low, high]).collect();
        corners.sort_by(f64::total_cmp);
        corners.dedup();
        corners
    }
}

fn empty(missing: impl Into<String>) -> FuzzyError {
    FuzzyError::FuzzySystemEmpty { missing: missing.into() }
}

fn checked_inputs(config: &FuzzyConfig) -> Result<Vec<Input>, FuzzyError> {
    if config.inputs.is_empty() {
        return Err(empty("inputs"));
    }
    let mut inputs = Vec::new();
    for (name, input) in &config.inputs {
        let [low, high] = input.range;
        if !(low.is_finite() && high.is_finite() && low < high) {
            return Err(FuzzyError::FuzzyRangeNotRising { input: name.clone(), low, high });
        }
        if input.sets.is_empty() {
            return Err(empty(format!("sets for input `{name}`")));
        }
        for (set_name, set) in &input.sets {
            if !set.is_valid() {
                return Err(FuzzyError::FuzzySetNotRising {
                    input: name.clone(),
                    set: set_name.clone(),
                    breakpoints: set.breakpoints().to_vec(),
                });
            }
        }
        let sets = input.sets.iter().map(|(name, &set)| (name.clone(), set)).collect();
        inputs.push(Input { name: name.clone(), range: input.range, sets });
    }
    Ok(inputs)
}

fn checked_outputs(config: &FuzzyConfig) -> Result<(), FuzzyError> {
    if config.outputs.is_empty() {
        return Err(empty("outputs"));
    }
    for (output, singletons) in &config.outputs {
        for (name, &value) in singletons {
            if !value.is_finite() {
                let place = format!("singleton `{name}` of output `{output}`");
                return Err(FuzzyError::FuzzyNumberInvalid { place, value, more: String::new() });
            }
        }
    }
    Ok(())
}

fn looked_up(
    rule: &SingleRule,
    config: &FuzzyConfig,
    inputs: &[Input],
    outputs: &[String],
) -> Result<Rule, FuzzyError> {
    let sentence = rule.sentence();
    let unknown = |kind: &str, name: &str, known: Vec<&str>| FuzzyError::FuzzyNameUnknown {
        kind: kind.to_owned(),
        name: name.to_owned(),
        place: format!("rule `{sentence}`"),
        known: known.join(", "),
    };
    if rule.then.is_empty() {
        return Err(empty(format!("output in rule `{sentence}`")));
    }
    if !(rule.weight.is_finite() && rule.weight > 0.0) {
        let place = format!("weight of rule `{sentence}`");
        return Err(FuzzyError::FuzzyNumberInvalid {
            place,
            value: rule.weight,
            more: " above 0".to_owned(),
        });
    }
    let mut when = Vec::new();
    for (input_name, set_name) in &rule.when {
        let names = || inputs.iter().map(|input| input.name.as_str()).collect();
        let i = inputs
            .iter()
            .position(|input| input.name == *input_name)
            .ok_or_else(|| unknown("input", input_name, names()))?;
        let sets = &inputs[i].sets;
        let names = || sets.iter().map(|(name, _)| name.as_str()).collect();
        let set = sets
            .iter()
            .position(|(name, _)| name == set_name)
            .ok_or_else(|| unknown("set", set_name, names()))?;
        when.push((i, set));
    }
    let mut then = Vec::new();
    for (output_name, singleton) in &rule.then {
        let names = || outputs.iter().map(String::as_str).collect();
        let output = outputs
            .iter()
            .position(|name| name == output_name)
            .ok_or_else(|| unknown("output", output_name, names()))?;
        let singletons = &config.outputs[output_name];
        let names = || singletons.keys().map(String::as_str).collect();
        let value = match singleton {
            Singleton::Named(name) => {
                *singletons.get(name).ok_or_else(|| unknown("singleton", name, names()))?
            }
            Singleton::Number(value) if value.is_finite() => *value,
            Singleton::Number(value) => {
                let place = format!("output `{output_name}` in rule `{sentence}`");
                return Err(FuzzyError::FuzzyNumberInvalid { place, value: *value, more: String::new() });
            }
        };
        then.push((output, value));
    }
    Ok(Rule { sentence, when, then, weight: rule.weight })
}
