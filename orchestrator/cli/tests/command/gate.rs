//! What an experiment expects, through the binary, in virtual time: a gate that passes and one that finds a
//! change, runs that are not there, and known failures.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The top of the tree.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Runs webloop; returns its exit code and what it printed.
pub(crate) fn webloop(place: &Path, words: &str) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_webloop"))
        .args(words.split_whitespace())
        .current_dir(place)
        .env_remove("RUST_LOG")
        .output()
        .unwrap();
    let printed = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    (output.status.code(), printed.concat())
}

/// An experiment of two runs over the VPN and two without a network, with these lines before its cells.
pub(crate) fn experiment(place: &Path, lines: &str) {
    let text = format!(
        "name = \"mine\"\n{lines}\n[[cells]]\ntopology = [\"arima\", \"diego-vpn\"]\nclient = \"native\"\n\
         mode = \"closed\"\nh = \"10ms\"\nduration = \"4s\"\nrepeats = 2\n"
    );
    fs::write(place.join("mine.toml"), text).unwrap();
}

const EXPECT: &str = "expect = { stable = \"all\", settling = \"<= 4s\" }\n";

/// The folder of a cell over the VPN.
pub(crate) fn far(place: &Path, folder: &str) -> PathBuf {
    let cells = fs::read_dir(place.join(folder).join("cells")).unwrap();
    let mut cells: Vec<PathBuf> = cells.map(|cell| cell.unwrap().path()).collect();
    cells.sort();
    cells.pop().unwrap()
}

#[test]
fn the_example_passes_and_a_gain_raised_by_a_third_is_found_in_virtual_time() {
    let place = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(format!("{ROOT}/examples/gate.toml")).unwrap();
    fs::write(place.path().join("gate.toml"), &text).unwrap();
    let (code, said) = webloop(place.path(), "gate gate.toml --sim-only --out same");
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(said.matches("\nmet: ").count(), 2 * 3, "{said}");

    let motor = plan::system::System::built_in("motor").unwrap();
    let raised = motor.replace("kp = 0.1701", "kp = 0.22113");
    assert_ne!(raised, motor);
    let raised = raised.replace("name = \"motor\"", "name = \"raised\"");
    fs::write(place.path().join("raised.toml"), raised).unwrap();
    let text = text.replace("h = \"10ms\"", "h = \"10ms\"\nsystem = \"./raised.toml\"");
    fs::write(place.path().join("gate.toml"), text).unwrap();
    let (code, said) = webloop(place.path(), "gate gate.toml --out changed");
    assert_eq!(code, Some(1), "{said}");
    let line = said
        .lines()
        .find(|line| line.starts_with("NOT MET"))
        .unwrap();
    let start = "NOT MET: diego-vpn native paper-python, system raised closed 100 Hz: settling <= 2.5s in 60% (";
    assert!(line.starts_with(start), "{line}");
    assert!(line.contains("worst in run "), "{line}");
    // No real cell was run.
    assert!(said.contains("No real cell is run.") && !place.path().join("changed/real").exists());
}

#[test]
fn a_run_that_is_missing_failed_or_invalid_fails_the_gate_and_is_named() {
    let place = tempfile::tempdir().unwrap();
    experiment(place.path(), EXPECT);
    let ran = webloop(place.path(), "run mine.toml --backend sim --out ran");
    assert_eq!(ran.0, Some(0), "{}", ran.1);
    let cell = far(place.path(), "ran");
    let id = cell.file_name().unwrap().to_str().unwrap();
    let manifest = fs::read_to_string(cell.join("manifest.json")).unwrap();
    for verdict in ["failed", "invalid"] {
        let changed = manifest.replace(
            "\"verdict\": \"complete\"",
            &format!("\"verdict\": \"{verdict}\""),
        );
        assert_ne!(changed, manifest);
        fs::write(cell.join("manifest.json"), changed).unwrap();
        let (code, said) = webloop(place.path(), "show ran");
        assert_eq!(code, Some(1), "{said}");
        assert!(
            said.contains(&format!("1 of 2 runs is not complete: {id} {verdict}")),
            "{said}"
        );
    }
    fs::remove_dir_all(&cell).unwrap();
    for command in ["show ran", "report ran"] {
        let (code, said) = webloop(place.path(), command);
        assert_eq!(code, Some(1), "{said}");
        assert!(
            said.contains(&format!("1 of 2 runs is not complete: {id} not run")),
            "{said}"
        );
    }
    let junit = fs::read_to_string(place.path().join("ran/report/junit.xml")).unwrap();
    assert!(
        junit.contains(
            "<testsuite name=\"expect\" tests=\"4\" skipped=\"0\" errors=\"0\" failures=\"2\""
        ),
        "{junit}"
    );
    // Only the chosen cells are asked.
    let (code, said) = webloop(
        place.path(),
        "run mine.toml --backend sim --out ran --only arima",
    );
    assert_eq!(
        (code, said.matches("\nmet: ").count()),
        (Some(0), 2),
        "{said}"
    );
}

#[test]
fn limits_may_change_between_two_runs_into_a_folder_and_seeds_may_not() {
    let place = tempfile::tempdir().unwrap();
    experiment(place.path(), EXPECT);
    let run = "run mine.toml --backend sim --out ran";
    assert_eq!(webloop(place.path(), run).0, Some(0));
    experiment(place.path(), "expect = { settling = \"<= 100ms\" }\n");
    let (code, said) = webloop(place.path(), run);
    assert!(
        code == Some(1) && said.contains("others are left alone"),
        "{said}"
    );
    let (code, said) = webloop(place.path(), "show ran");
    assert!(
        code == Some(1) && said.contains("settling <= 100ms"),
        "{said}"
    );
    assert_eq!(webloop(place.path(), &format!("{run} --seed 2")).0, Some(2));
}

#[test]
fn a_known_failure_passes_the_gate_and_one_that_is_over_is_told() {
    let place = tempfile::tempdir().unwrap();
    let known = |limit: &str, until: &str| {
        let lines = format!(
            "expect = {{ settling = \"<= {limit}\" }}\n[[known]]\ncells = \"diego-vpn\"\nreason = \"it is far\"\n\
             until = \"{until}\"\n"
        );
        experiment(place.path(), &lines);
    };
    let run = "run mine.toml --backend sim --out ran";
    known("500ms", "9999-12-31");
    let (code, said) = webloop(place.path(), run);
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.contains("\nknown: diego-vpn native") && said.contains("(it is far; 0 of 2, so"),
        "{said}"
    );
    assert_eq!(webloop(place.path(), "report ran").0, Some(0));
    let junit = fs::read_to_string(place.path().join("ran/report/junit.xml")).unwrap();
    assert!(
        junit.contains("<testsuite name=\"expect\" tests=\"2\" skipped=\"1\""),
        "{junit}"
    );

    known("500ms", "2026-01-01");
    let (code, said) = webloop(place.path(), run);
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("known until 2026-01-01 only: it is far"),
        "{said}"
    );

    known("4s", "9999-12-31");
    let (code, said) = webloop(place.path(), run);
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.contains("known failure diego-vpn: passes, remove it from [[known]]"),
        "{said}"
    );
}

#[test]
fn what_virtual_time_cannot_vouch_for_is_told_and_let_through() {
    let place = tempfile::tempdir().unwrap();
    experiment(place.path(), "");
    let gate = "gate mine.toml --sim-only --progress quiet";
    // Without a clause it asks for stable loops.
    let (code, said) = webloop(place.path(), &format!("{gate} --out a"));
    assert!(
        code == Some(0) && said.matches("\nmet: ").count() == 2,
        "{said}"
    );
    let words = [gate, "--out", "b", "--require", "rtt.max<=1us"].join(" ");
    let (code, said) = webloop(place.path(), &words);
    assert!(
        code == Some(0) && said.matches("\ncannot tell here: ").count() == 2,
        "{said}"
    );
    let (code, said) = webloop(place.path(), &words.replace("rtt.max", "rtt.p50"));
    assert!(
        code == Some(1) && said.matches("\nNOT MET: ").count() == 2,
        "{said}"
    );

    // With so few runs this cannot be told, and no others come.
    let sure = "expect = { iae = \"<= 9 in 60%\", confidence = \"95%\" }\n";
    experiment(place.path(), sure);
    let (code, said) = webloop(place.path(), &format!("{gate} --out d"));
    assert!(
        code == Some(1) && said.matches("\nNOT TOLD: ").count() == 2,
        "{said}"
    );
    assert!(
        said.contains("2 runs cannot tell, 6 would if all of them meet it"),
        "{said}"
    );
    let (code, _) = webloop(place.path(), &format!("{gate} --out d --allow undecided"));
    assert_eq!(code, Some(0));

    // A page in virtual time is not one in a browser.
    experiment(
        place.path(),
        "expect = { settling = \"<= 1ms\", stable = \"all\" }\n",
    );
    let words = format!("{gate} --out e --client chromium");
    let (code, said) = webloop(place.path(), &words);
    assert!(
        code == Some(0) && said.matches("\ncannot tell here: ").count() == 3,
        "{said}"
    );
    assert_eq!(said.matches("\nmet: ").count(), 1, "{said}");

    // Nobody runs a program of one's own in virtual time: nothing was asked, so nothing passed.
    let text = fs::read_to_string(place.path().join("mine.toml")).unwrap();
    let own = text.replace("\"native\"", "{ name = \"own\", run = [\"true\"] }");
    fs::write(place.path().join("mine.toml"), own).unwrap();
    let (code, said) = webloop(place.path(), &format!("{gate} --out c"));
    assert!(
        code == Some(3) && said.matches("\nnot asked: ").count() == 4,
        "{said}"
    );
    assert_eq!(webloop(place.path(), "gate mine.toml --resume").0, Some(2));
}
