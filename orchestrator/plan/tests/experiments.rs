//! Experiments become the cells they say, and mistakes in them are placed and answered.
#![allow(clippy::unwrap_used)]

use plan::{EXPERIMENTS, Plan, ProfileText};

fn builtin(name: &str) -> Result<ProfileText, String> {
    link::Profile::builtin(name)
        .map(|source| ProfileText {
            source: source.to_owned(),
            ..ProfileText::default()
        })
        .ok_or_else(|| format!("there is no topology `{name}`"))
}

fn resolve(source: &str) -> Result<Plan, plan::Misfit> {
    Plan::resolve(source, "mine.toml", None, builtin)
}

#[test]
fn every_experiment_that_the_binary_carries_resolves() {
    for (name, source) in EXPERIMENTS {
        let plan = Plan::resolve(source, name, None, builtin).unwrap();
        assert_eq!(plan.experiment, *name);
        assert!(
            plan.cells
                .iter()
                .enumerate()
                .all(|(i, cell)| cell.index == i)
        );
    }
}

#[test]
fn smoke_is_five_topologies_by_three_rates_and_paper_adds_the_slow_rates_and_repeats() {
    let cells = |name: &str| {
        let (_, source) = EXPERIMENTS.iter().find(|(n, _)| *n == name).unwrap();
        resolve(source).unwrap().cells.len()
    };
    assert_eq!(cells("smoke"), 5 * 3);
    // Open loop at 3.3, 10 and 100 Hz, and twenty unit steps at 333 Hz and 1 kHz.
    assert_eq!(cells("paper"), 5 * 3 + 5 * 2 * 20);
}

#[test]
fn cells_of_one_topology_and_repeat_share_the_link_whatever_their_rate_and_mode() {
    let plan = resolve(EXPERIMENTS[0].1).unwrap();
    let seeds = |topology: &str| {
        let mut seeds: Vec<_> = plan
            .cells
            .iter()
            .filter(|cell| cell.topology == topology)
            .map(|cell| cell.link_seed)
            .collect();
        seeds.dedup();
        seeds
    };
    assert_eq!(seeds("couva").len(), 1);
    assert_ne!(seeds("couva"), seeds("diego-vpn"));
}

#[test]
fn a_plan_survives_its_json() {
    let plan = resolve(EXPERIMENTS[0].1).unwrap();
    assert_eq!(Plan::from_json(&plan.to_json()).unwrap(), plan);
}

#[test]
fn keeping_a_pattern_keeps_indices_and_drops_unused_profiles() {
    let mut plan = resolve(EXPERIMENTS[0].1).unwrap();
    let whole = plan.clone();
    plan.keep(&["couva*closed".to_owned() + "*"]);
    assert_eq!(plan.cells.len(), 2);
    assert_eq!(plan.profiles.len(), 1);
    for cell in &plan.cells {
        assert_eq!(whole.cell(cell.index), Some(cell));
    }
}

#[test]
fn a_mistake_is_placed_and_answered() {
    let block = |line: &str| {
        format!(
            "name = \"mine\"\n[[cells]]\ntopology = [\"arima\"]\nclient = [\"native\"]\n{line}\n"
        )
    };
    let mistakes = [
        (
            "unknown topology",
            block("mode = \"open\"\nh = [\"1ms\"]\nduration = \"1s\"").replace("arima", "atlantis"),
        ),
        (
            "unknown client",
            block("mode = \"open\"\nh = [\"1ms\"]\nduration = \"1s\"")
                .replace("native", "netscape"),
        ),
        (
            "unknown mode",
            block("mode = \"ajar\"\nh = [\"1ms\"]\nduration = \"1s\""),
        ),
        (
            "h of zero",
            block("mode = \"open\"\nh = [\"0ms\"]\nduration = \"1s\""),
        ),
        (
            "h without unit",
            block("mode = \"open\"\nh = [\"3\"]\nduration = \"1s\""),
        ),
        (
            "negative duration",
            block("mode = \"open\"\nh = [\"3ms\"]\nduration = \"-1s\""),
        ),
        (
            "h longer than the run",
            block("mode = \"open\"\nh = [\"3s\"]\nduration = \"1s\""),
        ),
        (
            "unknown key",
            block("mode = \"open\"\nh = [\"3ms\"]\nduration = \"1s\"\ncolour = 3"),
        ),
        ("missing key", block("mode = \"open\"\nh = [\"3ms\"]")),
        (
            "no repeats",
            block("mode = \"open\"\nh = [\"3ms\"]\nduration = \"1s\"\nrepeats = 0"),
        ),
        (
            "too many cells",
            block("mode = \"open\"\nh = [\"3ms\"]\nduration = \"1s\"\nrepeats = 4000000000"),
        ),
        (
            "the same cell twice",
            block("mode = \"open\"\nh = [\"3ms\", \"3ms\"]\nduration = \"1s\""),
        ),
        (
            "outstanding of zero",
            block("mode = \"open\"\nh = [\"3ms\"]\nduration = \"1s\"\noutstanding = \"0\""),
        ),
        ("not TOML", "name = ".to_owned()),
        ("no cells", "name = \"mine\"".to_owned()),
        (
            "a name that is a path",
            "name = \"../../etc\"\n[[cells]]".to_owned(),
        ),
    ];
    let answers: Vec<_> = mistakes
        .iter()
        .map(|(what, source)| format!("{what}:\n  {}", resolve(source).unwrap_err()))
        .collect();
    insta::assert_snapshot!(answers.join("\n"));
}
