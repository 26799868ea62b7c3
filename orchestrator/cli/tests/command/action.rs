//! The GitHub action: its inputs are those that its steps use, and its scripts do what they say, run here with
//! the variables that a runner sets.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

/// The top of the tree.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

fn text() -> String {
    fs::read_to_string(format!("{ROOT}/action.yml")).unwrap()
}

/// The scripts of more than one line, without their indentation.
fn scripts(text: &str) -> Vec<String> {
    let lines: Vec<&str> = text.lines().collect();
    let starts = (0..lines.len()).filter(|i| lines[*i].trim_start() == "run: |");
    let script = |start: usize| {
        let indent = " ".repeat(lines[start].find("run").unwrap() + 2);
        let rest = lines[start + 1..].iter();
        let own = rest.map_while(|line| line.strip_prefix(&indent));
        own.collect::<Vec<_>>().join("\n")
    };
    starts.map(script).collect()
}

#[test]
fn its_inputs_are_those_that_its_steps_use() {
    let text = text();
    let (head, steps) = text.split_once("\nruns:").unwrap();
    let (_, inputs) = head.split_once("\ninputs:\n").unwrap();
    let inputs = inputs.split("\noutputs:").next().unwrap();
    let declared = inputs.lines().filter_map(|line| {
        let name = line.strip_prefix("  ")?.strip_suffix(':')?;
        (!name.starts_with(' ')).then_some(name)
    });
    let declared: BTreeSet<&str> = declared.collect();
    let used = steps.split("inputs.").skip(1);
    let used = used.map(|rest| rest.split(|c: char| !c.is_ascii_alphanumeric()).next());
    let used: BTreeSet<&str> = used.flatten().collect();
    assert!(declared.len() > 3);
    assert_eq!(declared, used);
    // No script has an expression in it: whoever writes an input could write a script into it.
    assert!(scripts(&text).iter().all(|script| !script.contains("${{")));
}

/// Runs the two scripts; returns their exit codes, and what is on the job's page.
fn acted(place: &Path, require: &str) -> (Vec<Option<i32>>, String) {
    let program = place.join("webloop/bin");
    fs::create_dir_all(&program).unwrap();
    std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_webloop"), program.join("webloop")).unwrap();
    let experiment = "name = \"mine\"\n[expect]\nstable = \"all\"\n[[cells]]\ntopology = \"arima\"\n\
                      client = \"native\"\nmode = \"closed\"\nh = \"10ms\"\nduration = \"2s\"\nrepeats = 2\n";
    fs::write(place.join("mine.toml"), experiment).unwrap();
    let run = |script: &String| {
        Command::new("bash")
            .args(["--noprofile", "--norc", "-eo", "pipefail", "-c", script])
            .current_dir(place)
            .env("RUNNER_TEMP", place)
            .env("GITHUB_OUTPUT", place.join("output"))
            .env("GITHUB_STEP_SUMMARY", place.join("summary"))
            .env("EXPERIMENT", "mine.toml")
            .env("ARGS", "--sim-only --only r01 --only r02")
            .env("REQUIRE", require)
            .env("BACKEND", "netns")
            .output()
            .unwrap()
            .status
            .code()
    };
    let codes = scripts(&text()).iter().map(run).collect();
    (codes, fs::read_to_string(place.join("summary")).unwrap())
}

#[test]
fn its_scripts_run_the_gate_and_report_it_whether_it_passes_or_not() {
    let place = tempfile::tempdir().unwrap();
    let (codes, page) = acted(place.path(), "");
    assert_eq!(codes, [Some(0), Some(0)]);
    assert!(page.contains("| met | arima native"), "{page}");
    let output = fs::read_to_string(place.path().join("output")).unwrap();
    let results = place.path().join("webloop-gate");
    assert_eq!(output, format!("results={}\n", results.display()));
    assert!(results.join("virtual/report/junit.xml").is_file());

    let place = tempfile::tempdir().unwrap();
    let (codes, page) = acted(place.path(), "settling <= 10ms in 50%\nsent >= 99%\n");
    assert_eq!(codes, [Some(1), Some(0)]);
    assert!(page.contains("| NOT MET | arima native"), "{page}");
}
