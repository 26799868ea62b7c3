#![allow(clippy::print_stdout, clippy::unwrap_used)]

use std::path::Path;
use std::process::Command;

use process::plant::Start;

use super::*;

/// What all the bad plants begin with: a lag in plain Python, until `y` and the loop.
const BEGIN: &str = "\
import os, sys, time
h = float(os.environ['WEBLOOP_H_S'])
y = 0.0
def step(u):
    global y
    y += h * (u - y)
    return y
def say(text):
    print(text, flush=True)
";

const LOOP: &str = "
say(y)
for line in sys.stdin:
    say(repr(step(float(line))))
";

/// Bad plants: name, the program after [`BEGIN`], the trial that must fail, and what it must say.
const BAD: [(&str, &str, &str, &str); 12] = [
    (
        "mute",
        "time.sleep(60)",
        "start",
        "did not print its first y",
    ),
    ("dies", "sys.exit(3)", "start", "ended with exit code 3"),
    (
        "words",
        "say(y)\nfor line in sys.stdin: say('y=' + repr(step(float(line))))",
        "steps",
        "is no number",
    ),
    (
        "nan",
        "say(y)\nfor k, line in enumerate(sys.stdin): say(repr(step(float(line)) if k < 9 else float('nan')))",
        "steps",
        "as y of step 9, which is no number",
    ),
    (
        "twice",
        "say(y)\nfor line in sys.stdin: say(repr(step(float(line))) + '\\ndone')",
        "steps",
        "one line for each u",
    ),
    (
        "slow",
        "say(y)\nfor line in sys.stdin: time.sleep(1.5 * h); say(repr(step(float(line))))",
        "rate",
        "took longer than h",
    ),
    (
        "clock",
        "begun = time.monotonic()\nsay(y)\nfor line in sys.stdin: say(repr(time.monotonic() - begun))",
        "rate",
        "whatever the clock says",
    ),
    (
        "random",
        "import random\nsay(y)\nfor line in sys.stdin: say(repr(step(float(line)) + random.random()))",
        "repeat",
        "two starts differ",
    ),
    (
        "keeps",
        "kept = sys.argv[1]\n\
         y = float(open(kept).read()) if os.path.exists(kept) else 0.0\nsay(y)\n\
         for line in sys.stdin:\n say(repr(step(float(line))))\n open(kept, 'w').write(repr(y))",
        "repeat",
        "begin anew",
    ),
    (
        "fixed",
        "h = 0.01\nsay(y)\nfor line in sys.stdin: say(repr(step(float(line))))",
        "sample-time",
        "WEBLOOP_H_S",
    ),
    (
        "fragile",
        "say(y)\nfor line in sys.stdin:\n u = float(line)\n assert abs(u) < 100\n say(repr(step(u)))",
        "extremes",
        "ended with exit code 1",
    ),
    (
        "stays",
        "say(y)\nfor line in sys.stdin: say(repr(step(float(line))))\ntime.sleep(60)",
        "end",
        "still ran 1 s after",
    ),
];

/// The outcomes of a plant with this text.
fn outcomes(folder: &Path, name: &str, text: &str) -> Vec<TrialResult> {
    let file = folder.join(format!("{name}.py"));
    std::fs::write(&file, format!("{BEGIN}{text}\n")).unwrap();
    let kept = folder.join(format!("{name}.kept"));
    let run = [
        "python3".to_owned(),
        file.display().to_string(),
        kept.display().to_string(),
    ];
    let start = |h: SampleTime| {
        PlantProgram::start(&Start {
            run: &run,
            environment: vec![("WEBLOOP_H_S", format!("{:?}", h.seconds()).into())],
            inputs: 1,
            h_ns: h.ns(),
            start_within: Duration::from_secs(10),
            step_within: Duration::from_secs(1),
            confinement: process::plant::Confinement::None,
        })
        .map_err(|problem| PlantFault::Broken(problem.to_string()))
    };
    let h = SampleTime::try_new(10_000_000).unwrap();
    run_plant(&start, h, &AtomicBool::new(false)).unwrap()
}

fn has_python() -> bool {
    let has = Command::new("python3").arg("--version").output().is_ok();
    if !has {
        println!("SKIPPED: no python3 here");
    }
    has
}

#[test]
fn each_planted_fault_is_found_and_named() {
    if !has_python() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    // They mostly sleep, so a few at once: what a busy machine adds to their faults is not looked at.
    let try_out = |bad: &[_]| {
        thread::scope(|scope| {
            for &(name, text, trial, words) in bad {
                let folder = folder.path();
                scope.spawn(move || {
                    let outcomes = outcomes(folder, name, text);
                    let failed = outcomes.iter().find(|one| one.trial == trial);
                    let failed = failed.unwrap_or_else(|| panic!("{name}: {outcomes:?}"));
                    assert_eq!(failed.verdict, Verdict::Failed, "{name}: {outcomes:?}");
                    let said = &failed.words[0];
                    assert!(said.contains(words), "{name}: {said}");
                });
            }
        });
    };
    BAD.chunks(6).for_each(try_out);
}

#[test]
fn a_plain_plant_passes() {
    if !has_python() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let outcomes = outcomes(folder.path(), "plain", LOOP);
    let failed = outcomes.iter().filter(|one| one.verdict != Verdict::Passed);
    // A busy machine may take a step's time; all else is the program's.
    let failed: Vec<_> = failed.filter(|one| one.trial != "rate").collect();
    assert!(failed.is_empty(), "{failed:?}");
    assert_eq!(outcomes.len(), PLANT_TRIALS.len());
}
