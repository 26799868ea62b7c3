//! Which key of a TOML text a place belongs to.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The dotted path of the innermost key whose name or value contains `span`; empty if there is none, if the text is
/// not TOML, or if `span` is empty. Places in a list have the list's key.
pub(crate) fn at(text: &str, span: &Range<usize>) -> String {
    if span.is_empty() {
        return String::new();
    }
    let Ok(table) = DeTable::parse(text) else {
        return String::new();
    };
    let mut found = Innermost {
        span,
        length: usize::MAX,
        path: String::new(),
    };
    found.table(table.get_ref(), "");
    found.path
}

/// The innermost key so far.
struct Innermost<'a> {
    span: &'a Range<usize>,
    /// Bytes of its value.
    length: usize,
    path: String,
}

impl Innermost<'_> {
    /// A table's span is only that of its head, so what is in it is looked at in any case.
    fn table(&mut self, table: &DeTable<'_>, path: &str) {
        for (key, value) in table {
            let name = key.get_ref();
            let path = match path {
                "" => name.to_string(),
                path => format!("{path}.{name}"),
            };
            self.take(&key.span(), &path);
            self.value(value, &path);
        }
    }

    fn value(&mut self, value: &Spanned<DeValue<'_>>, path: &str) {
        self.take(&value.span(), path);
        match value.get_ref() {
            DeValue::Table(table) => self.table(table, path),
            DeValue::Array(values) => values.iter().for_each(|value| self.value(value, path)),
            _ => {}
        }
    }

    fn take(&mut self, own: &Range<usize>, path: &str) {
        let contains = own.start <= self.span.start && self.span.end <= own.end;
        if contains && own.len() <= self.length {
            self.length = own.len();
            path.clone_into(&mut self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_has_the_key_that_it_is_under() {
        let text = "name = 'a'\n[[cells]]\nh = ['1ms', '2ms']\nscaled = { repeats = 7 }\n[both]\ndelay.hold = '9ms'\n";
        for (part, path) in [
            ("'a'", "name"),
            ("'2ms'", "cells.h"),
            ("7", "cells.scaled.repeats"),
            ("'9ms'", "both.delay.hold"),
            ("hold", "both.delay.hold"),
            ("[both]", "both"),
        ] {
            let start = text.find(part).expect(part);
            assert_eq!(at(text, &(start..start + part.len())), path, "{part}");
        }
        assert_eq!(at(text, &(0..0)), "");
        assert_eq!(at("a = ", &(0..1)), "");
    }
}
