//! A report of any structure as a list: each value with the path of names that leads to it.

use serde::Serialize;
use serde_json::Value;

use crate::number::brief;

/// The values with their paths, in the order of the names: `counts.sent 1334`.
pub(super) fn leaves(report: &impl Serialize) -> Vec<(String, String)> {
    // A report is plain data, so this cannot fail. A null value has no leaves.
    let value = serde_json::to_value(report).unwrap_or_default();
    let mut leaves = Vec::new();
    collect(&value, "", &mut leaves);
    leaves
}

fn collect(value: &Value, name: &str, leaves: &mut Vec<(String, String)>) {
    let text = match value {
        Value::Object(fields) => {
            for (field, value) in fields {
                let name = match name {
                    "" => field.clone(),
                    name => format!("{name}.{field}"),
                };
                collect(value, &name, leaves);
            }
            return;
        }
        Value::Null => return,
        Value::String(text) if text.is_empty() => return,
        Value::String(text) => text.clone(),
        Value::Number(number) => match number.as_f64().filter(|_| number.is_f64()) {
            Some(x) => brief(x),
            None => number.to_string(),
        },
        Value::Bool(_) | Value::Array(_) => value.to_string(),
    };
    leaves.push((name.to_owned(), text));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_named_by_its_way_and_nothing_is_left_out() {
        let report = serde_json::json!({
            "counts": {"sent": 1334, "rate": 332.999_123_4, "r": 1.0}, "page": null, "why": "", "ok": true,
        });
        let lines: Vec<String> = leaves(&report)
            .iter()
            .map(|(name, text)| format!("{name} {text}"))
            .collect();
        assert_eq!(
            lines,
            [
                "counts.r 1",
                "counts.rate 333.0",
                "counts.sent 1334",
                "ok true"
            ]
        );
    }
}
