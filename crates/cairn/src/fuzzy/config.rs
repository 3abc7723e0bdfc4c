use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::FuzzySet;

/// A fuzzy system as a person writes it; [`super::FuzzySystem::new`] checks it.
///
/// ```toml
/// and = "product"
/// [inputs.alpha1]
/// range = [0.0, 3.141593]
/// sets.Straight1 = { left_shoulder = [0.15, 0.7] }
/// sets.High1 = { right_shoulder = [0.15, 0.7] }
/// [outputs.C]
/// NoCurvature = 0.0
/// cHigh = 3.5
/// [[rules]]
/// when = { alpha1 = "Straight1" }
/// then = { C = "NoCurvature" }
/// [[rules]]
/// when = { alpha1 = "High1" }
/// then = { C = "cHigh" }
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FuzzyConfig {
    /// How the conditions of one rule are joined.
    #[serde(default)]
    pub and: And,
    /// Inputs by name.
    pub inputs: BTreeMap<String, FuzzyInput>,
    /// Singletons by name, of each output by name; rules may also name a number itself.
    pub outputs: BTreeMap<String, BTreeMap<String, f64>>,
    /// Rules written one by one.
    #[serde(default)]
    pub rules: Vec<FuzzyRule>,
    /// Rules written as tables; every cell is a rule.
    #[serde(default)]
    pub tables: Vec<FuzzyTable>,
}

/// How the memberships in the conditions of a rule make its strength.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum And {
    /// Their product: smooth surfaces.
    #[default]
    Product,
    /// The least of them.
    Minimum,
}

/// One input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FuzzyInput {
    /// Values covered; beyond, the input is taken at the nearer end.
    pub range: [f64; 2],
    /// Membership functions by name.
    pub sets: BTreeMap<String, FuzzySet>,
}

/// One set name, or several of which each makes a rule of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum AnyOf {
    /// `"Near"`
    One(String),
    /// `["Near", "Middle"]`
    Several(Vec<String>),
}

impl AnyOf {
    /// The names, in the order written.
    pub fn names(&self) -> &[String] {
        match self {
            Self::One(name) => std::slice::from_ref(name),
            Self::Several(names) => names,
        }
    }
}

/// What a rule says of an output: a singleton by its name, or the number itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Singleton {
    /// `0.35`
    Number(f64),
    /// `"Easy"`
    Named(String),
}

impl std::fmt::Display for Singleton {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(value) => write!(f, "{value}"),
            Self::Named(name) => f.write_str(name),
        }
    }
}

/// `when` every named input is in its set, `then` each named output is its singleton.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FuzzyRule {
    /// Set by input; an input left out does not matter, an empty condition always holds.
    #[serde(default)]
    pub when: BTreeMap<String, AnyOf>,
    /// Singleton by output.
    pub then: BTreeMap<String, Singleton>,
    /// Factor on the strength, above 0.
    #[serde(default = "one")]
    pub weight: f64,
}

/// Rules for one output over the sets of two inputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FuzzyTable {
    /// Conditions that all cells share.
    #[serde(default)]
    pub when: BTreeMap<String, AnyOf>,
    /// Output that the cells name singletons of.
    pub output: String,
    /// Input whose sets name the rows.
    pub rows: String,
    /// Input whose sets name the columns.
    pub columns: String,
    /// Singleton by row and column.
    pub cells: BTreeMap<String, BTreeMap<String, Singleton>>,
}

const fn one() -> f64 {
    1.0
}

impl FuzzyConfig {
    /// All rules in one list: those written as rules, then those of the tables; one set per input.
    pub(super) fn single_rules(&self) -> Vec<SingleRule> {
        let mut rules = Vec::new();
        for rule in &self.rules {
            for when in combinations(&rule.when) {
                rules.push(SingleRule { when, then: rule.then.clone(), weight: rule.weight });
            }
        }
        for table in &self.tables {
            for shared in combinations(&table.when) {
                for (row, cells) in &table.cells {
                    for (column, singleton) in cells {
                        let mut when = shared.clone();
                        when.insert(table.rows.clone(), row.clone());
                        when.insert(table.columns.clone(), column.clone());
                        let then = BTreeMap::from([(table.output.clone(), singleton.clone())]);
                        rules.push(SingleRule { when, then, weight: 1.0 });
                    }
                }
            }
        }
        rules
    }
}

/// A rule with one set per input, names not yet looked up.
pub(super) struct SingleRule {
    pub when: BTreeMap<String, String>,
    pub then: BTreeMap<String, Singleton>,
    pub weight: f64,
}

impl SingleRule {
    /// The rule as a sentence: `if dR Near and dtheta Left then omega TurnLeft`.
    pub fn sentence(&self) -> String {
        if self.when.is_empty() {
            format!("always {}", joined(&self.then))
        } else {
            format!("if {} then {}", joined(&self.when), joined(&self.then))
        }
    }
}

fn joined(pairs: &BTreeMap<String, impl std::fmt::Display>) -> String {
    pairs.iter().map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>().join(" and ")
}

fn combinations(when: &BTreeMap<String, AnyOf>) -> Vec<BTreeMap<String, String>> {
    let mut combined = vec![BTreeMap::new()];
    for (input, sets) in when {
        combined = combined
            .iter()
            .flat_map(|so_far| {
                sets.names().iter().map(move |set| {
                    let mut longer = so_far.clone();
                    longer.insert(input.clone(), set.clone());
                    longer
                })
            })
            .collect();
    }
    combined
}
