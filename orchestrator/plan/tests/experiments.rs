//! Experiments become the cells they say, and mistakes in them are placed and answered.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;

use endpoint::Mode;
use plan::{Client, EXPERIMENTS, Instead, Plan, ProfileText, Selection};

fn builtin(name: &str) -> Result<ProfileText, String> {
    link::Profile::builtin(name)
        .map(|source| ProfileText {
            source: source.to_owned(),
            ..ProfileText::default()
        })
        .ok_or_else(|| format!("there is no topology `{name}`"))
}

fn resolve(source: &str) -> Result<Plan, plan::Misfit> {
    Plan::resolve(source, "mine.toml", &Instead::default(), builtin)
}

#[test]
fn every_experiment_that_the_binary_carries_resolves() {
    for (name, source) in EXPERIMENTS {
        let plan = Plan::resolve(source, name, &Instead::default(), builtin).unwrap();
        assert_eq!(plan.experiment, *name);
        assert!(
            plan.cells
                .iter()
                .enumerate()
                .all(|(i, cell)| cell.index == i)
        );
    }
}

fn cells_of(name: &str) -> Vec<plan::Cell> {
    let (_, source) = EXPERIMENTS.iter().find(|(n, _)| *n == name).unwrap();
    resolve(source).unwrap().cells
}

#[test]
fn smoke_is_five_topologies_by_three_rates_and_paper_adds_the_slow_rates_repeats_and_clients() {
    assert_eq!(cells_of("smoke").len(), 5 * 3);
    let paper = cells_of("paper");
    let count = |client: Client, mode: Mode| {
        let is_meant = |cell: &&plan::Cell| cell.client == client && cell.settings.mode == mode;
        paper.iter().filter(is_meant).count()
    };
    // Open loop at 3.3, 10 and 100 Hz, and twenty unit steps at 333 Hz and 1 kHz. Python was not
    // run over the VPN at 1 kHz, and the page only on arima at 333 Hz.
    assert_eq!(count(Client::Native, Mode::Open), 5 * 3);
    assert_eq!(count(Client::Native, Mode::Closed), 5 * 2 * 20);
    assert_eq!(count(Client::Python, Mode::Open), 3 * 3);
    assert_eq!(count(Client::Python, Mode::Closed), (4 * 2 + 1) * 20);
    assert_eq!(count(Client::Firefox, Mode::Open), 3 * 3);
    assert_eq!(count(Client::Firefox, Mode::Closed), 20);
}

#[test]
fn drift_and_clients_compare_clients_by_their_setup_on_equal_links() {
    let setups = |name: &str| -> BTreeSet<String> {
        let cells = cells_of(name);
        let setup = |cell: &plan::Cell| format!("{} {}", cell.client, cell.setup());
        cells.iter().map(setup).collect()
    };
    let browsers = |presets: &[&str]| -> BTreeSet<String> {
        ["chromium", "firefox"]
            .iter()
            .flat_map(|client| {
                presets
                    .iter()
                    .map(move |preset| format!("{client} {preset}"))
            })
            .collect()
    };
    let mut drift = browsers(&["paper-2011", "worker"]);
    drift.insert("python paper-python".to_owned());
    assert_eq!(setups("drift"), drift);
    let mut clients = browsers(&["paper-2011", "today", "worker", "socket"]);
    clients.extend([
        "native paper-python".to_owned(),
        "python paper-python".to_owned(),
    ]);
    assert_eq!(setups("clients"), clients);
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
fn a_selection_takes_whole_cells_by_pattern_or_by_index() {
    let plan = resolve(EXPERIMENTS[0].1).unwrap();
    let indices = |selection: &Selection| -> Vec<usize> {
        let chosen = plan.chosen(selection);
        chosen.iter().map(|cell| cell.index).collect()
    };
    let patterns = Selection::Matching(vec!["couva*closed*".to_owned()]);
    assert_eq!(indices(&patterns).len(), 2);
    for index in indices(&patterns) {
        assert_eq!(plan.cell(index).unwrap().topology, "couva");
    }
    assert_eq!(indices(&Selection::Numbered(vec![7, 3, 99])), [3, 7]);
    assert_eq!(indices(&Selection::All), (0..15).collect::<Vec<_>>());
}

#[test]
fn jobs_share_out_the_cells_by_topology_each_to_one_job() {
    let plan = resolve(EXPERIMENTS[1].1).unwrap();
    let jobs = plan.jobs(&Selection::All);
    let topologies: Vec<_> = jobs.iter().map(|job| job.topology.as_str()).collect();
    assert_eq!(topologies, link::Profile::BUILTIN);
    let mut shared: Vec<usize> = jobs
        .iter()
        .flat_map(|job| &job.cells)
        .map(|cell| cell.index)
        .collect();
    shared.sort_unstable();
    assert!(shared.into_iter().eq(0..plan.cells.len()));
    for job in &jobs {
        assert!(job.cells.iter().all(|cell| cell.topology == job.topology));
        assert!(!job.about.is_empty());
    }

    let fast = Selection::Matching(vec!["couva*1khz*".to_owned(), "diego-vpn*1khz*".to_owned()]);
    let some = plan.jobs(&fast);
    let sizes: Vec<_> = some.iter().map(|job| job.cells.len()).collect();
    // Native and Python on couva, over the VPN native only.
    assert_eq!(sizes, [40, 20]);
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

#[test]
fn another_topology_takes_the_place_of_every_blocks_and_equal_cells_become_one() {
    let source = "name = \"mine\"\n\
        [[cells]]\ntopology = [\"arima\"]\nclient = [\"native\"]\nmode = \"open\"\nh = [\"3ms\"]\nduration = \"1s\"\n\
        [[cells]]\ntopology = [\"buccoo\", \"couva\"]\nclient = [\"native\"]\nmode = \"open\"\nh = [\"3ms\", \"1ms\"]\nduration = \"1s\"\n";
    let instead = Instead {
        seed: Some(7),
        topology: Some("diego-vpn".to_owned()),
        client: Some("native".to_owned()),
        full: false,
    };
    let plan = Plan::resolve(source, "mine.toml", &instead, builtin).unwrap();
    let cells: Vec<_> = plan
        .cells
        .iter()
        .map(|cell| (cell.topology.as_str(), cell.settings.h.ns()))
        .collect();
    assert_eq!(cells, [("diego-vpn", 3_000_000), ("diego-vpn", 1_000_000)]);
    assert_eq!(
        plan.cells.iter().map(|cell| cell.index).collect::<Vec<_>>(),
        [0, 1]
    );
    assert_eq!((plan.seed, plan.profiles.len()), (7, 1));
    // The same link and the same id as where the experiment says so itself.
    let said = source.replace("\"arima\"", "\"diego-vpn\"");
    let seed = Instead {
        seed: Some(7),
        ..Instead::default()
    };
    let said = Plan::resolve(&said, "mine.toml", &seed, builtin).unwrap();
    assert_eq!(plan.cells[0], said.cells[0]);
}
