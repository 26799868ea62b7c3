//! Systems in experiments: a dimension of the matrix, checked where it stands.
#![allow(clippy::unwrap_used)]

use endpoint::{Action, Hold, Late, Lease, NoiseLaw, PlantSettings};
use plan::system::System;
use plan::{Diagnostic, Instead, Library, Plan, ProfileText};

/// The built-in profiles and systems, and one that is somebody's own.
struct Shelf(&'static str);

impl Library for Shelf {
    fn profile(&mut self, asked: &str) -> Result<ProfileText, String> {
        Ok(ProfileText {
            source: link::Profile::builtin(asked).unwrap().to_owned(),
            ..ProfileText::default()
        })
    }

    fn system(&mut self, asked: &str) -> Result<String, String> {
        match asked {
            "mine.toml" => Ok(self.0.to_owned()),
            name => System::built_in(name)
                .map(str::to_owned)
                .ok_or_else(|| format!("there is no system `{name}`")),
        }
    }
}

const MINE: &str = "name = \"mine\"\nr = 2.0\n[plant]\nnum = [1.0]\nden = [1.0, 1.0]\ndead_time = \"20ms\"\nsampling = \"tustin\"\n[controller]\nlaw = \"transfer\"\nnum = [1.0]\nden = [1.0, 0.0]\n";

fn resolve(words: &str, mine: &'static str) -> Result<Plan, Diagnostic> {
    let source = format!(
        "name = \"mine\"\n[[cells]]\ntopology = [\"arima\"]\nclient = [\"native\"]\nmode = \"closed\"\n\
         h = [\"10ms\"]\nduration = \"1s\"\n{words}"
    );
    Plan::resolve(&source, "mine.toml", &Instead::default(), Shelf(mine))
}

#[test]
fn systems_are_a_dimension_and_the_paper_s_is_meant_where_none_is_named() {
    let plan = resolve("system = [\"motor\", \"pendulum\", \"mine.toml\"]", MINE).unwrap();
    let names: Vec<&str> = plan.cells.iter().map(|cell| cell.system.as_str()).collect();
    assert_eq!(names, ["motor", "pendulum", "mine"]);
    let references: Vec<f64> = plan.cells.iter().map(|cell| cell.settings.r).collect();
    assert_eq!(references, [1.0, 0.1, 2.0]);
    assert_eq!(
        plan.systems.keys().collect::<Vec<_>>(),
        ["mine", "pendulum"]
    );
    for cell in &plan.cells {
        assert_eq!(plan.system(cell).unwrap().name(), cell.system);
    }
    assert!(
        plan.cells[1]
            .id
            .starts_with("arima-pendulum-native-closed-100hz-r01-")
    );

    // Cells of the paper's system are what they were before there were others.
    let alone = resolve("", MINE).unwrap();
    assert_eq!(alone.cells[0].id, plan.cells[0].id);
    assert!(!alone.to_json().contains("system"));
    assert_eq!(Plan::from_json(&plan.to_json()).unwrap(), plan);
}

#[test]
fn a_plant_may_let_go_of_a_command() {
    let plan = resolve("hold = \"50ms\"", MINE).unwrap();
    let then = Action::Zero;
    let ns = 50_000_000;
    assert_eq!(plan.cells[0].hold, Hold::For { ns, then });
    let problem = resolve("hold = \"soon\"", MINE).unwrap_err().problem;
    assert!(problem.starts_with("hold `soon` is unknown"), "{problem}");
}

#[test]
fn a_plant_may_be_told_how_to_be_safe() {
    let words = "hold = \"50ms then ramp 1s\"\nmax_age = \"20ms\"\nlease = \"token\"";
    let plan = resolve(words, MINE).unwrap();
    let settings = plan.cells[0].plant_settings();
    assert_eq!(settings.hold.to_string(), "50ms then ramp 1s");
    assert_eq!(settings.max_age_ns, Some(20_000_000));
    assert_eq!(settings.lease, Lease::Token);
    let setup = plan.cells[0].setup().to_string();
    assert!(
        setup.contains("hold 50ms then ramp 1s, max age 20ms, lease token"),
        "{setup}"
    );
    assert_eq!(Plan::from_json(&plan.to_json()).unwrap(), plan);
    for (words, says) in [
        ("lease = \"mine\"", "lease `mine` is unknown"),
        ("max_age = \"soon\"", "`soon` is not a number with a unit"),
    ] {
        let problem = resolve(words, MINE).unwrap_err().problem;
        assert!(problem.contains(says), "{problem}");
    }
}

#[test]
fn the_plant_of_any_but_the_paper_s_clients_is_safe_by_default() {
    let of = |words: &str| resolve(words, MINE).unwrap().cells[0].plant_settings();
    for words in ["", "preset = \"paper-python\"", "preset = \"paper-2011\""] {
        let own = of(words);
        assert_eq!(own, PlantSettings::new(own.h), "{words}");
    }
    for preset in ["blocking", "today", "worker", "socket"] {
        let words = format!("preset = \"{preset}\"");
        let own = of(&words);
        assert_eq!(own, PlantSettings::safe(own.h), "{preset}");
        let cell = &resolve(&words, MINE).unwrap().cells[0];
        let setup = cell.setup().to_string();
        assert!(setup.contains("safe plant"), "{setup}");
        assert_eq!((own.late, own.lease), (Late::Drop, Lease::Address));
        let written = of(&format!(
            "{words}\nlate = \"apply\"\nhold = \"last\"\nlease = \"none\""
        ));
        assert_eq!(written, PlantSettings::new(own.h), "{preset}");
    }
}

#[test]
fn a_plant_may_be_late_by_its_own_machine() {
    let noisy = resolve("tick_noise = \"uniform 3ms\"", MINE).unwrap();
    let law = NoiseLaw::Uniform { max_ns: 3_000_000 };
    assert_eq!(noisy.cells[0].tick_noise, Some(law));
    let setup = noisy.cells[0].setup().to_string();
    assert!(setup.ends_with(", tick noise uniform 3ms"), "{setup}");
    assert_eq!(Plan::from_json(&noisy.to_json()).unwrap(), noisy);
    // Without it a plan is what it was before there was any.
    let plan = resolve("", MINE).unwrap();
    assert!(!plan.to_json().contains("tick_noise"));
    assert_ne!(plan.cells[0].id, noisy.cells[0].id);
    let problem = resolve("tick_noise = \"3ms\"", MINE).unwrap_err().problem;
    assert!(
        problem.starts_with("tick noise `3ms` is not a law"),
        "{problem}"
    );
}

#[test]
fn what_cannot_be_run_is_told_where_it_stands() {
    let told = |words, mine| resolve(words, mine).unwrap_err().problem;
    assert_eq!(
        told("system = [\"moter\"]", MINE),
        "there is no system `moter`"
    );
    let broken = told("system = [\"mine.toml\"]", "name = 3");
    assert!(
        broken.starts_with("it is not a valid system: line 1, name: `name` is `3`"),
        "{broken}"
    );
    let elapsed = told("system = [\"pendulum\"]\nintegrate = \"elapsed\"", MINE);
    assert!(
        elapsed.starts_with("the law of pendulum always advances by h"),
        "{elapsed}"
    );
    let two = "name = \"mine\"\n[plant]\nrun = [\"tank\"]\ninputs = 2\n[controller]\nlaw = \"pid\"\nkp = 1.0\n";
    let two = told("system = [\"mine.toml\"]", two);
    assert!(
        two.starts_with("the law of system mine gives one command"),
        "{two}"
    );
    let source = "name = \"mine\"\n[[cells]]\ntopology = [\"arima\"]\nclient = [\"native\"]\nmode = \"closed\"\n\
                  h = [\"3ms\"]\nduration = \"1s\"\nsystem = [\"mine.toml\"]";
    let unfit = Plan::resolve(source, "mine.toml", &Instead::default(), Shelf(MINE)).unwrap_err();
    assert!(
        unfit
            .problem
            .starts_with("system mine cannot run at h = 3ms"),
        "{}",
        unfit.problem
    );
    assert_eq!(unfit.line, 8);
}
