//! The columns that a data package describes are those of the files: the header that is written, and the one that
//! serde derives from the rows.

use analysis::{LoopVerdict, Summary};
use link::certificate::{LinkRow, TcRow};
use link::{PacketRow, Way};
use report::deposit::schema::ROW_FILES;
use text::column::{Column, Typed};

fn names(columns: &[Column]) -> Vec<&'static str> {
    columns.iter().map(|column| column.name).collect()
}

#[test]
fn the_columns_of_a_link_s_files_are_those_of_its_player() {
    let user = LinkRow {
        t_ns: 0,
        way: Way::Up,
        packets: 0,
        bytes: 0,
        delivered: 0,
        lost: 0,
        overflow: 0,
        foreign: 0,
        dropped: 0,
        late_mean_us: 0.0,
        late_max_us: 0.0,
    };
    let tc = TcRow {
        t_ns: 0,
        way: Way::Up,
        delivered: 0,
        bytes: 0,
        lost: 0,
        overflow: 0,
        dropped: 0,
        queued: 0,
        changes: 0,
        late_mean_us: 0.0,
        late_max_us: 0.0,
    };
    let packet = PacketRow {
        t_ns: 0,
        way: Way::Up,
        bytes: 0,
    };
    assert_eq!(names(LinkRow::SCHEMA).join(","), header(&csv_of(user)));
    assert_eq!(names(TcRow::SCHEMA).join(","), header(&csv_of(tc)));
    assert_eq!(names(PacketRow::SCHEMA).join(","), header(&csv_of(packet)));
}

#[test]
fn the_columns_of_the_summary_are_those_that_are_written() {
    let summary = Summary::to_csv(&[Summary::default()]);
    assert_eq!(names(Summary::SCHEMA).join(","), header(&summary));
    assert_eq!(names(Summary::SCHEMA), Summary::COLUMNS);
}

#[test]
fn the_words_of_a_column_are_those_that_are_written() {
    let verdicts = LoopVerdict::ALL.map(|verdict| serde_json::to_value(verdict).expect("a word"));
    assert_eq!(verdicts.as_slice(), LoopVerdict::WORDS);
    let ways = Way::BOTH.map(|way| serde_json::to_value(way).expect("a word"));
    assert_eq!(ways.as_slice(), Way::WORDS);
}

#[test]
fn every_column_says_what_it_means() {
    let files = ROW_FILES.iter().map(|kind| kind.columns);
    for column in files.chain([Summary::SCHEMA]).flatten() {
        let meaning = column.meaning();
        assert!(!meaning.is_empty(), "{}", column.name);
        assert!(!meaning.ends_with('.'), "{}: {meaning}", column.name);
    }
}

fn csv_of(row: impl serde::Serialize) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.serialize(row).expect("a flat row");
    String::from_utf8(writer.into_inner().expect("memory")).expect("text")
}

fn header(csv: &str) -> &str {
    csv.lines().next().expect("a header")
}
