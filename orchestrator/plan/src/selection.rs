//! Selects cells of a plan, as `--only` and `--cells` ask.
//!
//! The plan stays whole, whatever is selected. So the folders of several runs, each with some of its
//! cells, have the same plan and can be merged by copying them into one.

use crate::cell::Cell;

/// A selection of a plan's cells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Selection {
    /// All cells.
    All,
    /// Cells whose id matches one of these patterns.
    ///
    /// A pattern is a part of an id, or a whole id in which `*` stands for any text.
    Matching(Vec<String>),
    /// Cells with these indices.
    Numbered(Vec<usize>),
}

impl Selection {
    /// Whether the selection includes this cell.
    #[must_use]
    pub fn takes(&self, cell: &Cell) -> bool {
        match self {
            Selection::All => true,
            Selection::Matching(patterns) => {
                patterns.iter().any(|pattern| matches(pattern, &cell.id))
            }
            Selection::Numbered(indices) => indices.contains(&cell.index),
        }
    }
}

/// In words that follow "no cell matches".
impl std::fmt::Display for Selection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Selection::All => f.write_str("anything"),
            Selection::Matching(patterns) => f.write_str(&patterns.join(" or ")),
            Selection::Numbered(indices) => {
                let indices: Vec<_> = indices.iter().map(usize::to_string).collect();
                write!(f, "number {}", indices.join(" or "))
            }
        }
    }
}

/// Whether `id` contains `pattern` or, if the pattern has a `*`, matches it as a whole.
pub(crate) fn matches(pattern: &str, id: &str) -> bool {
    if !pattern.contains('*') {
        return id.contains(pattern);
    }
    let mut parts = pattern.split('*');
    let first = parts.next().unwrap_or("");
    let Some(mut rest) = id.strip_prefix(first) else {
        return false;
    };
    let parts: Vec<_> = parts.collect();
    let (last, middle) = parts.split_last().map_or(("", &[][..]), |(l, m)| (*l, m));
    for part in middle {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.ends_with(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pattern_is_a_part_of_an_id_or_spells_the_whole_with_stars() {
        let id = "couva-native-closed-333hz-r01-3fa2c1";
        for pattern in ["couva", "333hz", "couva*", "*closed*", "couva*r01*", "*"] {
            assert!(matches(pattern, id), "{pattern}");
        }
        for pattern in [
            "buccoo",
            "native*",
            "*333hz",
            "couva*open*",
            "couva*closed*closed*",
        ] {
            assert!(!matches(pattern, id), "{pattern}");
        }
    }
}
