//! The pages of docs/reference, made from the JSON schemas, from what `--help` prints, and from the columns of rows.

use std::fmt::Write;
use std::fs;
use std::process::Command;

use analysis::Summary;
use report::deposit::field::Field;
use report::deposit::schema::ROW_FILES;
use serde_json::{Map, Value};
use text::column::{Column, EntryType};

use crate::book::page::ROOT;

const FILES: [(&str, &str, &str); 5] = [
    (
        "experiment",
        "Experiment files",
        "orchestrator/experiments/experiment.schema.json",
    ),
    (
        "system",
        "System files",
        "services/systems/system.schema.json",
    ),
    (
        "profile",
        "Link profiles",
        "netem/profiles/profile.schema.json",
    ),
    (
        "settings",
        "Settings of a role",
        "orchestrator/backend/settings.schema.json",
    ),
    (
        "manifest",
        "Manifests",
        "orchestrator/record/manifest.schema.json",
    ),
];

/// Each page's name and text.
pub(crate) fn pages() -> Vec<(&'static str, String)> {
    let of_files = FILES.iter().map(|(name, title, schema)| {
        let text = fs::read_to_string(format!("{ROOT}/{schema}")).unwrap();
        let value: Value = serde_json::from_str(&text).unwrap();
        (*name, of_schema(title, schema, &value))
    });
    [("commands", of_commands()), ("columns", of_columns())]
        .into_iter()
        .chain(of_files)
        .collect()
}

fn of_columns() -> String {
    let mut page = "# Columns\n\nOf the CSV files in a results folder, as its `datapackage.json` describes them. A \
                    time is on the run's monotonic clock.\n"
        .to_owned();
    let summary = "The results folder: a row for each cell.";
    file(&mut page, "summary.csv", summary, Summary::SCHEMA);
    for kind in ROW_FILES {
        let by = kind.player.map(|player| format!(", played by {player}"));
        let title = kind.files[0].to_owned() + &by.unwrap_or_default();
        file(&mut page, &title, kind.description, kind.columns);
    }
    page
}

/// A file with its columns.
fn file(page: &mut String, title: &str, description: &str, columns: &[Column]) {
    write!(page, "\n## {title}\n\n{description}\n\n").unwrap();
    page.push_str("| column | unit | entries | meaning |\n|---|---|---|---|\n");
    for column in columns {
        let (name, unit) = (column.name, Field::of(column).unit.unwrap_or_default());
        let entries = match (column.words, column.entry) {
            ([], EntryType::Integer) => "whole numbers".to_owned(),
            ([], EntryType::Number) => "numbers".to_owned(),
            ([], EntryType::Boolean) => "`true`, `false`".to_owned(),
            ([], EntryType::String) => "text".to_owned(),
            (words, _) => format!("`{}`", words.join("`, `")),
        };
        let empty = match column.is_required {
            true => "",
            false => ", or empty",
        };
        let meaning = column.meaning();
        writeln!(page, "| `{name}` | {unit} | {entries}{empty} | {meaning} |").unwrap();
    }
}

fn help(command: &str) -> String {
    let mut program = Command::new(env!("CARGO_BIN_EXE_webloop"));
    let output = program
        .args(command.split_whitespace())
        .arg("--help")
        .output();
    String::from_utf8(output.unwrap().stdout).unwrap()
}

/// The commands that a help text lists, without `help` itself.
fn listed(help: &str) -> Vec<&str> {
    // The program's own stand in groups, before its options.
    let (before, _) = help.split_once("\nOptions:\n").unwrap_or((help, ""));
    // A name is two spaces in; further in is the rest of a description, and an argument has brackets.
    let names = before
        .lines()
        .filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
    names
        .filter(|name| name.starts_with(|c: char| c.is_ascii_lowercase()) && *name != "help")
        .collect()
}

fn of_commands() -> String {
    let top = help("");
    let mut page = format!("# Commands\n\n```text\n{}\n```\n", top.trim());
    for name in listed(&top) {
        let text = help(name);
        write!(page, "\n## {name}\n\n```text\n{}\n```\n", text.trim()).unwrap();
        for inner in listed(&text) {
            let both = format!("{name} {inner}");
            let text = help(&both);
            write!(page, "\n### {both}\n\n```text\n{}\n```\n", text.trim()).unwrap();
        }
    }
    page
}

fn of_schema(title: &str, path: &str, schema: &Value) -> String {
    let mut page = format!("# {title}\n\nFrom [{path}](../../{path}), for editors.\n");
    describe(&mut page, schema);
    let definitions = schema["$defs"].as_object().into_iter().flatten();
    for (name, definition) in definitions {
        write!(page, "\n## {name}\n").unwrap();
        describe(&mut page, definition);
    }
    page
}

/// A definition: its meaning, and its keys or what it may be.
fn describe(page: &mut String, definition: &Value) {
    let meaning = sentence(definition);
    if !meaning.is_empty() {
        write!(page, "\n{meaning}\n").unwrap();
    }
    if let Some(keys) = definition["properties"].as_object() {
        table(page, keys, &definition["required"]);
    } else if let Some(choices) = choices(definition) {
        page.push('\n');
        for choice in choices {
            let meaning = sentence(choice);
            let separator = if meaning.is_empty() { "" } else { ": " };
            writeln!(page, "- {}{separator}{meaning}", kind(choice)).unwrap();
        }
    } else {
        write!(page, "\n{}\n", kind(definition)).unwrap();
    }
}

fn table(page: &mut String, keys: &Map<String, Value>, required: &Value) {
    let required: Vec<&str> = required.as_array().map_or_else(Vec::new, |names| {
        names.iter().filter_map(Value::as_str).collect()
    });
    page.push_str("\n| key | value | meaning |\n|---|---|---|\n");
    for (key, value) in keys {
        let needed = if required.contains(&key.as_str()) {
            ", required"
        } else {
            ""
        };
        let (kind, meaning) = (kind(value), sentence(value));
        writeln!(page, "| `{key}` | {kind}{needed} | {meaning} |").unwrap();
    }
}

/// A description on one line.
fn sentence(value: &Value) -> String {
    let text = value["description"].as_str().unwrap_or_default();
    let words: Vec<&str> = text.split_whitespace().collect();
    words.join(" ").replace('|', "\\|")
}

fn choices(value: &Value) -> Option<&Vec<Value>> {
    value["oneOf"].as_array().or(value["anyOf"].as_array())
}

/// What a value may be, in words.
fn kind(value: &Value) -> String {
    if let Some(to) = value["$ref"].as_str() {
        let name = to.rsplit('/').next().unwrap_or_default();
        return format!("[{name}](#{})", name.to_lowercase());
    }
    if let Some(choices) = choices(value) {
        let kinds: Vec<String> = choices.iter().map(kind).collect();
        let known = kinds.iter().filter(|kind| *kind != "nothing");
        return known.cloned().collect::<Vec<_>>().join(" or ");
    }
    if let Some(constant) = value.get("const") {
        return format!("`{}`", constant.to_string().trim_matches('"'));
    }
    if let Some(words) = value["enum"].as_array() {
        let words = words.iter().filter_map(Value::as_str);
        return words
            .map(|word| format!("`{word}`"))
            .collect::<Vec<_>>()
            .join(", ");
    }
    if let Some(keys) = value["properties"].as_object() {
        let keys = keys.iter().map(|(key, value)| match value["properties"] {
            Value::Object(_) => format!("`{key}` with {}", kind(value)),
            _ => format!("`{key}` ({})", kind(value)),
        });
        return keys.collect::<Vec<_>>().join(", ");
    }
    let names = match &value["type"] {
        Value::String(name) => vec![name.as_str()],
        Value::Array(names) => names.iter().filter_map(Value::as_str).collect(),
        _ => Vec::new(),
    };
    if names == ["null"] {
        return "nothing".to_owned();
    }
    let words = names.into_iter().filter(|name| *name != "null");
    let words: Vec<String> = words.map(|name| word(name, value)).collect();
    if words.is_empty() {
        "any value".to_owned()
    } else {
        words.join(" or ")
    }
}

/// The word for a type of JSON.
fn word(name: &str, value: &Value) -> String {
    match name {
        "string" => "text".to_owned(),
        "integer" => "whole number".to_owned(),
        "boolean" => "true or false".to_owned(),
        "object" => "table".to_owned(),
        "array" if value["items"].is_object() => format!("list of {}", kind(&value["items"])),
        "array" => "list".to_owned(),
        other => other.to_owned(),
    }
}
