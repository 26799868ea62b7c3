//! One line from somebody's own program to the answer, in a folder that has nothing else.

use std::fs;
use std::path::Path;
use std::process::Output;

use crate::webloop::{cells_of, code, command, manifest, said, too_busy, was_busy};

/// The README's controller.
const MINE: &str = "
import webloop

class Mine:
    integral = 0.0

    def update(self, r, y, dt):
        self.integral += 0.378 * dt * (r - y)
        return 0.1701 * (r - y) + self.integral

webloop.control(Mine())
";

/// The README's plant.
const TANK: &str = "
import webloop

class Tank:
    y = 0.0

    def step(self, u, dt):
        self.y += dt * (u - 0.5 * max(self.y, 0.0) ** 0.5)
        return self.y

webloop.plant(Tank())
";

fn webloop_try(folder: &Path, words: &[&str]) -> Output {
    let mut command = command();
    command.current_dir(folder).arg("try").args(words);
    command.output().unwrap()
}

pub(crate) fn a_stranger_s_controller_gets_its_answer_by_one_line_which_is_an_experiment()
-> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("mine.py"), MINE).unwrap();
    let line = [
        "--duration",
        "2s",
        "--topology",
        "wired",
        "--out",
        "out",
        "--",
        "python3",
        "mine.py",
    ];
    let output = webloop_try(folder.path(), &line);
    let cells = cells_of(&folder.path().join("out"));
    let manifests: Vec<_> = cells.iter().map(|cell| manifest(cell)).collect();
    if manifests.iter().any(was_busy) {
        return Err(too_busy("two runs"));
    }
    assert_eq!(code(&output), Some(0), "{}", said(&output));
    assert!(
        said(&output).contains("Holds in all 2 runs"),
        "{}",
        said(&output)
    );
    // What it stands for is there, and runs from where it is.
    let mut again = command();
    let file = folder.path().join("out/try.toml");
    let plan = again
        .arg("run")
        .arg(file)
        .arg("--dry-run")
        .output()
        .unwrap();
    assert_eq!(code(&plan), Some(0), "{}", said(&plan));
    assert!(!said(&plan).contains("not there"), "{}", said(&plan));
    for manifest in &manifests {
        let id = &manifest.cell.id;
        assert!(said(&plan).contains(id), "{id}: {}", said(&plan));
    }
    Ok(())
}

pub(crate) fn a_stranger_s_plant_runs_by_one_line_in_virtual_time_too() -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("tank.py"), TANK).unwrap();
    let line = [
        "--sim", "--plant", "--out", "out", "--", "python3", "tank.py",
    ];
    let output = webloop_try(folder.path(), &line);
    let told = said(&output);
    assert!(
        told.contains("system tank") || told.contains("tank"),
        "{told}"
    );
    assert_eq!(cells_of(&folder.path().join("out")).len(), 2, "{told}");
    let missing = webloop_try(folder.path(), &["--plant", "--", "python3", "tonk.py"]);
    assert_eq!(code(&missing), Some(2), "{}", said(&missing));
    assert!(
        said(&missing).contains("tonk.py, which is not there"),
        "{}",
        said(&missing)
    );
    Ok(())
}
