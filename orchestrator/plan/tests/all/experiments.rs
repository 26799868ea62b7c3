//! Experiments become the cells they say, and mistakes in them are placed and answered.
#![allow(clippy::unwrap_used, clippy::disallowed_methods)]

use std::collections::BTreeSet;

use endpoint::Mode;
use plan::{Client, Document, EXPERIMENTS, Instead, Part, Plan, ProfileText, Selection};

fn builtin(name: &str) -> Result<ProfileText, String> {
    link::Profile::builtin(name)
        .map(|source| ProfileText {
            source: source.to_owned(),
            ..ProfileText::default()
        })
        .ok_or_else(|| format!("there is no topology `{name}`"))
}

fn resolve(source: &str) -> Result<Plan, plan::Diagnostic> {
    Plan::resolve(source, "mine.toml", &Instead::default(), builtin)
}

#[test]
fn every_experiment_that_the_binary_carries_resolves() {
    for (name, source) in EXPERIMENTS {
        let plan = Plan::resolve(source, name, &Instead::default(), builtin).unwrap();
        // Its maps keep the name that they had when sweeps had a list of their own.
        let own = if *name == "system-margins" {
            "systems"
        } else {
            name
        };
        assert_eq!(plan.experiment, own);
        assert!(
            plan.cells
                .iter()
                .enumerate()
                .all(|(i, cell)| cell.index == i)
        );
    }
}

/// Of an experiment that also has a scaled form.
fn in_full(name: &str) -> Vec<plan::Cell> {
    let source = built_in(name);
    let full = Instead {
        full: true,
        ..Instead::default()
    };
    let plan = Plan::resolve(source, name, &full, builtin).unwrap();
    plan.cells
}

/// The text of an experiment that is built in.
fn built_in(name: &str) -> &'static str {
    EXPERIMENTS.iter().find(|(n, _)| *n == name).unwrap().1
}

fn cells_of(name: &str) -> Vec<plan::Cell> {
    let source = built_in(name);
    resolve(source).unwrap().cells
}

#[test]
fn smoke_is_five_topologies_by_three_rates_and_paper_adds_the_slow_rates_repeats_and_clients() {
    assert_eq!(cells_of("smoke").len(), 5 * 3);
    let paper = in_full("paper");
    let count = |client: Client, mode: Mode| {
        // Beside the paper's matrix there are cells of what its text says and of readings.
        let is_paper = |cell: &plan::Cell| {
            cell.setup().is_preset() && link::Profile::BUILTIN.contains(&&*cell.topology)
        };
        let is_meant = |cell: &&plan::Cell| {
            is_paper(cell) && cell.client == client && cell.settings.mode == mode
        };
        paper.iter().filter(is_meant).count()
    };
    // Open loop at 3.3, 10 and 100 Hz, and twenty unit steps at 333 Hz and 1 kHz, from native and
    // Python over every link. The paper's page has what the paper has of it. Of today's, one is in
    // open loop on arima, and over every link at 100 Hz; three are in closed loop, `today` on arima,
    // `worker` over every link at 333 Hz, and `socket` at both rates.
    assert_eq!(count(Client::Native, Mode::Open), 5 * 3);
    assert_eq!(count(Client::Native, Mode::Closed), 5 * 2 * 20);
    assert_eq!(count(Client::Python, Mode::Open), 5 * 3);
    assert_eq!(count(Client::Python, Mode::Closed), 5 * 2 * 20);
    for browser in [Client::Chromium, Client::Firefox] {
        assert_eq!(count(browser, Mode::Open), 3 * 3 + 2 + 5);
        assert_eq!(count(browser, Mode::Closed), (2 + 5 + 5 * 2) * 20);
    }
    assert!(cells_of("paper").len() < paper.len());
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
    let plan = resolve(built_in("smoke")).unwrap();
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
    let plan = resolve(built_in("smoke")).unwrap();
    assert_eq!(Plan::from_json(&plan.to_json()).unwrap(), plan);
}

#[test]
fn a_link_that_is_to_stall_has_another_seed_and_all_others_keep_theirs() {
    let smoke = built_in("smoke");
    let (met, any) = (
        resolve(smoke).unwrap(),
        resolve(&smoke.replace("stall_met = [\"couva\"]\n", "")).unwrap(),
    );
    assert_eq!(met.cells.len(), any.cells.len());
    for (met, any) in met.cells.iter().zip(&any.cells) {
        let same = met.link_seed == any.link_seed && met.id == any.id;
        assert_eq!(same, met.topology != "couva", "{}", met.id);
    }
    let told = |from: &str, to: &str| resolve(&smoke.replace(from, to)).unwrap_err().problem;
    assert_eq!(
        told("stall_met = [\"couva\"]", "stall_met = [\"tobago\"]"),
        "`tobago` is not a topology of this block"
    );
    assert_eq!(
        told("stall_met = [\"couva\"]", "stall_met = [\"buccoo\"]"),
        "no link of buccoo was found that stalls while the step responds"
    );
}

#[test]
fn a_selection_takes_whole_cells_by_pattern_or_by_index() {
    let plan = resolve(built_in("smoke")).unwrap();
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
    let plan = resolve(built_in("paper")).unwrap();
    let jobs = plan.jobs_by_topology(&plan.chosen(&Selection::All));
    let topologies: Vec<_> = jobs.iter().map(|job| topology(&job.part)).collect();
    let (paper, readings) = topologies.split_at(link::Profile::BUILTIN.len());
    assert_eq!(paper, link::Profile::BUILTIN);
    assert!(
        readings
            .iter()
            .all(|name| link::Profile::READINGS.contains(name))
    );
    let mut shared: Vec<usize> = jobs
        .iter()
        .flat_map(|job| &job.cells)
        .map(|cell| cell.index)
        .collect();
    shared.sort_unstable();
    assert!(shared.into_iter().eq(0..plan.cells.len()));
    for job in &jobs {
        let name = topology(&job.part);
        assert!(job.cells.iter().all(|cell| cell.topology == name));
    }

    let fast = Selection::Matching(vec!["couva*1khz*".to_owned(), "diego-vpn*1khz*".to_owned()]);
    let some = plan.jobs_by_topology(&plan.chosen(&fast));
    let mut sizes: Vec<_> = some.iter().map(|job| job.cells.len()).collect();
    sizes.sort_unstable();
    // Native and Python, and both browsers, three of each; and those over packets that overtake each other.
    assert_eq!(sizes, [16, 12 + 6 + 6, 6 + 20 + 6]);
}

/// A topology's name, where the part is one and its profile says what it is.
fn topology(part: &Part) -> &str {
    match part {
        Part::Topology { name, about } if !about.is_empty() => name,
        other => panic!("{other:?}"),
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
        ("no h", block("mode = \"open\"\nh = []\nduration = \"1s\"")),
        (
            "too many repeats",
            block("mode = \"open\"\nh = [\"3ms\"]\nduration = \"1s\"\nrepeats = 4000000000"),
        ),
        (
            "too many cells",
            block("mode = \"open\"\nh = [\"3ms\", \"4ms\"]\nduration = \"1s\"\nrepeats = 100000"),
        ),
        (
            "the same cell twice",
            block("mode = \"open\"\nh = [\"3ms\", \"3ms\"]\nduration = \"1s\""),
        ),
        (
            "a datagram in Python",
            block("mode = \"open\"\nh = [\"3ms\"]\nduration = \"1s\"\ntransport = \"udp\"")
                .replace("native", "python"),
        ),
        (
            "JSON in a browser",
            block("mode = \"open\"\nh = [\"3ms\"]\nduration = \"1s\"\ntransport = \"json\"")
                .replace("native", "firefox"),
        ),
        (
            "a session over UDP",
            block(
                "mode = \"open\"\nh = [\"3ms\"]\nduration = \"1s\"\ntransport = \"udp\"\nlease = \"token\"",
            ),
        ),
        (
            "outstanding of zero",
            block("mode = \"open\"\nh = [\"3ms\"]\nduration = \"1s\"\noutstanding = \"0\""),
        ),
        (
            "none at a time",
            block("mode = \"open\"\nh = [\"3ms\"]\nduration = \"1s\"\ntogether = 0"),
        ),
        (
            "too many at a time",
            block("mode = \"open\"\nh = [\"3ms\"]\nduration = \"1s\"\ntogether = 65"),
        ),
        (
            "more at a time than can be counted",
            block("mode = \"open\"\nh = [\"3ms\"]\nduration = \"1s\"\ntogether = 65536"),
        ),
        (
            "a scaled form of what has none",
            block("mode = \"open\"\nh = [\"3ms\"]\nduration = \"1s\"\nscaled = { h = [\"1ms\"] }"),
        ),
        (
            "a scaled form that lasts no time",
            block(
                "mode = \"open\"\nh = [\"3ms\"]\nduration = \"1s\"\nscaled = { duration = \"0s\" }",
            ),
        ),
        (
            "h longer than the scaled run",
            block(
                "mode = \"open\"\nh = [\"3s\"]\nduration = \"9s\"\nscaled = { duration = \"1s\" }",
            ),
        ),
        ("not TOML", "name = ".to_owned()),
        ("no cells", "name = \"mine\"".to_owned()),
        (
            "a name that is a path",
            block("mode = \"open\"\nh = [\"3ms\"]\nduration = \"1s\"")
                .replace("name = \"mine\"", "name = \"../../etc\""),
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
        topology: vec!["diego-vpn".to_owned()],
        client: vec!["native".to_owned()],
        ..Instead::default()
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

#[test]
fn what_the_command_line_says_of_cells_takes_the_place_of_every_block_s() {
    let source = "name = \"mine\"\n\
        [[cells]]\ntopology = [\"arima\"]\nclient = [\"native\"]\nmode = \"closed\"\nh = [\"3ms\"]\n\
        duration = \"8s\"\nrepeats = 4\nscaled = { duration = \"2s\", repeats = 3 }\n";
    let instead = Instead {
        topology: vec!["couva".to_owned(), "diego-vpn".to_owned()],
        system: vec!["pendulum".to_owned()],
        h: vec!["10ms".to_owned()],
        duration: Some("5s".to_owned()),
        repeats: Some("2".parse().unwrap()),
        ..Instead::default()
    };
    let plan = Plan::resolve(source, "mine.toml", &instead, builtin).unwrap();
    let cells = plan.cells.iter().map(|cell| {
        let h_ns = cell.settings.h.ns();
        (
            cell.topology.as_str(),
            cell.system.as_str(),
            h_ns,
            cell.duration_ns,
            cell.repeat,
        )
    });
    let cells: Vec<_> = cells.collect();
    let cell = |topology, repeat| (topology, "pendulum", 10_000_000, 5_000_000_000, repeat);
    assert_eq!(
        cells,
        [
            cell("couva", 1),
            cell("diego-vpn", 1),
            cell("couva", 2),
            cell("diego-vpn", 2)
        ]
    );
    let wrong = Instead {
        h: vec!["10".to_owned()],
        ..Instead::default()
    };
    let refused = Plan::resolve(source, "mine.toml", &wrong, builtin).unwrap_err();
    assert!(refused.to_string().contains("`10`"), "{refused}");
}

const SCALED: &str = "name = \"mine\"\n\
    [[cells]]\ntopology = [\"arima\"]\nclient = [\"native\"]\nmode = \"closed\"\nh = [\"3ms\"]\n\
    duration = \"8s\"\nrepeats = 4\nscaled = { duration = \"2s\", repeats = 3 }\n\
    [[cells]]\ntopology = [\"couva\"]\nclient = [\"native\"]\nmode = \"closed\"\nh = [\"3ms\"]\n\
    duration = \"8s\"\nrepeats = 2\nscaled = { duration = \"4s\" }\n\
    [[cells]]\ntopology = [\"buccoo\"]\nclient = [\"native\"]\nmode = \"closed\"\nh = [\"3ms\"]\n\
    duration = \"8s\"\n";

#[test]
fn an_experiment_is_run_scaled_unless_it_is_wanted_in_full() {
    let runs = |full: bool| -> Vec<(String, u32, u64)> {
        let instead = Instead {
            full,
            ..Instead::default()
        };
        let plan = Plan::resolve(SCALED, "mine.toml", &instead, builtin).unwrap();
        let topologies = ["arima", "couva", "buccoo"];
        let runs = topologies.map(|topology| {
            let mut cells = plan.cells.iter().filter(|cell| cell.topology == topology);
            let duration_ns = cells.clone().next().unwrap().duration_ns;
            assert!(cells.all(|cell| cell.duration_ns == duration_ns));
            let repeats = plan.cells.iter().filter(|cell| cell.topology == topology);
            let repeats = repeats.map(|cell| cell.repeat).max().unwrap();
            (topology.to_owned(), repeats, duration_ns / 1_000_000_000)
        });
        runs.to_vec()
    };
    let of = |repeats: [u32; 3], seconds: [u64; 3]| -> Vec<(String, u32, u64)> {
        let names = ["arima", "couva", "buccoo"].map(str::to_owned).into_iter();
        names
            .zip(repeats)
            .zip(seconds)
            .map(|((name, repeats), seconds)| (name, repeats, seconds))
            .collect()
    };
    // Each word takes the place of its own, and a block without a scaled form is as it is.
    assert_eq!(runs(false), of([3, 2, 1], [2, 4, 8]));
    assert_eq!(runs(true), of([4, 2, 1], [8, 8, 8]));
}

#[test]
fn how_many_run_at_a_time_is_no_part_of_what_a_cell_is() {
    let block = "name = \"mine\"\n[[cells]]\ntopology = [\"couva\"]\nclient = [\"native\"]\n\
        mode = \"open\"\nh = [\"3ms\", \"1ms\"]\nduration = \"1s\"\n";
    let cells = |together: &str| resolve(&format!("{block}{together}")).unwrap().cells;
    let (alone, many) = (cells(""), cells("together = 8\n"));
    let ids = |cells: &[plan::Cell]| -> Vec<(String, u64)> {
        let id = |cell: &plan::Cell| (cell.id.clone(), cell.link_seed);
        cells.iter().map(id).collect()
    };
    assert_eq!(ids(&alone), ids(&many));
    assert!(alone.iter().all(|cell| cell.together == 1));
    assert!(many.iter().all(|cell| cell.together == 8));
    // Plans from before there was the word are read, and one without it is written as they were.
    let plan = resolve(block).unwrap();
    assert!(!plan.to_json().contains("together"));
    let many = resolve(&format!("{block}together = 8\n")).unwrap();
    assert_eq!(Plan::from_json(&many.to_json()).unwrap(), many);
}

#[test]
fn the_first_difference_of_two_plans_is_told_and_none_of_equal_ones() {
    let plan = resolve(SCALED).unwrap();
    assert_eq!(plan.difference(&plan.clone()), None);
    let told = |change: &dyn Fn(&mut Plan)| {
        let mut other = plan.clone();
        change(&mut other);
        plan.difference(&other).unwrap()
    };
    let answers = [
        told(&|plan| plan.experiment = "yours".to_owned()),
        told(&|plan| plan.seed = 2),
        told(&|plan| plan.cells.truncate(5)),
        told(&|plan| plan.cells.swap(1, 2)),
        told(&|plan| plan.cells[3].duration_ns += 1),
        told(&|plan| {
            plan.profiles.remove("couva");
        }),
        told(&|plan| plan.about = "Another question".to_owned()),
    ];
    insta::assert_snapshot!(answers.join("\n"));
}

#[test]
fn every_setting_is_one_value_or_a_list_and_every_combination_is_a_cell() {
    let of = |settings: &str| -> Vec<plan::Cell> {
        let source = format!("name = \"mine\"\n[[cells]]\n{settings}\n");
        resolve(&source).unwrap().cells
    };
    let needed = "topology = \"arima\"\nclient = \"native\"\nmode = \"closed\"\nh = \"3ms\"\nduration = \"2s\"";
    let single = of(needed);
    assert_eq!(single.len(), 1);
    let lists = "topology = [\"arima\"]\nclient = [\"native\"]\nmode = [\"closed\"]\nh = [\"3ms\"]\nduration = [\"2s\"]";
    assert_eq!(of(lists), single);

    let many = of(
        "topology = \"arima\"\nclient = [\"native\", \"python\"]\nmode = [\"open\", \"closed\"]\n\
         h = [\"3ms\", \"10ms\"]\nduration = \"2s\"\npreset = [\"blocking\", \"socket\"]\n\
         outstanding = [1, \"8\"]\nrepeats = 3",
    );
    assert_eq!(many.len(), 2 * 2 * 2 * 2 * 2 * 3);
    let ids: BTreeSet<&str> = many.iter().map(|cell| cell.id.as_str()).collect();
    assert_eq!(ids.len(), many.len());
    // The first repeat of all of them, then the second.
    let repeats: Vec<u32> = many.iter().map(|cell| cell.repeat).collect();
    assert!(repeats.is_sorted());

    let too_many = format!(
        "{needed}\ntimeout = {:?}\nhold = {:?}",
        times(400),
        times(400)
    );
    let source = format!("name = \"mine\"\n[[cells]]\n{too_many}\n");
    let said = resolve(&source).unwrap_err().to_string();
    assert!(said.contains("more than 100000 cells"), "{said}");
}

fn times(n: usize) -> Vec<String> {
    (1..=n).map(|n| format!("{n}ms")).collect()
}

#[test]
fn the_schemas_beside_them_are_the_types_and_each_names_its_own() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../experiments");
    for (document, name) in [
        (Document::Experiment, "experiment"),
        (Document::Plan, "plan"),
    ] {
        let path = format!("{folder}/{name}.schema.json");
        if std::env::var_os("WEBLOOP_TEST_WRITE").is_some() {
            std::fs::write(&path, plan::schema(document)).unwrap();
        }
        let remedy = "WEBLOOP_TEST_WRITE=1 writes it anew";
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(plan::schema(document), text, "{remedy}");
    }
    for (name, text) in EXPERIMENTS {
        let head = "#:schema ./experiment.schema.json\n";
        assert!(text.starts_with(head), "{name}");
    }
}
