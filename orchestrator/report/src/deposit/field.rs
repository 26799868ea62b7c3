//! A column of a CSV file, as Table Schema describes it.

use serde::Serialize;
use text::column::{Column, EntryType};

/// A column.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Field {
    /// Its name in the header.
    pub name: String,
    /// The type of its entries.
    #[serde(rename = "type")]
    pub kind: EntryType,
    /// The unit, from its name; `None` for counts, shares, words, and dimensionless quantities.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// What it means.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub description: String,
    /// Constraints on every entry.
    #[serde(skip_serializing_if = "Constraints::is_none")]
    pub constraints: Constraints,
}

/// Constraints on every entry of a column.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Constraints {
    /// Whether no entry is empty.
    #[serde(skip_serializing_if = "is_false")]
    pub required: bool,
    /// The words that are allowed; empty if any are.
    #[serde(rename = "enum", skip_serializing_if = "Vec::is_empty")]
    pub words: Vec<&'static str>,
}

impl Constraints {
    fn is_none(&self) -> bool {
        *self == Constraints::default()
    }
}

// Serde passes a reference.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_false(x: &bool) -> bool {
    !x
}

impl Field {
    /// A column with its unit from its name.
    #[must_use]
    pub fn new(name: &str, kind: EntryType, description: &str) -> Field {
        Field {
            name: name.to_owned(),
            kind,
            unit: unit(name).map(str::to_owned),
            description: description.to_owned(),
            constraints: Constraints::default(),
        }
    }

    /// A column of a file that webloop writes, as its rows declare it.
    #[must_use]
    pub fn of(column: &Column) -> Field {
        Field {
            constraints: Constraints {
                required: column.is_required,
                words: column.words.to_vec(),
            },
            ..Field::new(column.name, column.entry, &column.meaning())
        }
    }
}

/// The unit that ends a column's name: `settling_ms`, `avg/ms`.
fn unit(name: &str) -> Option<&str> {
    let (_, last) = name.rsplit_once(['_', '/'])?;
    match last {
        "ns" | "us" | "ms" | "s" | "Hz" | "%" => Some(last),
        "pct" => Some("%"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_is_what_a_name_ends_in_after_a_sign() {
        let cases = [
            ("t_due_ns", Some("ns")),
            ("iae_s", Some("s")),
            ("ise_s", Some("s")),
            ("overshoot_pct", Some("%")),
            ("the paper avg/ms", Some("ms")),
            ("zero_1ms", None),
            ("ticks", None),
            ("s", None),
        ];
        for (name, expected) in cases {
            assert_eq!(unit(name), expected, "{name}");
        }
    }
}
