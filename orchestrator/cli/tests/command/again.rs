//! The line `again:` that `run` prints: what it says, typed into a shell, ends what is not complete.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use plan::Plan;
use record::Manifest;

use crate::gate::webloop;

/// A lag that breaks at its third step, unless a file says that it is mended.
const LAG: &str = "
import os, sys
y = 0.0
print(y, flush=True)
for k, line in enumerate(sys.stdin):
    if k == 2 and not os.path.exists(os.path.join(os.path.dirname(__file__), 'mended')):
        sys.exit(1)
    y += 0.1 * (float(line) - y)
    print(y, flush=True)
";

const SYSTEM: &str = "name = \"lag\"\n[plant]\nrun = [\"python3\", \"./lag.py\"]\n[controller]\nlaw = \"pid\"\n\
                      kp = 0.5\nki = 2.0\n";

const EXPERIMENT: &str = "name = \"mine\"\n[[cells]]\ntopology = [\"arima\", \"couva\"]\nsystem = \"./lag.toml\"\n\
                          client = \"native\"\nmode = \"closed\"\nh = \"10ms\"\nduration = \"2s\"\nrepeats = 2\n";

/// How the runs of a folder ended, where, and over which link. What was moved aside is none of them.
fn ended(folder: &Path) -> BTreeSet<(String, String, String, u64)> {
    let plan = Plan::from_json(&fs::read_to_string(folder.join("plan.json")).unwrap()).unwrap();
    let manifests = plan.cells.iter().map(|cell| {
        let path = folder.join(cell.folder()).join(Manifest::FILE);
        let text = fs::read_to_string(path).unwrap();
        let one = Manifest::from_json(&text).unwrap();
        (
            one.cell.topology,
            one.verdict.to_string(),
            one.backend,
            one.campaign_seed,
        )
    });
    manifests.collect()
}

#[test]
fn what_again_says_ends_what_was_not_complete_as_it_was_begun() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("a place");
    fs::create_dir(&folder).unwrap();
    for (name, text) in [
        ("lag.py", LAG),
        ("lag.toml", SYSTEM),
        ("mine.toml", EXPERIMENT),
    ] {
        fs::write(folder.join(name), text).unwrap();
    }
    let options = "--backend sim --seed 7 --topology diego-vpn --only diego* --tries 1 --no-report";
    let (code, said) = webloop(&folder, &format!("run mine.toml {options} --out ran"));
    assert_eq!(code, Some(1), "{said}");
    let all = |verdict: &str| {
        BTreeSet::from([(
            "diego-vpn".to_owned(),
            verdict.to_owned(),
            "sim".to_owned(),
            7,
        )])
    };
    assert_eq!(ended(&folder.join("ran")), all("failed"), "{said}");

    fs::write(folder.join("mended"), "").unwrap();
    let again = said.lines().find_map(|line| line.split_once("again: "));
    let (_, again) = again.expect(&said);
    let own = Path::new(env!("CARGO_BIN_EXE_webloop")).parent().unwrap();
    let path = std::env::var("PATH").unwrap();
    let output = Command::new("sh")
        .args(["-c", again])
        .current_dir(&folder)
        .env("PATH", format!("{}:{path}", own.display()))
        .env_remove("RUST_LOG")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{again}\n{said}");
    assert_eq!(ended(&folder.join("ran")), all("complete"), "{again}");
}
