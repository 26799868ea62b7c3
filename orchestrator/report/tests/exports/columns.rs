//! The columns of the schemas are those of the rows.

use analysis::Summary;
use endpoint::{ArrivalRow, MessageRow, SecondRow, TickRow};
use link::{PacketRow, Way};
use plan::ProbeRow;
use report::deposit::field::Field;
use report::deposit::schema;

#[test]
fn the_columns_of_the_schemas_are_those_of_the_rows() {
    let names = |fields: Vec<Field>| -> Vec<String> {
        fields.into_iter().map(|field| field.name).collect()
    };
    assert_eq!(names(schema::columns("ticks")), TickRow::COLUMNS);
    assert_eq!(names(schema::columns("second")), SecondRow::COLUMNS);
    assert_eq!(names(schema::columns("arrivals")), ArrivalRow::COLUMNS);
    assert_eq!(names(schema::columns("messages")), MessageRow::COLUMNS);
    assert_eq!(names(schema::columns("probes")), ProbeRow::COLUMNS);
    assert_eq!(names(schema::columns("packets")), PacketRow::COLUMNS);
    let summary = Summary::to_csv(&[Summary::default()]);
    assert_eq!(
        names(schema::columns("summary")).join(","),
        header(&summary)
    );
}

#[test]
fn the_columns_of_a_link_s_file_are_those_of_its_player() {
    let names = |fields: Vec<Field>| {
        let names = fields.into_iter().map(|field| field.name);
        names.collect::<Vec<_>>().join(",")
    };
    let user = certificate::LinkRow {
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
    let tc = certificate::TcRow {
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
    assert_eq!(names(schema::columns("link")), header(&csv_of(user)));
    assert_eq!(names(schema::columns("link-tc")), header(&csv_of(tc)));
}

fn csv_of(row: impl serde::Serialize) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.serialize(row).expect("a flat row");
    String::from_utf8(writer.into_inner().expect("memory")).expect("text")
}

fn header(csv: &str) -> &str {
    csv.lines().next().expect("a header")
}
