//! Plans that no experiment comes to, or another than that of the runs.

use std::fs::{self, File};
use std::path::Path;

use serde_json::{Value, json};

use super::in_place::{lead_out, pipe};
use super::{Forgery, forgery};
use crate::falsified::place::{Victim, edit_json};

/// All of them.
pub(super) fn all() -> Vec<Forgery> {
    fn says(
        name: &str,
        words: &[&'static str],
        say: impl Fn(&mut Value) + Send + Sync + 'static,
    ) -> Forgery {
        Forgery {
            of_plan: true,
            ..forgery(&format!("plan: {name}"), words, move |victim| {
                edit_json(&victim.plan(), &say);
            })
        }
    }
    fn cell(at: &'static str, value: Value, words: &[&'static str]) -> Forgery {
        let name = format!("{at} {value}");
        says(&name, words, move |plan| {
            for cell in plan["cells"].as_array_mut().unwrap() {
                if cell["topology"] == "couva" && cell.get("system").is_none() {
                    *cell.pointer_mut(at).unwrap() = value.clone();
                }
            }
        })
    }
    fn file(name: &str, words: &[&'static str], put: fn(&Victim, &Path)) -> Forgery {
        Forgery {
            of_plan: true,
            ..forgery(&format!("plan: {name}"), words, move |victim| {
                put(victim, &victim.plan());
            })
        }
    }
    let no_folder = "cannot name a folder";
    vec![
        cell("/id", json!("../../../outside/x"), &[no_folder]),
        cell("/id", json!("/tmp/webloop-outside"), &[no_folder]),
        cell("/id", json!(".."), &[no_folder]),
        cell("/id", json!(""), &[no_folder]),
        cell("/settings/h", json!("0s"), &["sample time"]),
        cell("/duration_ns", json!(0), &["duration_ns 0"]),
        cell("/duration_ns", json!(u64::MAX), &["a week"]),
        cell("/repeat", json!(0), &["repeat 0"]),
        cell("/topology", json!("nowhere"), &["no profile `nowhere`"]),
        cell("/link_seed", json!(7), &["link_seed 7"]),
        // As an experiment could have it, and not as it was run.
        cell("/duration_ns", json!(2_000_000_000_u64), &["another cell"]),
        cell("/settings/r", json!(2.0), &["another cell"]),
        says("an id twice", &["another cell has the same id"], |plan| {
            plan["cells"][1]["id"] = plan["cells"][0]["id"].clone();
        }),
        says("an index twice", &["another cell has this index"], |plan| {
            plan["cells"][1]["index"] = plan["cells"][0]["index"].clone();
        }),
        says("no cell's system", &["no system `nothing`"], |plan| {
            plan["cells"][0]["system"] = json!("nothing");
        }),
        says("another seed", &["link_seed"], |plan| {
            plan["seed"] = json!(2);
        }),
        says("another name", &["it belongs to mine"], |plan| {
            plan["experiment"] = json!("theirs");
        }),
        says(
            "a path for a name",
            &["is not a valid name of a results folder"],
            |plan| {
                plan["experiment"] = json!("../../theirs");
            },
        ),
        says(
            "another profile",
            &["profile.toml differs from the plan's"],
            |plan| {
                let text = plan["profiles"]["couva"]["source"]
                    .as_str()
                    .unwrap()
                    .to_owned();
                plan["profiles"]["couva"]["source"] = json!(format!("{text}\n# softer\n"));
            },
        ),
        says("a trace by a path", &["has a trace"], |plan| {
            plan["profiles"]["couva"]["traces"] = json!({ "../../../outside/x": "" });
        }),
        says("a trace by our own name", &["has a trace"], |plan| {
            plan["profiles"]["couva"]["traces"] = json!({ "ticks.csv": "" });
        }),
        says(
            "another version of its format",
            &["format version 7"],
            |plan| plan["version"] = json!(7),
        ),
        file("emptied", &["EOF while parsing"], |_, path| {
            fs::write(path, "").unwrap();
        }),
        file("linked to elsewhere", &["a link"], lead_out),
        file("a pipe", &["a pipe"], |_, path| pipe(path)),
        file("a terabyte", &["at most"], |_, path| {
            File::create(path).unwrap().set_len(1 << 40).unwrap();
        }),
    ]
}
