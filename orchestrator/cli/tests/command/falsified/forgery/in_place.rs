//! Something else where a file should be.

use std::fs::{self, File};
use std::os::unix::fs::symlink;
use std::path::Path;

use serde_json::json;

use super::{Forgery, forgery};
use crate::falsified::place::{Victim, edit_json};

/// Puts a pipe there.
pub(super) fn pipe(path: &Path) {
    let _ = fs::remove_file(path);
    let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
    rustix::fs::mkfifoat(rustix::fs::CWD, path, mode).unwrap();
}

/// Moves a file or a folder out, and leaves a link to it.
pub(super) fn lead_out(victim: &Victim, path: &Path) {
    // Out of the place that is looked at, or the next copy would not be alike.
    let kept = victim.folder.join("moved");
    fs::rename(path, &kept).unwrap();
    symlink(kept, path).unwrap();
}

/// All of them.
pub(super) fn all() -> Vec<Forgery> {
    let mut all = Vec::new();
    for file in [
        "ticks.csv",
        "probes.csv",
        "profile.toml",
        "plant.json",
        "link.json",
    ] {
        all.push(forgery(
            &format!("{file} removed"),
            &[file],
            move |victim| {
                fs::remove_file(victim.cell.join(file)).unwrap();
            },
        ));
    }
    for file in ["ticks.csv", "manifest.json"] {
        let is = |words: &str| format!("{file} {words}");
        all.push(forgery(&is("emptied"), &[file], move |victim| {
            fs::write(victim.cell.join(file), "").unwrap();
        }));
        all.push(forgery(
            &is("linked to elsewhere"),
            &["a link"],
            move |victim| {
                lead_out(victim, &victim.cell.join(file));
            },
        ));
        all.push(forgery(&is("a pipe"), &["a pipe"], move |victim| {
            pipe(&victim.cell.join(file));
        }));
        all.push(forgery(
            &is("a folder"),
            &["a folder", "manifest says"],
            move |victim| {
                fs::remove_file(victim.cell.join(file)).unwrap();
                fs::create_dir(victim.cell.join(file)).unwrap();
            },
        ));
        all.push(forgery(&is("a terabyte"), &[file], move |victim| {
            File::create(victim.cell.join(file))
                .unwrap()
                .set_len(1 << 40)
                .unwrap();
        }));
    }
    all.extend([
        forgery(
            "ticks.csv a terabyte that the manifest knows",
            &["ticks.csv"],
            |victim| {
                File::create(victim.cell.join("ticks.csv"))
                    .unwrap()
                    .set_len(1 << 40)
                    .unwrap();
                edit_json(&victim.manifest(), |manifest| {
                    manifest["files"]["ticks.csv"]["bytes"] = json!(1_u64 << 40);
                });
            },
        ),
        forgery(
            "the cell's folder linked to elsewhere",
            &["a link"],
            |victim| {
                lead_out(victim, &victim.cell);
            },
        ),
        forgery(
            "the folder of cells linked to elsewhere",
            &["cells is a link"],
            |victim| {
                lead_out(victim, &victim.folder.join("cells"));
            },
        ),
    ]);
    all
}
