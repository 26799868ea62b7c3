//! Files of rows, read and refused.

use super::*;
use endpoint::TickRow;

fn read_text(text: &str) -> Result<(Vec<u64>, bool), ReadError> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("ticks.csv");
    std::fs::write(&path, text).expect("a writable folder");
    let mut ks = Vec::new();
    read(&path, |row: &TickRow| ks.push(row.k)).map(|torn| (ks, torn))
}

const HEADER: &str = "k,t_due_ns,t_tick_ns,u,y,seq\n";

#[test]
fn a_torn_last_line_is_dropped_even_when_it_looks_like_a_row() {
    let text = format!("{HEADER}0,10,11,0,0,\n1,20,21,0.5,0.25,1");
    assert_eq!(read_text(&text).expect("readable"), (vec![0], true));
    assert_eq!(
        read_text(&format!("{text}2\n")).expect("readable"),
        (vec![0, 1], false)
    );
}

#[test]
fn a_file_without_a_whole_header_has_no_rows() {
    assert_eq!(read_text("").expect("readable"), (vec![], false));
    assert_eq!(read_text("k,t_du").expect("readable"), (vec![], true));
    assert_eq!(read_text(HEADER).expect("readable"), (vec![], false));
}

#[test]
fn a_line_that_is_no_row_is_named_with_file_line_and_field() {
    let text = format!("{HEADER}0,10,11,0,0,\n1,20,x,0,0,\n2,30,31,0,0,\n");
    let message = read_text(&text).expect_err("x is no time").to_string();
    assert!(
        message.contains("ticks.csv, line 3: field 3, t_tick_ns:"),
        "{message}"
    );
    let message = read_text(&format!("{HEADER}0,10\n"))
        .expect_err("too short")
        .to_string();
    assert!(
        message.contains("line 2: 2 fields where the header has 6"),
        "{message}"
    );
}

#[test]
fn what_follows_enough_rows_is_not_looked_at() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("ticks.csv");
    let read = |text: &str, most: usize| {
        std::fs::write(&path, text).expect("a writable folder");
        let mut ks = Vec::new();
        let read = read_while(&path, |row: &TickRow| {
            ks.push(row.k);
            if ks.len() < most {
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(())
            }
        });
        read.map(|()| ks)
    };
    let text = format!("{HEADER}0,10,11,0,0,\n1,20,21,0,0,\n2,30,x,0,0,\n");
    assert_eq!(read(&text, 2).expect("readable"), [0, 1]);
    assert!(read(&text, 3).is_err());
    assert_eq!(read(HEADER, 3).expect("readable"), [0; 0]);
    assert_eq!(read("", 3).expect("readable"), [0; 0]);
}

#[test]
fn other_columns_are_refused_with_both_headers() {
    let message = read_text("a,b\n1,2\n").expect_err("no ticks").to_string();
    assert!(
        message.contains("a,b") && message.contains("k,t_due_ns"),
        "{message}"
    );
}

#[test]
fn a_line_without_an_end_is_refused_wherever_it_stands_and_in_little_memory() {
    let long = "7".repeat(LINE_MAX);
    let row = "0,10,11,0,0,\n";
    let quoted = format!("\"{long}");
    for (text, words) in [
        (format!("{long}\n"), "line 1"),
        (format!("{HEADER}{row}{long}\n"), "line 3"),
        (
            format!("{HEADER}{row}\"1\",20,21,0,0,\n{long}\n{row}"),
            "line 4",
        ),
        (format!("{HEADER}{row}{quoted}\n{row}"), "line 3"),
        (format!("{HEADER}{row}{long}"), "last line"),
    ] {
        let message = read_text(&text).expect_err(words).to_string();
        assert!(message.contains(words), "{words}: {message}");
        assert!(message.contains("64 KiB"), "{message}");
    }
}

/// Reads `text` against a manifest that was written for `asked`; only rows with an even k are
/// accepted.
fn read_vouched(text: &str, asked: &str) -> Result<Content, String> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("ticks.csv");
    std::fs::write(&path, text).expect("a writable folder");
    let asked = FileFact::of(asked.as_bytes()).expect("in memory");
    let even = |row: &TickRow| match row.k % 2 {
        0 => Ok(()),
        _ => Err(format!("k is {}", row.k)),
    };
    read_whole(&path, &asked, even)
        .map_err(|error| error.to_string().replace(&path.display().to_string(), "it"))
}

#[test]
fn a_file_is_held_against_its_manifest_while_it_is_read() {
    let text = format!("{HEADER}0,10,11,0,0,\n2,20,21,0,0,\n");
    let whole = |rows, torn| Ok(Content { rows, torn });
    assert_eq!(read_vouched(&text, &text), whole(2, false));
    // In any form of CSV, and with a torn last line.
    let quoted = text.replace("2,20", "\"2\",20");
    assert_eq!(read_vouched(&quoted, &quoted), whole(2, false));
    let torn = format!("{text}4,3");
    assert_eq!(read_vouched(&torn, &torn), whole(2, true));

    let said = |text: &str, asked: &str| read_vouched(text, asked).expect_err("damaged");
    for changed in [
        text.replace("21", "22"),
        torn.replace("4,3", "4,4"),
        quoted.replace("21", "22"),
    ] {
        let asked = [&text, &torn, &quoted]
            .into_iter()
            .find(|one| one.len() == changed.len())
            .expect("as long");
        assert!(said(&changed, asked).contains("checksum"), "{changed}");
    }
    assert!(said(&text, &torn).contains("bytes, and the manifest says"));
    assert!(said("", "").contains("it has no header"));
    for odd in [
        text.replace("2,20", "3,20"),
        quoted.replace("\"2\"", "\"3\""),
    ] {
        assert!(said(&odd, &odd).starts_with("it, line 3: k is 3"), "{odd}");
    }
}

#[test]
fn a_missing_file_is_named() {
    let error = read(Path::new("nowhere/ticks.csv"), |_: &TickRow| {}).expect_err("missing");
    assert!(error.to_string().contains("nowhere/ticks.csv"), "{error}");
}
