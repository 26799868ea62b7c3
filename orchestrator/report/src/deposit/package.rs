//! `datapackage.json`: the folder's CSV files as a Data Package, version 2.
//!
//! Rows of one kind are one resource over the files of all cells, where the name of a file's folder
//! is the cell. The checksums of these files are in the cells' manifests; those of single files are
//! here. Files that are not tables are left out: manifests, reports of the roles, logs.

use std::path::{Path, PathBuf};

use analysis::{Run, Summary};
use record::{FileFact, file};
use serde::Serialize;
use text::column::EntryType;

use super::field::Field;
use super::schema::{ROW_FILES, RowFile};
use super::{LICENCE, REPORT, SUMMARY, slashed};
use crate::report::Report;

/// The name of the file.
pub const FILE: &str = "datapackage.json";

const VERSION: &str = "https://datapackage.org/profiles/2.0/datapackage.json";

#[derive(Serialize)]
struct Package {
    #[serde(rename = "$schema")]
    version: &'static str,
    name: String,
    title: String,
    description: String,
    licenses: [Terms; 1],
    sources: [Source; 1],
    resources: Vec<Resource>,
}

#[derive(Serialize)]
struct Terms {
    name: &'static str,
    title: &'static str,
    path: &'static str,
}

#[derive(Serialize)]
struct Source {
    title: &'static str,
}

/// A table in one file or several.
#[derive(Serialize)]
struct Resource {
    name: String,
    #[serde(rename = "type")]
    kind: &'static str,
    #[serde(skip_serializing_if = "String::is_empty")]
    description: String,
    path: Paths,
    format: &'static str,
    mediatype: &'static str,
    encoding: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    bytes: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    hash: Option<String>,
    schema: Schema,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Paths {
    One(String),
    Many(Vec<String>),
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Schema {
    fields: Vec<Field>,
    missing_values: [&'static str; 1],
    #[serde(skip_serializing_if = "Vec::is_empty")]
    primary_key: Vec<&'static str>,
}

/// The text of `datapackage.json`, including the report's own tables; `files` are [`Report::files`].
#[must_use]
pub fn json(report: &Report<'_>, files: &[(PathBuf, Vec<u8>)]) -> String {
    let campaign = report.campaign;
    let rows = ROW_FILES.iter().filter_map(|kind| rows(report, kind));
    let tables = files.iter().filter_map(|(name, content)| {
        let csv = name.extension().is_some_and(|extension| extension == "csv");
        csv.then(|| table(report, name, content))
    });
    let package = Package {
        version: VERSION,
        name: format!("webloop-{}", name(&campaign.plan.experiment)),
        title: super::title(campaign),
        description: super::description(campaign),
        licenses: [Terms {
            name: LICENCE.name,
            title: LICENCE.title,
            path: LICENCE.url,
        }],
        sources: [Source {
            title: "S. L. Remy: Web Standards as Standard Pieces in Robotics",
        }],
        resources: summary(report)
            .into_iter()
            .chain(rows)
            .chain(tables)
            .collect(),
    };
    // Plain data of strings and whole numbers: serialising it cannot fail.
    serde_json::to_string_pretty(&package).unwrap_or_default() + "\n"
}

/// `summary.csv`, if it exists.
fn summary(report: &Report<'_>) -> Option<Resource> {
    let file = file::open(&report.campaign.folder.join(SUMMARY)).ok()?;
    let fact = FileFact::of(file).ok()?;
    let schema = Schema::of(Summary::SCHEMA.iter().map(Field::of).collect());
    Some(Resource {
        bytes: Some(fact.bytes),
        hash: Some(format!("sha256:{}", fact.sha256)),
        schema: Schema {
            primary_key: vec!["cell"],
            ..schema
        },
        ..Resource::new(
            "summary".to_owned(),
            "A row for each cell: what was measured.".to_owned(),
            Paths::One(SUMMARY.to_owned()),
        )
    })
}

/// All files of one kind of row; `None` if there are none.
fn rows(report: &Report<'_>, kind: &RowFile) -> Option<Resource> {
    let runs = report.campaign.runs.iter();
    let paths: Vec<String> = runs.flat_map(|run| files(run, kind)).collect();
    let first = report.campaign.folder.join(paths.first()?);
    let mut fields: Vec<Field> = kind.columns.iter().map(Field::of).collect();
    // Files of an older version do not have the newest columns. All runs of a folder are of one version.
    if let Some(header) = header(&first) {
        fields.retain(|field| header.iter().any(|name| name == field.name));
    }
    Some(Resource {
        schema: Schema::of(fields),
        ..Resource::new(
            kind.name.to_owned(),
            kind.description.to_owned(),
            Paths::Many(paths),
        )
    })
}

/// The columns of a file of rows; `None` if it has no header.
fn header(path: &Path) -> Option<csv::StringRecord> {
    let mut reader = csv::Reader::from_reader(file::open(path).ok()?);
    let header = reader.headers().ok()?;
    (!header.is_empty()).then(|| header.clone())
}

/// The cell's files of a kind that exist. None for a run that broke off, or one with a torn file,
/// whose last line is not a row.
fn files(run: &Run, kind: &RowFile) -> Vec<String> {
    let whole = run.metrics.is_some_and(|metrics| metrics.torn_lines == 0);
    let Some(manifest) = run.manifest.as_ref().filter(|_| whole) else {
        return Vec::new();
    };
    if kind.player.is_some_and(|player| player != manifest.player) {
        return Vec::new();
    }
    let names = kind
        .files
        .iter()
        .filter(|name| manifest.files.contains_key(**name) && run.folder.join(name).is_file());
    names
        .map(|name| slashed(&run.cell.folder().join(name)))
        .collect()
}

/// A table of the report, with the columns from its header and its entries.
fn table(report: &Report<'_>, name: &Path, content: &[u8]) -> Resource {
    let stem = name.file_stem().map(|stem| stem.to_string_lossy());
    let stem = stem.as_deref().unwrap_or_default();
    let fact = FileFact::of(content).ok();
    Resource {
        bytes: fact.as_ref().map(|fact| fact.bytes),
        hash: fact.map(|fact| format!("sha256:{}", fact.sha256)),
        schema: Schema::of(columns(content)),
        ..Resource::new(
            self::name(stem),
            about(report, stem),
            Paths::One(slashed(&Path::new(REPORT).join(name))),
        )
    }
}

/// What a file of the report shows, from its table or its figure.
fn about(report: &Report<'_>, stem: &str) -> String {
    let table = report.tables.iter().find(|table| table.name == stem);
    let figure = |number: &str| stem.strip_prefix("fig-") == Some(number);
    let figure = report.figures.iter().find(|it| figure(it.number));
    match (table, figure) {
        (Some(table), _) => table.title.clone(),
        (None, Some(figure)) => format!("Figure {}: {}", figure.number, figure.caption),
        (None, None) => String::new(),
    }
}

/// The columns of a CSV. A column is numeric if every entry that is not empty is a number.
fn columns(content: &[u8]) -> Vec<Field> {
    let mut reader = csv::Reader::from_reader(content);
    let names = reader.headers().cloned().unwrap_or_default();
    let mut kinds = vec![None; names.len()];
    for row in reader.records().map_while(Result::ok) {
        for (kind, entry) in kinds.iter_mut().zip(row.iter()) {
            let number = entry.parse::<f64>().is_ok_and(f64::is_finite);
            match (entry.is_empty(), number) {
                (true, _) => {}
                (false, true) => *kind = kind.or(Some(EntryType::Number)),
                (false, false) => *kind = Some(EntryType::String),
            }
        }
    }
    let columns = names.iter().zip(kinds);
    columns
        .map(|(name, kind)| Field::new(name, kind.unwrap_or(EntryType::String), ""))
        .collect()
}

/// A valid name of a package or resource: lower case, and only letters, digits, `-` and `.`.
fn name(words: &str) -> String {
    let sign = |c: char| match c {
        'a'..='z' | '0'..='9' | '.' | '-' => c,
        'A'..='Z' => c.to_ascii_lowercase(),
        _ => '-',
    };
    words.chars().map(sign).collect()
}

impl Resource {
    fn new(name: String, description: String, path: Paths) -> Resource {
        Resource {
            name,
            kind: "table",
            description,
            path,
            format: "csv",
            mediatype: "text/csv",
            encoding: "utf-8",
            bytes: None,
            hash: None,
            schema: Schema::of(Vec::new()),
        }
    }
}

impl Schema {
    fn of(fields: Vec<Field>) -> Schema {
        Schema {
            fields,
            missing_values: [""],
            primary_key: Vec::new(),
        }
    }
}
