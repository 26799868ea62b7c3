//! Message rows as a page sends them: lines of CSV, read strictly.
//!
//! Everything that can be checked is checked: each field must be a number of its kind, and a row must
//! have exactly the fields that its outcome requires. The columns are those of [`MessageRow`]; there
//! is no header, and no quotes, since no field needs them.

use endpoint::{MessageOutcome, MessageRow};
use text::column::strict::BadLine;
use text::column::{BadEntry, Row};

/// Why rows were rejected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {problem}")]
pub(crate) struct InvalidRow {
    /// Number of the line, from 1.
    line: usize,
    problem: Problem,
}

#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
enum Problem {
    #[error("not UTF-8; rows are digits, commas and words")]
    Text,
    #[error(transparent)]
    Line(#[from] BadLine),
    #[error("field `outcome`: `{0}` is unknown; choose answered, timeout, failed or missed")]
    Outcome(String),
    #[error("field `{field}` is empty; in this {outcome} row it has a value")]
    Empty {
        field: &'static str,
        outcome: MessageOutcome,
    },
    #[error("field `{field}` has a value; in this {outcome} row it is empty")]
    Surplus {
        field: &'static str,
        outcome: MessageOutcome,
    },
    #[error("field `t_receive_ns`: {t_receive_ns} is before t_send_ns = {t_send_ns}")]
    Order { t_send_ns: u64, t_receive_ns: u64 },
}

/// Reads all rows of a chunk, or none.
pub(crate) fn read(bytes: &[u8]) -> Result<Vec<MessageRow>, InvalidRow> {
    let mut rows = Vec::new();
    let whole = bytes.strip_suffix(b"\n").unwrap_or(bytes);
    if bytes.is_empty() {
        return Ok(rows);
    }
    for (line, bytes) in (1..).zip(whole.split(|byte| *byte == b'\n')) {
        let row = str::from_utf8(bytes.strip_suffix(b"\r").unwrap_or(bytes))
            .map_err(|_| Problem::Text)
            .and_then(row);
        rows.push(row.map_err(|problem| InvalidRow { line, problem })?);
    }
    Ok(rows)
}

fn row(line: &str) -> Result<MessageRow, Problem> {
    let row = MessageRow::strict(line).map_err(|problem| match problem {
        // A page knows of its answers, so a message of its has not just arrived.
        BadLine::Entry {
            problem: BadEntry::Word { text, .. },
            ..
        } => Problem::Outcome(text),
        problem => Problem::Line(problem),
    })?;
    consistent(&row)?;
    Ok(row)
}

/// Checks that a row has exactly the fields that its outcome requires.
fn consistent(row: &MessageRow) -> Result<(), Problem> {
    let outcome = row.outcome;
    let (sent, answered) = match outcome {
        MessageOutcome::Answered => (true, true),
        MessageOutcome::Timeout | MessageOutcome::Failed => (true, false),
        MessageOutcome::Missed => (false, false),
        MessageOutcome::Arrived => return Err(Problem::Outcome(outcome.to_string())),
    };
    // In open loop no row has any of y, e and tick.
    let closed = row.y.is_some();
    let expected = [
        ("t_send_ns", row.t_send_ns.is_some(), sent),
        ("t_receive_ns", row.t_receive_ns.is_some(), answered),
        ("t_arrive_ns", row.t_arrive_ns.is_some(), answered),
        ("y", row.y.is_some(), sent && closed),
        ("e", row.e.is_some(), sent && closed),
        ("u", row.u.is_some(), sent),
        ("tick", row.tick.is_some(), answered && closed),
    ];
    for (field, given, expected) in expected {
        match (given, expected) {
            (false, true) => return Err(Problem::Empty { field, outcome }),
            (true, false) => return Err(Problem::Surplus { field, outcome }),
            _ => {}
        }
    }
    match (row.t_send_ns, row.t_receive_ns) {
        (Some(t_send_ns), Some(t_receive_ns)) if t_receive_ns < t_send_ns => Err(Problem::Order {
            t_send_ns,
            t_receive_ns,
        }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOSED: &str = "7,100,110,150,130,1,0.5,0.5,0.0850,3,answered,6";

    #[test]
    fn rows_of_both_modes_and_all_outcomes_are_read() {
        let text = [
            CLOSED,
            "8,200,210,250,230,1.0,,,1,,answered,\r",
            "9,300,310,,,1,-1e-7,1.0000001,1.5e+22,,timeout,",
            "10,400,410,,,1,,,1,,failed,",
            "11,500,,,,1,,,,,missed,",
        ]
        .join("\n");
        let rows = read(text.as_bytes()).expect("rows");
        assert_eq!(read(format!("{text}\n").as_bytes()), Ok(rows.clone()));
        assert_eq!(
            rows[0],
            MessageRow {
                seq: 7,
                t_due_ns: 100,
                t_send_ns: Some(110),
                t_receive_ns: Some(150),
                t_arrive_ns: Some(130),
                r: 1.0,
                y: Some(0.5),
                e: Some(0.5),
                u: Some(0.085),
                tick: Some(3),
                outcome: MessageOutcome::Answered,
                y_seq: Some(6),
            }
        );
        assert_eq!((rows[2].y, rows[2].u), (Some(-1e-7), Some(1.5e22)));
        assert_eq!(rows[4].outcome, MessageOutcome::Missed);
        assert_eq!(
            read(b""),
            Ok(Vec::new()),
            "a page may only say that it is there"
        );
    }

    #[test]
    fn a_bad_row_is_refused_by_line_and_field() {
        // The second line, and the expected error.
        let table = [
            ("", "1 fields; a row has the 12: seq,t_due_ns,"),
            ("1,2,3", "3 fields"),
            (&format!("{CLOSED},"), "13 fields"),
            ("-1,100,,,,1,,,,,missed,", "`seq`: `-1` is not a whole"),
            ("+1,100,,,,1,,,,,missed,", "`seq`: `+1` is not a whole"),
            (",100,,,,1,,,,,missed,", "`seq`: `` is not a whole"),
            ("1,1e3,,,,1,,,,,missed,", "`t_due_ns`: `1e3`"),
            ("1,18446744073709551616,,,,1,,,,,missed,", "`t_due_ns`"),
            ("1,100,,,,,,,,,missed,", "`r`: `` is not a finite"),
            ("1,100,,,,inf,,,,,missed,", "`r`: `inf` is not a finite"),
            ("1,100,,,,1e999,,,,,missed,", "`r`: `1e999`"),
            ("1,100,,,,\"1\",,,,,missed,", "`r`: `\\\"1\\\"`"),
            ("1,100,,,,1,,,,,Missed,", "`outcome`: `Missed` is unknown"),
            ("1,100,,,,1,,,,,,", "`outcome`: `` is unknown"),
            (
                "1,100,110,,,1,,,,,missed,",
                "`t_send_ns` has a value; in this missed",
            ),
            (
                "1,100,,,,1,0,1,,,missed,",
                "`y` has a value; in this missed",
            ),
            ("1,100,,,,1,,,0.1,,missed,", "`u` has a value"),
            (
                "1,100,,,,1,0,1,0.1,,failed,",
                "`t_send_ns` is empty; in this failed",
            ),
            (
                "1,100,110,150,,1,0,1,0.1,,timeout,",
                "`t_receive_ns` has a value; in this timeout",
            ),
            (
                "1,100,110,,130,1,0,1,0.1,,failed,",
                "`t_arrive_ns` has a value",
            ),
            ("1,100,110,,,1,0,1,0.1,4,failed,", "`tick` has a value"),
            ("1,100,110,,,1,0,1,,,failed,", "`u` is empty"),
            ("1,100,110,150,130,1,0,,0.1,4,answered,", "`e` is empty"),
            ("1,100,110,150,130,1,,1,0.1,,answered,", "`e` has a value"),
            (
                "1,100,110,150,130,1,0,1,0.1,,answered,",
                "`tick` is empty; in this answered",
            ),
            (
                "1,100,110,150,130,1,,,0.1,4,answered,",
                "`tick` has a value",
            ),
            (
                "1,100,110,,130,1,0,1,0.1,4,answered,",
                "`t_receive_ns` is empty",
            ),
            (
                "1,100,110,109,130,1,0,1,0.1,4,answered,",
                "109 is before t_send_ns = 110",
            ),
            ("1,100,110,150,130,NaN,0,1,0.1,4,answered,", "`r`: `NaN`"),
            ("1,100,110,150,130,1,0,1,0.1,4,answered,x", "`y_seq`: `x`"),
        ];
        for (line, says) in table {
            let error = read(format!("{CLOSED}\n{line}\n{CLOSED}\n").as_bytes());
            let error = error.expect_err(line).to_string();
            assert!(error.starts_with("line 2: "), "{line}: {error}");
            assert!(error.contains(says), "{line}: {error}");
        }
        let error = read(b"\xff\n").expect_err("no text").to_string();
        assert!(error.contains("line 1: not UTF-8"), "{error}");
        assert!(read(b"\n").is_err(), "an empty line is no row");
    }
}
