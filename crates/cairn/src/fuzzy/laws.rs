//! What every fuzzy system keeps to, and hand computations.

use proptest::prelude::*;

use super::*;

const SPEED: &str = r#"
[inputs.distance]
range = [0.0, 2.0]
sets.Near = { left_shoulder = [0.2, 1.0] }
sets.Far = { right_shoulder = [0.2, 1.0] }
[inputs.turn]
range = [0.0, 3.0]
sets.Straight = { left_shoulder = [0.0, 1.0] }
sets.Sharp = { right_shoulder = [0.0, 1.0] }
[outputs.speed]
Slow = 0.1
Middle = 0.4
Fast = 0.7
[outputs.horn]
Silent = 0.0
Loud = 1.0
[[tables]]
output = "speed"
rows = "distance"
columns = "turn"
cells.Near = { Straight = "Middle", Sharp = "Slow" }
cells.Far = { Straight = "Fast", Sharp = "Middle" }
[[rules]]
then = { horn = "Silent" }
[[rules]]
when = { turn = "Sharp" }
then = { horn = "Loud" }
weight = 3.0
"#;

fn config(text: &str) -> FuzzyConfig {
    toml::from_str(text).expect("parses")
}

fn system(text: &str) -> FuzzySystem {
    FuzzySystem::new(&config(text)).expect("is valid")
}

fn refusal(text: &str) -> FuzzyError {
    FuzzySystem::new(&config(text)).expect_err("is refused")
}

#[test]
fn the_output_is_the_weighted_mean_worked_out_by_hand() {
    // distance 0.4: Near 0.75, Far 0.25; turn 0.2: Straight 0.8, Sharp 0.2. Outputs: horn, speed.
    let speed = 0.75 * 0.8 * 0.4 + 0.75 * 0.2 * 0.1 + 0.25 * 0.8 * 0.7 + 0.25 * 0.2 * 0.4;
    let horn = 3.0 * 0.2 * 1.0 / (1.0 + 3.0 * 0.2);
    let found = system(SPEED).outputs(&[0.4, 0.2]).expect("finite");
    assert!((found[1] - speed).abs() < 1e-12 && (found[0] - horn).abs() < 1e-12, "{found:?}");

    let minimum = format!("and = \"minimum\"\n{SPEED}");
    let strengths = [0.75, 0.2, 0.25, 0.2];
    let speed = (0.75 * 0.4 + 0.2 * 0.1 + 0.25 * 0.7 + 0.2 * 0.4) / strengths.iter().sum::<f64>();
    let found = system(&minimum).outputs(&[0.4, 0.2]).expect("finite");
    assert!((found[1] - speed).abs() < 1e-12, "{found:?}");
}

#[test]
fn an_evaluation_names_memberships_and_the_rules_that_fired() {
    let seen = system(SPEED).evaluate(&[0.4, 0.0]).expect("finite");
    assert!((seen.memberships["distance"]["Near"] - 0.75).abs() < 1e-12);
    assert_eq!(seen.memberships["turn"]["Sharp"], 0.0);
    let rules: Vec<&str> = seen.rules.keys().map(String::as_str).collect();
    assert_eq!(
        rules,
        [
            "always horn Silent",
            "if distance Far and turn Straight then speed Fast",
            "if distance Near and turn Straight then speed Middle",
        ]
    );
    assert!((seen.outputs["speed"] - 0.475).abs() < 1e-12);
}

#[test]
fn several_sets_in_a_condition_are_a_rule_each() {
    let short = config(SPEED);
    let mut long = short.clone();
    long.tables.clear();
    for (distance, turn, speed) in [
        ("Near", "Straight", "Middle"),
        ("Near", "Sharp", "Slow"),
        ("Far", "Straight", "Fast"),
        ("Far", "Sharp", "Middle"),
    ] {
        let one = |name: &str| AnyOf::Several(vec![name.to_owned()]);
        long.rules.push(FuzzyRule {
            when: [("distance".to_owned(), one(distance)), ("turn".to_owned(), one(turn))].into(),
            then: [("speed".to_owned(), Singleton::Named(speed.to_owned()))].into(),
            weight: 1.0,
        });
    }
    let (short, long) = (FuzzySystem::new(&short).expect("valid"), FuzzySystem::new(&long).expect("valid"));
    assert_eq!(short.evaluate(&[0.5, 0.5]), long.evaluate(&[0.5, 0.5]));
}

#[test]
fn a_number_in_a_rule_is_a_singleton_without_a_name() {
    let named = system(SPEED);
    let mut text = SPEED.to_owned();
    for (name, number) in [("Slow", "0.1"), ("Middle", "0.4"), ("Fast", "0.7"), ("Loud", "1")] {
        text = text.replace(&format!("\"{name}\""), number).replace(&format!("{name} = {number}\n"), "");
    }
    let numbered = system(&text);
    for inputs in [[0.0, 0.0], [0.4, 0.2], [0.7, 0.9], [2.0, 3.0]] {
        assert_eq!(named.outputs(&inputs), numbered.outputs(&inputs));
    }
    let seen = numbered.evaluate(&[0.4, 0.0]).expect("finite");
    assert!(seen.rules.contains_key("if distance Far and turn Straight then speed 0.7"), "{seen:?}");
    let said = refusal(&text.replace("Straight = 0.7", "Straight = nan")).to_string();
    assert!(said.contains("output `speed` in rule"), "{said}");
}

#[test]
fn mistakes_in_a_file_are_refused_by_name() {
    let refused = |from: &str, to: &str| {
        assert!(SPEED.contains(from), "{from}");
        refusal(&SPEED.replace(from, to)).to_string()
    };
    for (from, to, says) in [
        ("when = { turn = \"Sharp\" }", "when = { trun = \"Sharp\" }", "no input `trun`"),
        ("when = { turn = \"Sharp\" }", "when = { turn = \"Shrap\" }", "no set `Shrap`"),
        ("{ horn = \"Loud\" }", "{ hron = \"Loud\" }", "no output `hron`"),
        ("{ horn = \"Loud\" }", "{ horn = \"Luod\" }", "no singleton `Luod`"),
        ("right_shoulder = [0.2, 1.0]", "right_shoulder = [1.0, 0.2]", "set `Far` of input `distance`"),
        ("right_shoulder = [0.2, 1.0]", "right_shoulder = [0.2, nan]", "set `Far` of input `distance`"),
        ("range = [0.0, 3.0]", "range = [3.0, 3.0]", "input `turn`: range"),
        ("Middle = 0.4", "Middle = inf", "singleton `Middle` of output `speed`"),
        ("weight = 3.0", "weight = 0.0", "weight of rule `if turn Sharp then horn Loud`"),
        ("when = { turn = \"Sharp\" }", "when = { turn = [\"Sharp\", \"Sharp\"] }", "stands there twice"),
        (
            "[[rules]]\nthen = { horn = \"Silent\" }",
            "",
            "no rule fires for output `horn` at distance = 0, turn = 0",
        ),
        ("right_shoulder = [0.2, 1.0]", "right_shoulder = [1.0, 1.5]", "no rule fires for output `speed`"),
    ] {
        let said = refused(from, to);
        assert!(said.contains(says), "{to}: {said}");
    }
    assert!(toml::from_str::<FuzzyConfig>(&SPEED.replace("weight", "wieght")).is_err());
}

#[test]
fn inputs_that_are_no_numbers_or_too_few_are_refused_by_name() {
    let system = system(SPEED);
    let said = system.outputs(&[0.1, f64::NAN]).expect_err("NaN").to_string();
    assert!(said.contains("`turn` is NaN"), "{said}");
    let said = system.outputs(&[0.1]).expect_err("one input").to_string();
    assert!(said.contains("distance, turn"), "{said}");
}

proptest! {
    #[test]
    fn outputs_stay_between_singletons_and_change_smoothly(d in -1.0..4.0f64, t in -1.0..4.0f64, minimum: bool) {
        let and = if minimum { "minimum" } else { "product" };
        let system = system(&format!("and = \"{and}\"\n{SPEED}"));
        let here = system.outputs(&[d, t]).expect("finite");
        prop_assert!((0.1 - 1e-12..=0.7 + 1e-12).contains(&here[1]) && (0.0..=1.0).contains(&here[0]));
        let beside = system.outputs(&[d + 1e-6, t - 1e-6]).expect("finite");
        prop_assert!((here[0] - beside[0]).abs() < 1e-5 && (here[1] - beside[1]).abs() < 1e-5);
        let ends = [d.clamp(0.0, 2.0), t.clamp(0.0, 3.0)];
        prop_assert_eq!(here, system.outputs(&ends).expect("finite"));
    }

    #[test]
    fn a_system_that_is_accepted_fires_everywhere(
        points in prop::collection::vec(0.0..1.0f64, 4), x in 0.0..1.0f64, minimum: bool,
    ) {
        let [a, b, c, d] = points[..] else { unreachable!() };
        let text = format!(
            "and = \"{}\"\n[inputs.x]\nrange = [0.0, 1.0]\nsets.A = {{ left_shoulder = [{a}, {b}] }}\n\
             sets.B = {{ right_shoulder = [{c}, {d}] }}\n[outputs.y]\nOne = 1.0\nTwo = 2.0\n\
             [[rules]]\nwhen = {{ x = \"A\" }}\nthen = {{ y = \"One\" }}\n\
             [[rules]]\nwhen = {{ x = \"B\" }}\nthen = {{ y = \"Two\" }}\n",
            if minimum { "minimum" } else { "product" },
        );
        match FuzzySystem::new(&config(&text)) {
            Ok(system) => {
                let y = system.outputs(&[x]).expect("finite")[0];
                prop_assert!((1.0 - 1e-12..=2.0 + 1e-12).contains(&y));
            }
            Err(FuzzyError::FuzzyRulesLeaveGap { .. }) => prop_assert!(b <= c + 2e-6),
            Err(FuzzyError::FuzzySetNotRising { .. }) => prop_assert!(a >= b || c >= d),
            Err(other) => prop_assert!(false, "{other}"),
        }
    }
}
