//! Programs of one's own in containers: every example over two links, in webloop's image with Python or in one
//! that its folder describes; a plant; and one that does not end.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use link::certificate::Verdict::Holds;
use plan::Verdict;
use tempfile::TempDir;

use crate::docker::{Held, TOP, docker};
use crate::webloop::{code, command, run_undisturbed, said};

/// A controller that leaves processes which ignore SIGTERM, and one that ignores it itself.
const BAD: [(&str, &str, &str); 2] = [
    (
        "forks",
        "for _ in range(20):\n if os.fork() == 0:\n  os.setsid(); signal.signal(signal.SIGTERM, signal.SIG_IGN); \
         time.sleep(300)\nsys.exit(4)\n",
        "exit code 4",
    ),
    (
        "stays",
        "signal.signal(signal.SIGTERM, signal.SIG_IGN); time.sleep(300)\n",
        "killed",
    ),
];

/// The examples in a folder that the containers' user can read.
fn examples() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o755)).unwrap();
    let copied = Command::new("cp")
        .args(["--recursive", "--no-target-directory"])
        .arg(Path::new(TOP).join("examples"))
        .arg(folder.path().join("examples"))
        .status();
    assert!(copied.unwrap().success());
    folder
}

/// An experiment beside the examples, of this name.
fn beside(folder: &TempDir, name: &str, text: &str) -> PathBuf {
    let file = folder.path().join(format!("examples/{name}.toml"));
    fs::write(&file, text).unwrap();
    file
}

/// Runs experiments of so many cells beside the examples, side by side; those that were disturbed run again, alone.
/// Each holds, and nothing is left in the engine.
fn holds(cells: usize, texts: &[String]) -> Result<(), String> {
    let folder = examples();
    let before = Held::now();
    let experiments: Vec<(PathBuf, PathBuf)> = (0..)
        .zip(texts)
        .map(|(n, text)| {
            let file = beside(&folder, &format!("test-{n}"), text);
            (file, folder.path().join(format!("out-{n}")))
        })
        .collect();
    let runs = experiments.iter().map(|(file, out)| {
        let mut run = command();
        run.arg("run").arg(file).args(["--backend", "compose"]);
        run.arg("--out").arg(out).spawn().unwrap()
    });
    for run in runs.collect::<Vec<_>>() {
        let output = run.wait_with_output().unwrap();
        assert!(matches!(code(&output), Some(0 | 1)), "{}", said(&output));
    }
    let mut manifests = Vec::new();
    for (file, out) in &experiments {
        manifests.extend(run_undisturbed(file, out, "compose")?);
    }
    assert_eq!(manifests.len(), cells);
    for manifest in manifests {
        let reasons = manifest.reasons.join("; ");
        let at = format!(
            "{} over {}: {reasons}",
            manifest.cell.client, manifest.cell.topology
        );
        assert_eq!(manifest.verdict, Verdict::Complete, "{at}");
        assert_eq!(
            manifest.certificate.as_ref().unwrap().verdict,
            Holds,
            "{at}"
        );
        assert_eq!(manifest.backend, "compose", "{at}");
    }
    assert_eq!(Held::now(), before);
    Ok(())
}

pub(crate) fn every_example_holds_the_loop_in_a_container() -> Result<(), String> {
    let of = |clients: &str| {
        format!(
            "name = \"own\"\n[[cells]]\ntopology = [\"couva\", \"diego-vpn\"]\nmode = \"closed\"\nh = \"10ms\"\n\
             duration = \"4s\"\nclient = [\n{clients}]\n"
        )
    };
    holds(
        14,
        &[
            of(
                "{ name = \"mine\", run = [\"python3\", \"./python/pi.py\"] },\n\
                { name = \"plain\", run = [\"python3\", \"./plain/pi.py\"] },\n\
                { name = \"ros\", run = [\"python3\", \"./ros/adapter.py\", \"python3\", \"./ros/node.py\"] },\n",
            ),
            of("{ name = \"cpp\", image = \"./cpp\" },\n\
                { name = \"rust\", image = \"./rust\" },\n\
                { name = \"node\", image = \"./node\" },\n\
                { name = \"octave\", image = \"./octave\" },\n"),
        ],
    )
}

/// What an image has to be told, from the environment of `docker run`.
const TOLD: [&str; 7] = [
    "WEBLOOP_PLANT",
    "WEBLOOP_MODE",
    "WEBLOOP_H_S",
    "WEBLOOP_R",
    "WEBLOOP_START",
    "WEBLOOP_START_NS",
    "WEBLOOP_DURATION_S",
];

pub(crate) fn an_image_is_held_against_the_contract() -> Result<(), String> {
    let folder = Path::new(TOP).join("examples/node").display().to_string();
    let image = docker(&["build", "--quiet", &folder])?;
    let mut conform = command();
    conform.args([
        "conform",
        "--",
        "docker",
        "run",
        "--rm",
        "--init",
        "--network",
        "host",
    ]);
    conform.args(TOLD.iter().flat_map(|name| ["--env", name]));
    let output = conform.arg(image.trim()).output().unwrap();
    println!("  {}", said(&output).lines().last().unwrap_or_default());
    assert_eq!(code(&output), Some(0), "{}", said(&output));
    Ok(())
}

pub(crate) fn a_plant_of_ones_own_runs_in_a_container_on_a_link_and_on_loopback()
-> Result<(), String> {
    holds(
        2,
        &[
            "name = \"plants\"\n[[cells]]\ntopology = [\"arima\", \"couva\"]\nmode = \"closed\"\nh = \"10ms\"\n\
             duration = \"2s\"\nclient = \"native\"\nsystem = \"./plants/motor.toml\"\n"
                .to_owned(),
        ],
    )
}

pub(crate) fn one_that_does_not_end_fails_by_name_and_the_next_is_complete() -> Result<(), String> {
    let programs = BAD
        .map(|(name, ..)| format!("{{ name = \"{name}\", run = [\"python3\", \"./{name}.py\"] }}"));
    let folder = examples();
    let text = format!(
        "name = \"bad\"\n[[cells]]\ntopology = \"couva\"\nmode = \"closed\"\nh = \"10ms\"\nduration = \"2s\"\n\
         client = [{}, {{ name = \"mine\", run = [\"python3\", \"./python/pi.py\"] }}]\n",
        programs.join(", ")
    );
    for (name, text, _) in BAD {
        let file = folder.path().join(format!("examples/{name}.py"));
        fs::write(file, format!("import os, signal, sys, time\n{text}")).unwrap();
    }
    let file = beside(&folder, "test", &text);
    let manifests = run_undisturbed(&file, &folder.path().join("out"), "compose")?;
    assert_eq!(manifests.len(), BAD.len() + 1);
    for manifest in manifests {
        let name = manifest.cell.client.to_string();
        let reasons = manifest.reasons.join("; ");
        match BAD.iter().find(|(bad, ..)| *bad == name) {
            None => assert_eq!(manifest.verdict, Verdict::Complete, "{reasons}"),
            Some((.., words)) => {
                println!("  {name}: {reasons}");
                assert_eq!(manifest.verdict, Verdict::Failed, "{name}: {reasons}");
                assert!(reasons.contains(words), "{name}: {reasons}");
            }
        }
    }
    Ok(())
}
