//! Files of before sweeps were experiments, written as experiments.

use toml::{Table, Value};

/// What stood beside the axes, and is in the table `[sweep]` now.
const BESIDE: [&str; 4] = ["duration", "repeats", "rho", "hold"];

/// The experiment that a sweep of before is now, in TOML; `None` for any other text. What is wrong with it stays so.
#[must_use]
pub fn renewed(text: &str) -> Option<String> {
    let mut file: Table = text.parse().ok()?;
    let Value::Table(axes) = file.remove("axes")? else {
        return None;
    };
    let mut sweep: Table = axes
        .into_iter()
        .map(|(axis, given)| (axis, steps(&given).map_or(given, Value::String)))
        .collect();
    for key in BESIDE {
        if let Some(value) = file.remove(key) {
            sweep.insert(key.to_owned(), value);
        }
    }
    file.insert("sweep".to_owned(), Value::Table(sweep));
    toml::to_string(&file).ok()
}

/// The words for steps that were a table; `None` for what is none.
fn steps(given: &Value) -> Option<String> {
    let of = |key: &str| {
        given.get(key).map(|value| match value {
            Value::String(text) => text.clone(),
            number => number.to_string(),
        })
    };
    let log = match of("scale").as_deref() {
        None | Some("linear") => "",
        Some("log") => " log",
        Some(_) => return None,
    };
    let (count, from, to) = (of("steps")?, of("from")?, of("to")?);
    Some(format!("{count}{log} from {from} to {to}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_of_before_is_written_as_an_experiment() {
        let old = "name = \"a\"\nduration = \"1s\"\nseed = 3\nrho = 0.5\n[axes]\nkp = { from = 0.05, to = 0.5, steps = 10, scale = \"log\" }\n\
                   rtt = { from = \"0ms\", to = \"40ms\", steps = 21 }\nh = [\"1ms\", \"3ms\"]\n";
        let new = "name = \"a\"\nseed = 3\n\n[sweep]\nduration = \"1s\"\nh = [\"1ms\", \"3ms\"]\nkp = \"10 log from 0.05 to 0.5\"\nrho = 0.5\n\
                   rtt = \"21 from 0ms to 40ms\"\n";
        assert_eq!(renewed(old).as_deref(), Some(new));
    }

    #[test]
    fn other_texts_are_left_alone() {
        for text in [
            "name = \"a\"\n[[cells]]\n",
            "name = \"a\"\n[sweep]\n",
            "name = ",
            "axes = 1",
        ] {
            assert_eq!(renewed(text), None);
        }
    }
}
