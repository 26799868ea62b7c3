//! Reads a line that somebody else wrote: each entry has to be one of its column's, and an error says which is not.
//!
//! There are no quotes, since no entry needs them.

use crate::column::bad_entry::BadEntry;
use crate::column::value::Value;

/// Why a line is not a row.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BadLine {
    /// It has more or fewer fields.
    #[error("{given} fields; a row has the {}: {}", columns.len(), columns.join(","))]
    Fields {
        /// How many it has.
        given: usize,
        /// The columns.
        columns: &'static [&'static str],
    },
    /// A field is no entry of its column.
    #[error("field `{column}`: {problem}")]
    Entry {
        /// The column.
        column: &'static str,
        /// What is wrong.
        problem: BadEntry,
    },
}

/// The fields of a line, taken one after the other.
#[derive(Debug)]
pub struct Unread<'a>(std::str::Split<'a, char>);

impl<'a> Unread<'a> {
    /// Those of a line without its end.
    ///
    /// # Errors
    /// [`BadLine::Fields`] if there are not as many as columns.
    pub fn of(line: &'a str, columns: &'static [&'static str]) -> Result<Unread<'a>, BadLine> {
        let fields = line.split(',');
        let given = fields.clone().count();
        match given == columns.len() {
            true => Ok(Unread(fields)),
            false => Err(BadLine::Fields { given, columns }),
        }
    }

    /// The next one, of this column.
    ///
    /// # Errors
    /// [`BadLine::Entry`] if it is none of its column.
    pub fn next<T: Value>(&mut self, column: &'static str) -> Result<T, BadLine> {
        let text = self.0.next().unwrap_or_default();
        T::strict(text).map_err(|problem| BadLine::Entry { column, problem })
    }
}

#[cfg(test)]
#[allow(unreachable_pub)] // Rows are public.
mod tests {
    use crate::column::row::Row;

    crate::row!(
        /// A row.
        Sample {
            /// Its number.
            n: u32,
            /// What it was.
            x: f64,
            /// Whether it was whole.
            whole: bool,
        } later {
            /// When it came; older files do not have it.
            t_ns: Option<u64>,
        }
    );

    #[test]
    fn a_line_is_read_as_it_is_written() {
        let sample = Sample {
            n: 7,
            x: -0.25,
            whole: true,
            t_ns: None,
        };
        let mut text = Vec::new();
        sample.write(&mut text);
        assert_eq!(text, b"7,-0.25,true,\n");
        assert_eq!(Sample::strict("7,-0.25,true,"), Ok(sample));
        assert_eq!(Sample::plain(b"7,-0.25,true,"), Some(sample));
        assert_eq!((Sample::NEW, Sample::COLUMNS.last()), (1, Some(&"t_ns")));
        assert_eq!(Sample::SCHEMA.len(), Sample::COLUMNS.len());
    }

    #[test]
    fn what_is_no_row_is_told_by_its_column() {
        for (line, says) in [
            ("7,1,true", "3 fields; a row has the 4: n,x,whole,t_ns"),
            (
                "4294967296,1,true,",
                "field `n`: `4294967296` is not a whole number from 0 to 4294967295",
            ),
            ("+7,1,true,", "field `n`: `+7` is not a whole"),
            ("7,inf,true,", "field `x`: `inf` is not a finite"),
            (
                "7,1,yes,",
                "field `whole`: `yes` is unknown; choose one of true, false",
            ),
            (
                "7,1,true,-1",
                "field `t_ns`: `-1` is not a whole number from 0 to 18446744073709551615",
            ),
        ] {
            let problem = Sample::strict(line).expect_err(line).to_string();
            assert!(problem.starts_with(says), "{line}: {problem}");
        }
    }
}
