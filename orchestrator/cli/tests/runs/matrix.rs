//! An experiment that several machines share: each runs a job, and their folders are merged.

use std::fs;
use std::path::Path;

use crate::webloop::{Experiment, code, column, command, files, said};

pub(crate) fn jobs_of_one_plan_merge_by_being_copied() -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    let experiment = Experiment::new(folder.path(), &["arima", "office"], "3ms", "500ms");
    let plan = folder.path().join("plan.json");
    let matrix = command()
        .args(["matrix", "--format", "github"])
        .arg(&experiment.file)
        .arg("--plan")
        .arg(&plan)
        .output()
        .unwrap();
    assert_eq!(code(&matrix), Some(0), "{}", said(&matrix));
    let matrix: serde_json::Value = serde_json::from_slice(&matrix.stdout).unwrap();
    let jobs = matrix["include"].as_array().unwrap();
    assert_eq!(jobs.len(), 2);

    let merged = folder.path().join("merged");
    for job in jobs {
        let topology = job["topology"].as_str().unwrap();
        let out = folder.path().join(topology);
        let run = of_job(&plan, job["cells"].as_str().unwrap(), &out);
        // A busy machine may have been too late for the link; the cell exists all the same.
        assert!(matches!(code(&run), Some(0 | 1)), "{}", said(&run));
        let table = String::from_utf8(run.stdout).unwrap();
        assert!(table.contains(topology), "{table}");
        assert!(
            table.contains("1 of the plan's 2 cells have not been run here"),
            "{table}"
        );
        copy(&out, &merged);
    }
    assert_eq!(
        fs::read_to_string(merged.join("plan.json")).unwrap(),
        fs::read_to_string(&plan).unwrap()
    );
    let shown = command().arg("show").arg(&merged).output().unwrap();
    let table = String::from_utf8(shown.stdout).unwrap();
    assert!(table.contains("arima") && table.contains("office"));
    assert!(!table.contains("not been run"), "{table}");

    let csv = command()
        .args(["show", "--format", "csv"])
        .arg(&merged)
        .output()
        .unwrap();
    let rows = column(&csv.stdout, "topology");
    assert_eq!(rows, ["arima", "office"]);

    // `collect` gives the same result, and checks each file.
    let collected = folder.path().join("collected");
    let collect = command()
        .arg("collect")
        .args(["arima", "office"].map(|topology| folder.path().join(topology)))
        .arg("--out")
        .arg(&collected)
        .output()
        .unwrap();
    assert!(matches!(code(&collect), Some(0 | 1)), "{}", said(&collect));
    let cells = |out: &Path| {
        let experiment = Experiment {
            out: out.to_owned(),
            file: experiment.file.clone(),
        };
        let cells = experiment.cells();
        cells.iter().map(|cell| files(cell)).collect::<Vec<_>>()
    };
    assert_eq!(cells(&collected), cells(&merged));
    Ok(())
}

fn of_job(plan: &Path, cells: &str, out: &Path) -> std::process::Output {
    command()
        .arg("run")
        .arg(plan)
        .args(["--cells", cells])
        .arg("--out")
        .arg(out)
        .output()
        .unwrap()
}

/// Copies a folder's files over another's, as `cp -r` does and as artifacts are merged.
fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().flatten() {
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}
