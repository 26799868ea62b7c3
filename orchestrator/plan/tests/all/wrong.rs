//! A setting of the wrong type, or out of range, in every file that people write: the answer names the key, what is
//! wrong and what would be right, and no type of the program.

use endpoint::{ControllerSettings, PageSettings, PlantSettings};
use link::{Profile, Severity};
use plan::system::System;
use plan::{EXPERIMENTS, Plan, ProfileText};
use text::Diagnostic;
use toml::{Table, Value};

/// An experiment with what the built-in ones do not all have.
const EXPERIMENT: &str = r#"
name = "a"
about = "Everything."
seed = 3
expect = { holds = "all", settling = "<= 400ms", rtt.p99 = "<= 60ms", confidence = "95%" }
fault = [{ name = "f", about = "A fault.", event = [
    { at = "1s", for = "1s", down = true, times = 2, every = "2s", way = "up" },
    { at = "1s", for = "1s", starve = "plant", share = "50%" },
] }]
known = [{ cells = "arima", expect = "holds", reason = "it is so", until = "2027-06-30" }]
cells = [{ topology = "arima", system = "motor", client = ["native", { name = "mine", run = ["./mine"] }], mode = "closed",
    h = "3ms", duration = "2s", preset = "many", repeats = 2, together = 3, fault = ["none", "f"],
    scaled = { duration = "1s", repeats = 1 }, expect = { survives = "all" } }]
"#;

/// What no setting is, or few are.
fn wrong() -> [Value; 9] {
    [
        Value::Boolean(true),
        Value::Integer(-1),
        Value::Integer(99_999_999_999),
        Value::Float(-0.5),
        Value::Float(f64::NAN),
        Value::String("no such thing".to_owned()),
        Value::Array(vec![Value::Array(Vec::new())]),
        Value::Array(vec![
            Value::Boolean(false),
            Value::Integer(7),
            Value::Integer(8),
        ]),
        Value::Table(Table::from_iter([("odd".to_owned(), Value::Integer(1))])),
    ]
}

/// The text with each of its values replaced by each wrong one.
fn spoilt(text: &str, more: &[&str]) -> Vec<(String, String)> {
    let whole = Value::Table(text.parse().expect("TOML"));
    let mut places = Vec::new();
    walk(&whole, &mut Vec::new(), &mut places);
    places.extend(
        more.iter()
            .map(|key| vec!["cells".to_owned(), "0".to_owned(), (*key).to_owned()]),
    );
    let texts = places.iter().flat_map(|place| {
        let whole = &whole;
        wrong().into_iter().map(move |value| {
            let mut whole = whole.clone();
            put(&mut whole, place, value);
            (place.join("."), toml::to_string(&whole).expect("TOML"))
        })
    });
    texts.collect()
}

fn walk(value: &Value, path: &mut Vec<String>, places: &mut Vec<Vec<String>>) {
    let parts: Vec<(String, &Value)> = match value {
        Value::Table(table) => table
            .iter()
            .map(|(key, value)| (key.clone(), value))
            .collect(),
        Value::Array(values) => values
            .iter()
            .enumerate()
            .map(|(at, value)| (at.to_string(), value))
            .collect(),
        _ => Vec::new(),
    };
    for (key, part) in parts {
        path.push(key);
        places.push(path.clone());
        walk(part, path, places);
        path.pop();
    }
}

fn put(whole: &mut Value, place: &[String], value: Value) {
    let Some((key, rest)) = place.split_first() else {
        *whole = value;
        return;
    };
    let part = match whole {
        Value::Table(table) => table.entry(key.clone()).or_insert(Value::Integer(0)),
        Value::Array(values) => &mut values[key.parse::<usize>().expect("an index")],
        _ => unreachable!("the place is one of this text"),
    };
    put(part, rest, value);
}

/// Holds what is said of a text against what an answer has to be.
fn check(place: &str, source: &str, said: &Diagnostic) {
    const FOREIGN: [&str; 21] = [
        "u8",
        "u16",
        "u32",
        "u64",
        "usize",
        "i32",
        "i64",
        "f32",
        "f64",
        "string",
        "boolean",
        "sequence",
        "map",
        "struct",
        "enum",
        "untagged",
        "variant",
        "tuple",
        "expected",
        "Option",
        "deserialize",
    ];
    let line = said.to_string();
    let mut words = line.split(|c: char| !c.is_alphanumeric() && c != '-');
    let foreign = words.find(|word| FOREIGN.contains(word));
    assert_eq!(foreign, None, "{place}: {line}\n{source}");
    assert!(!said.field.is_empty(), "{place}: no key: {line}\n{source}");
    let has_remedy = !said.remedy.is_empty()
        || ["; ", "write", "give", "use", "drop"]
            .iter()
            .any(|word| said.problem.contains(word));
    assert!(has_remedy, "{place}: no remedy: {line}\n{source}");
}

fn profile(name: &str) -> Result<ProfileText, String> {
    let source = Profile::builtin(name).ok_or_else(|| format!("there is no topology `{name}`"))?;
    Ok(ProfileText {
        source: source.to_owned(),
        ..ProfileText::default()
    })
}

#[test]
fn a_wrong_value_in_a_profile_is_answered_in_plain_words() {
    for name in Profile::BUILTIN.iter().chain(Profile::READINGS) {
        for (place, source) in spoilt(Profile::builtin(name).expect("built in"), &[]) {
            let (_, said) = Profile::read(&source, "a.toml", &|_| Err("no file".to_owned()));
            let errors = said.iter().filter(|said| said.severity == Severity::Error);
            errors.for_each(|said| check(&place, &source, said));
        }
    }
}

#[test]
fn a_wrong_value_in_a_system_is_answered_in_plain_words() {
    for name in System::built_in_names() {
        for (place, source) in spoilt(System::built_in(name).expect("built in"), &[]) {
            if let Err(said) = System::read(&source) {
                check(&place, &source, &said);
            }
        }
    }
}

#[test]
fn a_wrong_value_in_an_experiment_is_answered_in_plain_words() {
    let of_plant = PlantSettings::lists().map(|(field, _)| field.option.name);
    let of_all = ControllerSettings::FIELDS.iter().map(|field| field.name);
    let of_page = PageSettings::FIELDS.iter().map(|field| field.name);
    let more: Vec<&str> = of_plant
        .chain(of_all)
        .chain(of_page)
        .chain(["stall_met"])
        .collect();
    for (place, source) in spoilt(EXPERIMENT, &more) {
        if let Err(said) = Plan::resolve(&source, "a.toml", &plan::Instead::default(), profile) {
            check(&place, &source, &said);
        }
    }
}

/// A sweep of before sweeps were experiments.
const OLD: &str = r#"
name = "old"
about = "What is read still."
duration = "10s"
repeats = 5
rho = 0.5
hold = "20ms"
[axes]
rtt = "40ms"
jitter = { from = "0ms", to = "40ms", steps = 21 }
kp = { from = 0.05, to = 0.5, steps = 10, scale = "log" }
h = ["1ms", "3ms"]
outstanding = [1, "unlimited"]
"#;

#[test]
fn a_wrong_value_in_a_sweep_is_answered_in_plain_words() {
    let sweeps = EXPERIMENTS.iter().map(|(_, text)| *text);
    let sweeps: Vec<&str> = sweeps.filter(|text| text.contains("[sweep]")).collect();
    assert_eq!(sweeps.len(), 5);
    for text in sweeps.into_iter().chain([OLD]) {
        for (place, source) in spoilt(text, &[]) {
            let source = plan::sweep::renewed(&source).unwrap_or(source);
            if let Err(said) = Plan::resolve(&source, "a.toml", &plan::Instead::default(), profile)
            {
                check(&place, &source, &said);
            }
        }
    }
}
