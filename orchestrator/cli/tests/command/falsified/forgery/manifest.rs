//! Manifests that say something else.

use std::fs;

use serde_json::{Value, json};

use super::{Forgery, forgery};
use crate::falsified::place::{copy, edit_json};

/// All of them.
pub(super) fn all() -> Vec<Forgery> {
    fn says(name: &str, words: &[&'static str], say: fn(&mut Value)) -> Forgery {
        forgery(&format!("manifest: {name}"), words, move |victim| {
            edit_json(&victim.manifest(), say);
        })
    }
    fn without(manifest: &mut Value, file: &str) {
        manifest["files"].as_object_mut().unwrap().remove(file);
    }
    vec![
        says("no object of its own", &["manifest.json"], |m| {
            *m = json!({});
        }),
        says("an empty list of files", &["nothing can be checked"], |m| {
            m["files"] = json!({});
        }),
        says("no list of files", &["missing field `files`"], |m| {
            m.as_object_mut().unwrap().remove("files");
        }),
        says("ticks.csv not listed", &["does not list ticks.csv"], |m| {
            without(m, "ticks.csv");
        }),
        says(
            "probes.csv not listed",
            &["does not list probes.csv"],
            |m| without(m, "probes.csv"),
        ),
        says(
            "plant.json not listed",
            &["does not list plant.json"],
            |m| without(m, "plant.json"),
        ),
        says("link.json not listed", &["does not list link.json"], |m| {
            without(m, "link.json");
        }),
        says(
            "a path listed",
            &["is not the name of a file beside it"],
            |m| {
                m["files"]["../../plan.json"] = m["files"]["ticks.csv"].clone();
            },
        ),
        says(
            "an absolute path listed",
            &["is not the name of a file beside it"],
            |m| {
                m["files"]["/etc/passwd"] = m["files"]["ticks.csv"].clone();
            },
        ),
        says(
            "another version of its format",
            &["format version 7"],
            |m| m["version"] = json!(7),
        ),
        says("complete for failed", &["a reason against it"], |m| {
            m["reasons"] = json!(["the controller ended with exit code 1"]);
        }),
        says("complete with a broken link", &["did not hold"], |m| {
            m["certificate"]["verdict"] = json!({ "broken": ["the delay is off"] });
        }),
        says(
            "complete without a certificate",
            &["without its link's certificate"],
            |m| {
                m["certificate"] = Value::Null;
            },
        ),
        says("another cell", &["another cell"], |m| {
            m["cell"]["settings"]["h"] = json!("20ms");
        }),
        says("another campaign's seed", &["seed"], |m| {
            m["campaign_seed"] = json!(2);
        }),
        says("another experiment", &["it belongs to theirs"], |m| {
            m["experiment"] = json!("theirs");
        }),
        says("another profile", &["its profile is arima"], |m| {
            m["profile"] = json!("arima");
        }),
        says(
            "another back-end",
            &["back-end", "was run by", "does not list link.csv"],
            |m| {
                m["backend"] = json!("netns");
                m["player"] = json!("user");
            },
        ),
        says(
            "real for simulated",
            &["no player model", "back-end"],
            |m| m["backend"] = json!("netns"),
        ),
        forgery("manifest: another cell's", &["another cell"], |victim| {
            fs::copy(victim.other.join("manifest.json"), victim.manifest()).unwrap();
        }),
        forgery(
            "manifest: another cell's folder",
            &["another cell"],
            |victim| {
                fs::remove_dir_all(&victim.cell).unwrap();
                copy(&victim.other, &victim.cell);
            },
        ),
    ]
}
