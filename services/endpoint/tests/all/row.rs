//! A row has the bytes that the csv crate writes by serde.

use endpoint::{ArrivalOutcome, ArrivalRow, MessageOutcome, MessageRow, SecondRow, TickRow};
use proptest::prelude::*;
use serde::Serialize;
use text::column::Row;

fn by_hand(row: &impl Row) -> String {
    let mut text = Vec::new();
    row.write(&mut text);
    String::from_utf8(text).expect("ASCII")
}

fn by_serde(row: impl Serialize) -> String {
    let mut csv = csv::WriterBuilder::new()
        .has_headers(false)
        .from_writer(Vec::new());
    csv.serialize(row).expect("a row is a flat struct");
    String::from_utf8(csv.into_inner().expect("a Vec takes every byte")).expect("ASCII")
}

/// Any number that an f64 can be, small and great ones, and integers.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<u64>().prop_map(f64::from_bits),
        -2.0..2.0_f64,
        (any::<i64>(), 0..40_i32).prop_map(|(n, e)| n as f64 / 10_f64.powi(e)),
        any::<u32>().prop_map(f64::from),
        Just(f64::INFINITY),
        Just(f64::NEG_INFINITY),
        Just(f64::NAN),
        Just(-0.0),
        Just(1e16),
        Just(9_999_999_999_999_998.0),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// So that files are the same, whichever version wrote them.
    #[test]
    fn a_line_is_that_of_the_csv_crate(
        counts in any::<[u64; 4]>(), maybe in any::<[Option<u64>; 4]>(),
        x in number(), y in prop::option::of(number()), z in prop::option::of(number()),
        arrival in prop::sample::select(ArrivalOutcome::ALL),
        message in prop::sample::select(MessageOutcome::ALL),
    ) {
        let [k, t_due_ns, t_tick_ns, n] = counts;
        let [seq, t_send_ns, t_receive_ns, t_arrive_ns] = maybe;
        let tick = TickRow { k, t_due_ns, t_tick_ns, u: x, y: -x, seq, u_applied: y };
        prop_assert_eq!(by_hand(&tick), by_serde(tick));
        let second = SecondRow { k, u2: y, y2: z, u2_applied: Some(x) };
        prop_assert_eq!(by_hand(&second), by_serde(second));
        let row = ArrivalRow {
            n, seq: k, t_send_ns, t_arrive_ns: t_due_ns, tick: t_tick_ns, u: x, outcome: arrival,
        };
        prop_assert_eq!(by_hand(&row), by_serde(row));
        let row = MessageRow {
            seq: k, t_due_ns, t_send_ns, t_receive_ns, t_arrive_ns, r: x, y, e: z, u: Some(x), tick: seq,
            outcome: message, y_seq: t_arrive_ns,
        };
        prop_assert_eq!(by_hand(&row), by_serde(row));
    }
}
