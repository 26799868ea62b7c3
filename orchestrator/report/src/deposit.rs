//! Descriptions of a results folder for archives and for other people's tools.
//!
//! - [`package`]: `datapackage.json`, every CSV file with its columns, types and units;
//! - [`provenance`]: `ro-crate-metadata.json`, which program made what, when, from which plan;
//! - [`schema`]: the kinds of files of rows that webloop writes; [`field`]: a column as Table Schema has it.
//!
//! Both files are in the results folder and not in the report's, since they describe the rows as
//! well. Their content comes from the plan, the manifests and the files that are there, and not from
//! a clock. They name no authors: a folder does not know who made it.

pub mod field;
pub mod package;
pub mod provenance;
pub mod schema;

use std::path::Path;

use analysis::Campaign;
use plan::file_name::{PLAN, REPORT, SUMMARY};

/// The licence of webloop itself, which also applies to results unless their publisher says otherwise.
const LICENCE: Licence = Licence {
    name: "MIT",
    title: "MIT License",
    url: "https://spdx.org/licenses/MIT.html",
};

/// A licence.
struct Licence {
    name: &'static str,
    title: &'static str,
    url: &'static str,
}

/// The title of the folder.
fn title(campaign: &Campaign) -> String {
    format!("webloop experiment {}", campaign.plan.experiment)
}

/// What is in the folder, in a sentence or two.
fn description(campaign: &Campaign) -> String {
    let run = campaign.runs.len() - campaign.absent().count();
    let about = campaign.plan.about.trim_end_matches('.');
    format!(
        "{about}. Control loops over HTTP on emulated links: {run} of {all} cells have been run, \
         campaign seed {seed}.",
        all = campaign.runs.len(),
        seed = campaign.plan.seed,
    )
}

/// A file's name with forward slashes, on every system.
fn slashed(path: &Path) -> String {
    let parts = path
        .components()
        .map(|part| part.as_os_str().to_string_lossy());
    parts.collect::<Vec<_>>().join("/")
}
