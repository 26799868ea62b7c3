//! Plants of one's own: a motor that is a program equals the built-in one, a pendulum is held in real and in
//! virtual time, and each plant that breaks its contract fails by name and leaves nothing behind.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use endpoint::{SecondRow, TickRow};
use plan::Verdict;
use serde::de::DeserializeOwned;

use crate::process::{gone, namespaces_of, of_run};
use crate::webloop::{cells_of, code, command, manifest, run_together, run_undisturbed, said};

/// The checkout, whose examples are run.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Nothing of a plant may be left after this.
const GONE_WITHIN: Duration = Duration::from_secs(5);

/// What all the bad plants begin with: a lag, until `k` is 100.
const GOOD: &str = "
import os, sys, time
h = float(os.environ['WEBLOOP_H_S'])
y = 0.0
print(y, flush=True)
for k, line in enumerate(sys.stdin):
    y += 5 * h * (float(line) - y)
";

/// Bad plants: name, what each does at a step, and what is said of it.
const BAD: [(&str, &str, &str); 6] = [
    ("dies", "if k == 100: sys.exit(3)", "exit code 3"),
    (
        "hangs",
        "if k == 100: time.sleep(60)",
        "did not print y of step 100",
    ),
    ("nan", "if k == 100: y = float('nan')", "is no number"),
    ("words", "if k == 100: print('hot')", "is no number"),
    ("slow", "time.sleep(1.3 * h)", "needed longer than h"),
    (
        "forks",
        "if k == 100 and [os.fork() for _ in range(5)]: time.sleep(60)",
        "did not print y of step 100",
    ),
];

/// An experiment over these systems, in a folder of its own.
fn experiment(folder: &Path, topologies: &[&str], systems: &[String], duration: &str) -> PathBuf {
    let text = format!(
        "name = \"plants\"\n[[cells]]\ntopology = {topologies:?}\nclient = \"native\"\nsystem = {systems:?}\n\
         mode = \"closed\"\nh = \"10ms\"\nduration = \"{duration}\"\n"
    );
    let file = folder.join("plants.toml");
    fs::write(&file, text).unwrap();
    file
}

/// The rows of a file.
fn rows<R: DeserializeOwned>(file: &Path) -> Vec<R> {
    let rows = csv::Reader::from_path(file).unwrap().into_deserialize();
    rows.map(Result::unwrap).collect()
}

/// The outputs of each cell of a campaign, by topology and system.
fn outputs(out: &Path) -> BTreeMap<(String, String), Vec<f64>> {
    cells_of(out)
        .iter()
        .map(|cell| {
            let manifest = manifest(cell);
            assert_eq!(
                manifest.verdict,
                Verdict::Complete,
                "{:?}",
                manifest.reasons
            );
            let ticks: Vec<TickRow> = rows(&cell.join("ticks.csv"));
            let outputs = ticks.iter().map(|row| row.y);
            let cell = manifest.cell;
            ((cell.topology, cell.system), outputs.collect())
        })
        .collect()
}

pub(crate) fn a_motor_of_one_s_own_equals_the_built_in_one() -> Result<(), String> {
    if python::version().is_err() {
        return Err("no python here".to_owned());
    }
    let folder = tempfile::tempdir().unwrap();
    let systems = [
        "motor".to_owned(),
        format!("{ROOT}/examples/plants/motor.toml"),
    ];
    let file = experiment(
        folder.path(),
        &["arima", "couva", "diego-vpn"],
        &systems,
        "10s",
    );
    let out = folder.path().join("out");
    let mut run = command();
    run.arg("run")
        .arg(&file)
        .args(["--backend", "sim", "--out"])
        .arg(&out);
    let output = run.output().unwrap();
    assert_eq!(code(&output), Some(0), "{}", said(&output));
    let outputs = outputs(&out);
    for topology in ["arima", "couva", "diego-vpn"] {
        let of = |system: &str| &outputs[&(topology.to_owned(), system.to_owned())];
        let (built_in, own) = (of("motor"), of("my-motor"));
        assert_eq!(built_in.len(), own.len(), "{topology}");
        assert!(built_in.len() > 1_000, "{topology}");
        let pairs = built_in.iter().zip(own);
        let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("  over {topology} they differ by {worst:e} at the most");
        assert!(worst < 1e-9, "{topology}: {worst}");
    }
    Ok(())
}

pub(crate) fn a_pendulum_of_one_s_own_is_held_over_a_link() -> Result<(), String> {
    if python::version().is_err() {
        return Err("no python here".to_owned());
    }
    let folder = tempfile::tempdir().unwrap();
    let systems = [format!("{ROOT}/examples/plants/pendulum.toml")];
    let file = experiment(folder.path(), &["arima"], &systems, "4s");
    for backend in ["netns", "sim"] {
        let out = folder.path().join(backend);
        run_undisturbed(&file, &out, backend)?;
        let outputs = outputs(&out);
        let last = *outputs.values().next().unwrap().last().unwrap();
        assert!((last - 0.1).abs() < 0.02, "{backend}: it is at {last}");
    }
    Ok(())
}

/// A cart with two outputs under the built-in law, and two tanks as a program under a controller of one's own.
pub(crate) fn two_inputs_and_outputs_are_held_over_a_link_and_in_virtual_time() -> Result<(), String>
{
    if python::version().is_err() {
        return Err("no python here".to_owned());
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("two.toml");
    let cart = "name = \"two\"\n[[cells]]\ntopology = \"couva\"\nclient = [\"native\", \"python\"]\n\
                system = \"cart\"\nmode = \"closed\"\nh = \"10ms\"\nduration = \"6s\"\n";
    let tanks = format!(
        "[[cells]]\ntopology = \"diego-vpn\"\n\
         client = {{ name = \"two\", run = [\"python3\", \"{ROOT}/examples/python/two.py\"] }}\n\
         system = \"{ROOT}/examples/plants/tanks.toml\"\nmode = \"closed\"\nh = \"20ms\"\nduration = \"6s\"\n"
    );
    for (backend, text) in [
        ("sim", cart.to_owned()),
        ("netns", format!("{cart}{tanks}")),
    ] {
        fs::write(&file, text).unwrap();
        let out = folder.path().join(backend);
        // They mostly wait.
        run_together(&file, &out, backend, 3)?;
        for cell in cells_of(&out) {
            let made = manifest(&cell);
            assert_eq!(made.verdict, Verdict::Complete, "{:?}", made.reasons);
            let (system, client) = (made.cell.system, made.cell.client);
            let rests_at = if system == "cart" {
                [0.5, 0.0]
            } else {
                [1.0, 0.5]
            };
            let ticks: Vec<TickRow> = rows(&cell.join("ticks.csv"));
            let rows: Vec<SecondRow> = rows(&cell.join("second.csv"));
            assert_eq!(rows.len(), ticks.len(), "{system}: a row for each tick");
            let last = rows.last().unwrap();
            assert_eq!(last.u2.is_some(), system == "tanks");
            let last = [ticks.last().unwrap().y, last.y2.unwrap()];
            println!("  {system} under {client}, {backend}: at {last:?}");
            for (y, rest) in last.iter().zip(rests_at) {
                assert!(
                    (y - rest).abs() < 0.03,
                    "{backend}: {system} is at {last:?}"
                );
            }
        }
    }
    Ok(())
}

/// Longer than the parts of a run may take before its link opens, and less than with the most patience.
const SLOW_S: f64 = 1.0;

/// What is not ready when its link opens has no run, and is begun again with more patience.
pub(crate) fn a_plant_that_starts_slowly_is_waited_for() -> Result<(), String> {
    if python::version().is_err() {
        return Err("no python here".to_owned());
    }
    let folder = tempfile::tempdir().unwrap();
    let program = format!("import time\ntime.sleep({SLOW_S}){GOOD}    print(y, flush=True)\n");
    fs::write(folder.path().join("late.py"), program).unwrap();
    let system = folder.path().join("late.toml");
    let text = "name = \"late\"\n[plant]\nrun = [\"python3\", \"./late.py\"]\n\
                [controller]\nlaw = \"pid\"\nkp = 1.0\nki = 2.0\n";
    fs::write(&system, text).unwrap();
    let systems = [system.display().to_string()];
    let file = experiment(folder.path(), &["arima"], &systems, "2s");
    let (plan, out) = (folder.path().join("plan.json"), folder.path().join("out"));
    let matrix = command()
        .arg("matrix")
        .arg(&file)
        .arg("--plan")
        .arg(&plan)
        .output()
        .unwrap();
    assert_eq!(code(&matrix), Some(0), "{}", said(&matrix));
    let mut run = command();
    run.args(["run-cell", "--index", "0", "--plan"]).arg(&plan);
    // One try: that a busy machine is asked once more is another matter.
    let output = run
        .args(["--tries", "1", "--out"])
        .arg(&out)
        .env("RUST_LOG", "info")
        .output()
        .unwrap();
    let log = said(&output);
    assert!(log.contains("once more, with more time"), "{log}");
    for cell in cells_of(&out) {
        let manifest = manifest(&cell);
        // A busy machine may need more than the most patience; what an attempt has left is gone in any case.
        let reasons = manifest.reasons.join("; ");
        let is_too_late = reasons.contains("too busy to start the parts");
        println!("  {}: {reasons}", manifest.verdict);
        assert!(
            manifest.verdict != Verdict::Failed || is_too_late,
            "{reasons}"
        );
        assert!(manifest.earlier.is_empty(), "{:?}", manifest.earlier);
    }
    assert_eq!(fs::read_dir(out.join("cells")).unwrap().count(), 1);
    Ok(())
}

pub(crate) fn a_plant_that_breaks_its_contract_fails_by_name_and_leaves_nothing()
-> Result<(), String> {
    if python::version().is_err() {
        return Err("no python here".to_owned());
    }
    let folder = tempfile::tempdir().unwrap();
    let system = |(name, text): (&str, &str)| {
        let program = format!("{GOOD}    {text}\n    print(y, flush=True)\n");
        fs::write(folder.path().join(format!("{name}.py")), program).unwrap();
        let text = format!(
            "name = \"{name}\"\n[plant]\nrun = [\"python3\", \"./{name}.py\"]\n\
             [controller]\nlaw = \"pid\"\nkp = 1.0\nki = 2.0\n"
        );
        let file = folder.path().join(format!("{name}.toml"));
        fs::write(&file, text).unwrap();
        file.display().to_string()
    };
    let systems: Vec<String> = BAD
        .iter()
        .map(|(name, text, _)| system((name, text)))
        .collect();
    let file = experiment(folder.path(), &["arima"], &systems, "2s");
    let out = folder.path().join("bad");
    // What they do wrong is told whether or not others take the processors.
    let manifests = run_together(&file, &out, "netns", 3)?;
    gone(&out, &namespaces_of(&of_run(&out)), GONE_WITHIN);
    assert_eq!(manifests.len(), systems.len());
    for manifest in manifests {
        let (name, reasons) = (manifest.cell.system, manifest.reasons.join("; "));
        println!("  {name}: {reasons}");
        let (.., words) = BAD.iter().find(|(bad, ..)| *bad == name).unwrap();
        assert_eq!(manifest.verdict, Verdict::Failed, "{name}: {reasons}");
        assert!(reasons.contains(words), "{name}: {reasons}");
    }
    // Last, when all the others have had their chance to harm it.
    let file = experiment(folder.path(), &["arima"], &[system(("good", "pass"))], "2s");
    for manifest in run_undisturbed(&file, &folder.path().join("good"), "netns")? {
        let reasons = manifest.reasons.join("; ");
        assert_eq!(manifest.verdict, Verdict::Complete, "{reasons}");
    }
    Ok(())
}
