//! Rows are read as the csv crate and serde read them, whatever is in the file.

use std::fmt::Debug;
use std::fs;

use endpoint::{ArrivalOutcome, ArrivalRow, MessageOutcome, MessageRow, TickRow};
use plan::{Phase, ProbeRow};
use proptest::prelude::*;
use proptest::sample::{Index, select};
use record::ReadError;
use record::rows::read;
use serde::Serialize;
use text::column::Row;

/// The rows before an error, and the error's line and words. Rows are compared as they print, which
/// tells apart all numbers and keeps NaN equal to itself.
type Outcome = (Vec<String>, Option<(u64, String)>);

fn outcome<R: Row + Debug>(text: &[u8]) -> Outcome {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("rows.csv");
    fs::write(&path, text).expect("a writable folder");
    let mut rows = Vec::new();
    let end = read(&path, |row: &R| rows.push(format!("{row:?}")));
    let error = end.err().map(|error| match error {
        ReadError::Row { line, problem, .. } => (line, problem),
        ReadError::Columns { .. } => (1, "columns".to_owned()),
        ReadError::File { .. } | ReadError::Damaged { .. } => panic!("a readable file: {error}"),
    });
    (rows, error)
}

/// The same by nothing but the csv crate and serde, from the first line to the last whole one.
fn expected<R: Row + Debug>(text: &[u8]) -> Outcome {
    let whole = text.iter().rposition(|byte| *byte == b'\n');
    let mut reader = csv::Reader::from_reader(&text[..whole.map_or(0, |at| at + 1)]);
    let mut rows = Vec::new();
    match reader.headers() {
        Ok(header) if whole.is_none() || header.iter().eq(R::COLUMNS.iter().copied()) => {}
        // A file from before some of the last columns.
        Ok(header)
            if (1..=R::NEW).any(|lacking| {
                let older = &R::COLUMNS[..R::COLUMNS.len() - lacking];
                header.iter().eq(older.iter().copied())
            }) => {}
        Ok(_) => return (rows, Some((1, "columns".to_owned()))),
        Err(error) => return (rows, Some(words(&error, R::COLUMNS))),
    }
    for row in reader.deserialize::<R>() {
        match row {
            Ok(row) => rows.push(format!("{row:?}")),
            Err(error) => return (rows, Some(words(&error, R::COLUMNS))),
        }
    }
    (rows, None)
}

fn words(error: &csv::Error, columns: &[&str]) -> (u64, String) {
    let place = |field: usize| format!("field {}, {}", field + 1, columns[field]);
    let line = error.position().expect("no trouble with a file").line();
    let words = match error.kind() {
        // Serde names the words that it knows, and not the field.
        csv::ErrorKind::Deserialize { err, .. } => match err.field() {
            Some(field) => format!("{}: {}", place(field as usize), err.kind()),
            None => err.kind().to_string(),
        },
        csv::ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => {
            format!("{len} fields where the header has {expected_len}")
        }
        csv::ErrorKind::Utf8 { err, .. } => format!("{}: not UTF-8", place(err.field())),
        kind => panic!("no such trouble in memory: {kind:?}"),
    };
    (line, words)
}

fn written<R: Serialize>(rows: &[R], columns: &[&str]) -> Vec<u8> {
    let mut writer = csv::WriterBuilder::new()
        .has_headers(false)
        .from_writer(Vec::new());
    writer.write_record(columns).expect("a header");
    for row in rows {
        writer.serialize(row).expect("a flat row");
    }
    writer.into_inner().expect("a Vec takes every byte")
}

/// A byte put in place of another, before it, or taken away.
#[derive(Debug, Clone)]
enum Edit {
    Replace(u8),
    Insert(u8),
    Remove,
}

fn edits() -> impl Strategy<Value = Vec<(Index, Edit)>> {
    let byte = || select(b"0179.,-+ \"\n\rexNi\xc3\xa9".as_slice());
    let edit = prop_oneof![
        byte().prop_map(Edit::Replace),
        byte().prop_map(Edit::Insert),
        Just(Edit::Remove),
    ];
    prop::collection::vec((any::<Index>(), edit), 0..4)
}

fn edited(mut text: Vec<u8>, edits: &[(Index, Edit)]) -> Vec<u8> {
    for (at, edit) in edits {
        if text.is_empty() {
            return text;
        }
        let at = at.index(text.len());
        match edit {
            Edit::Replace(byte) => text[at] = *byte,
            Edit::Insert(byte) => text.insert(at, *byte),
            Edit::Remove => {
                text.remove(at);
            }
        }
    }
    text
}

/// Stamps and numbers as runs have them, and now and then one of 20 digits.
fn count() -> impl Strategy<Value = u64> {
    prop_oneof![60 => 0..1_u64 << 50, 1 => any::<u64>()]
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![-2.0..2.0, prop::num::f64::ANY]
}

fn maybe<T: Debug>(value: impl Strategy<Value = T>) -> impl Strategy<Value = Option<T>> {
    prop::option::of(value)
}

fn ticks() -> impl Strategy<Value = TickRow> {
    let fields = (
        count(),
        count(),
        count(),
        number(),
        number(),
        maybe(count()),
        maybe(number()),
    );
    fields.prop_map(|(k, t_due_ns, t_tick_ns, u, y, seq, u_applied)| TickRow {
        k,
        t_due_ns,
        t_tick_ns,
        u,
        y,
        seq,
        u_applied,
    })
}

/// The columns of ticks in files from before the last one.
fn old_ticks() -> &'static [&'static str] {
    &TickRow::COLUMNS[..TickRow::COLUMNS.len() - TickRow::NEW]
}

fn arrivals() -> impl Strategy<Value = ArrivalRow> {
    use ArrivalOutcome::{Acknowledged, Aged, Applied, Stale};
    let outcome = select([Applied, Stale, Aged, Acknowledged].as_slice());
    let fields = (
        count(),
        count(),
        maybe(count()),
        count(),
        count(),
        number(),
        outcome,
    );
    fields.prop_map(
        |(n, seq, t_send_ns, t_arrive_ns, tick, u, outcome)| ArrivalRow {
            n,
            seq,
            t_send_ns,
            t_arrive_ns,
            tick,
            u,
            outcome,
        },
    )
}

fn messages() -> impl Strategy<Value = MessageRow> {
    use MessageOutcome::{Answered, Arrived, Failed, Missed, Timeout};
    let times = (
        count(),
        count(),
        maybe(count()),
        maybe(count()),
        maybe(count()),
    );
    let signals = (number(), maybe(number()), maybe(number()), maybe(number()));
    let outcome = select([Answered, Timeout, Failed, Missed, Arrived].as_slice());
    (times, signals, maybe(count()), outcome).prop_map(|(times, signals, tick, outcome)| {
        let (seq, t_due_ns, t_send_ns, t_receive_ns, t_arrive_ns) = times;
        let (r, y, e, u) = signals;
        MessageRow {
            seq,
            t_due_ns,
            t_send_ns,
            t_receive_ns,
            t_arrive_ns,
            r,
            y,
            e,
            u,
            tick,
            outcome,
            y_seq: None,
        }
    })
}

fn probes() -> impl Strategy<Value = ProbeRow> {
    use Phase::{After, Before, During, Empty};
    let phase = select([Empty, Before, During, After].as_slice());
    let times = (count(), maybe(count()), maybe(count()));
    let due = (count(), count(), any::<bool>());
    (phase, any::<u32>(), times, due).prop_map(|(phase, seq, times, due)| ProbeRow {
        phase,
        seq,
        t_send_ns: times.0,
        t_reach_ns: times.1,
        t_back_ns: times.2,
        due_up_ns: due.0,
        due_down_ns: due.1,
        due_lost: due.2,
    })
}

/// The two laws, for rows of one kind.
macro_rules! laws {
    ($kind:ident, $row:ty) => {
        mod $kind {
            use super::*;

            proptest! {
                #[test]
                fn what_was_written_is_read_and_in_the_plain_form(row in $kind()) {
                    let text = written(&[row], <$row>::COLUMNS);
                    let as_printed = vec![format!("{row:?}")];
                    prop_assert_eq!(outcome::<$row>(&text), (as_printed, None));
                    // The other form would do, and be slow.
                    let line = String::from_utf8(text).expect("ASCII");
                    let line = line.lines().nth(1).expect("a row");
                    let long = line.split(',').any(|field| {
                        field.len() == 20 && field.bytes().all(|byte| byte.is_ascii_digit())
                    });
                    prop_assert_eq!(<$row>::plain(line.as_bytes()).is_some(), !long, "{}", line);
                }

                #[test]
                fn an_edited_file_is_read_as_csv_and_serde_read_it(
                    rows in prop::collection::vec($kind(), 0..12), edits in edits(),
                ) {
                    let text = edited(written(&rows, <$row>::COLUMNS), &edits);
                    prop_assert_eq!(
                        outcome::<$row>(&text),
                        expected::<$row>(&text),
                        "{}", String::from_utf8_lossy(&text)
                    );
                }
            }
        }
    };
}

laws!(ticks, TickRow);
laws!(arrivals, ArrivalRow);
laws!(messages, MessageRow);
laws!(probes, ProbeRow);

proptest! {
    #[test]
    fn a_file_from_before_the_last_column_is_read_as_if_that_were_empty(
        rows in prop::collection::vec(ticks(), 0..12), edits in edits(),
    ) {
        let rows: Vec<TickRow> = rows.iter().map(|row| TickRow { u_applied: None, ..*row }).collect();
        let text = String::from_utf8(written(&rows, TickRow::COLUMNS)).expect("ASCII");
        // Every row ends with the empty field and its comma.
        let old = text.replace(",u_applied\n", "\n").replace(",\n", "\n");
        prop_assert!(old.starts_with(&old_ticks().join(",")));
        let printed: Vec<String> = rows.iter().map(|row| format!("{row:?}")).collect();
        prop_assert_eq!(outcome::<TickRow>(old.as_bytes()), (printed, None));
        let text = edited(old.into_bytes(), &edits);
        prop_assert_eq!(
            outcome::<TickRow>(&text),
            expected::<TickRow>(&text),
            "{}", String::from_utf8_lossy(&text)
        );
    }
}

#[test]
fn quotes_carriage_returns_and_empty_lines_are_csv_too() {
    let text = b"k,t_due_ns,t_tick_ns,u,y,seq\n0,1,2,0,0,\n\"1\",2,+3,1e0,0,\r\n\n2,3,4,0,0,1\n3,x,4,0,0,\n";
    let (rows, error) = outcome::<TickRow>(text);
    assert_eq!(rows.len(), 3, "{rows:?}");
    let (line, words) = error.expect("x is no time");
    assert_eq!(line, 6);
    assert!(words.starts_with("field 2, t_due_ns: "), "{words}");
}
