//! The messages on the wire: what is written reads back, and nothing else does.

use endpoint::{
    Acknowledgement, Answer, Command, InvalidMessage, Mode, Observation, Request, Signals, State,
    query::MAX_BYTES,
};
use proptest::prelude::*;

/// Every finite f64, by its bits: subnormal, huge and negative zero too.
fn finite() -> impl Strategy<Value = f64> {
    any::<u64>()
        .prop_map(f64::from_bits)
        .prop_filter("finite", |x| x.is_finite())
}

/// One of them, or two.
fn signals() -> impl Strategy<Value = Signals> {
    (finite(), proptest::option::of(finite())).prop_map(|(first, second)| Signals { first, second })
}

fn bits(signals: Signals) -> Vec<u64> {
    signals.iter().map(f64::to_bits).collect()
}

proptest! {
    #[test]
    fn a_command_reads_back_bit_by_bit(seq: u64, t_send_ns: u64, u in signals()) {
        let command = Command { seq, t_send_ns, u };
        let text = command.to_string();
        let read: Command = text.parse().expect("a written command is valid");
        prop_assert_eq!((read.seq, read.t_send_ns), (seq, t_send_ns));
        prop_assert_eq!(bits(read.u), bits(u));
        // Nothing in it needs percent-encoding, and a request line has room for it.
        prop_assert!(text.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"=&._-,".contains(&byte)));
        prop_assert!(text.len() < 125, "{}", text);
    }

    #[test]
    fn answers_read_back_in_both_forms(seq: u64, tick: u64, t_ns: u64, y in signals(), u in signals(), safe: bool) {
        let state = State { seq, tick, t_arrive_ns: t_ns, y, u };
        prop_assert_eq!(state.to_string().parse::<State>(), Ok(state));
        let observation = Observation { t_ns, tick, y, u, u_applied: y, safe, trips: seq };
        prop_assert_eq!(observation.to_string().parse::<Observation>(), Ok(observation));
        let acknowledgement = Acknowledgement { seq, t_arrive_ns: t_ns };
        prop_assert_eq!(acknowledgement.to_string().parse::<Acknowledgement>(), Ok(acknowledgement));
        let json = serde_json::to_string(&acknowledgement).expect("numbers");
        prop_assert_eq!(serde_json::from_str::<Acknowledgement>(&json).ok(), Some(acknowledgement));
    }

    #[test]
    fn a_request_may_leave_out_what_a_simple_controller_does_not_know(
        seq: Option<u64>,
        t_send_ns: Option<u64>,
        u in signals(),
    ) {
        let seq_field = seq.map(|seq| format!("seq={seq}"));
        let time_field = t_send_ns.map(|t_ns| format!("t_send_ns={t_ns}"));
        let fields = [Some(format!("u={u}")), seq_field, time_field];
        let text = fields.into_iter().flatten().collect::<Vec<_>>().join("&");
        prop_assert_eq!(text.parse(), Ok(Request { seq, t_send_ns, u }));
    }

    #[test]
    fn any_text_is_a_command_or_an_error_and_never_a_panic(text in ".{0,200}") {
        if let Ok(command) = text.parse::<Command>() {
            prop_assert!(command.u.is_finite());
        }
    }

    #[test]
    fn the_order_of_fields_is_free(u in signals(), order in Just([0, 1, 2]).prop_shuffle()) {
        let fields = ["seq=7".to_owned(), "t_send_ns=9".to_owned(), format!("u={u}")];
        let text = order.map(|index| fields[index].as_str()).join("&");
        prop_assert_eq!(text.parse(), Ok(Command { seq: 7, t_send_ns: 9, u }));
    }
}

#[test]
fn each_mistake_has_its_error_and_names_its_field() {
    use InvalidMessage as E;
    let count = |field, value: &str| E::NotCount {
        field,
        value: value.to_owned(),
    };
    let number = |value: &str| E::NotFinite {
        field: "u",
        value: value.to_owned(),
    };
    let expected = || "seq, t_send_ns, u".to_owned();
    let unknown = |field: &str| E::Unknown {
        field: field.to_owned(),
        expected: expected(),
    };
    let missing = |field| E::Missing {
        field,
        expected: expected(),
    };
    let table = [
        ("", missing("seq")),
        ("seq=1&u=0", missing("t_send_ns")),
        ("seq=1&t_send_ns=2", missing("u")),
        ("seq=1&t_send_ns=2&u=0&v=1", unknown("v")),
        ("Seq=1&t_send_ns=2&u=0", unknown("Seq")),
        ("seq=1&seq=1&t_send_ns=2&u=0", E::Duplicate { field: "seq" }),
        ("seq=-1&t_send_ns=2&u=0", count("seq", "-1")),
        ("seq=+1&t_send_ns=2&u=0", count("seq", " 1")),
        ("seq=%2B1&t_send_ns=2&u=0", count("seq", "+1")),
        ("seq=1.0&t_send_ns=2&u=0", count("seq", "1.0")),
        ("seq=&t_send_ns=2&u=0", count("seq", "")),
        ("seq&t_send_ns=2&u=0", count("seq", "")),
        (
            "seq=1&t_send_ns=18446744073709551616&u=0",
            count("t_send_ns", "18446744073709551616"),
        ),
        ("seq=1&t_send_ns=2&u=NaN", number("NaN")),
        ("seq=1&t_send_ns=2&u=inf", number("inf")),
        ("seq=1&t_send_ns=2&u=-infinity", number("-infinity")),
        ("seq=1&t_send_ns=2&u=1e400", number("1e400")),
        ("seq=1&t_send_ns=2&u=", number("")),
        ("seq=1&t_send_ns=2&u=0x10", number("0x10")),
        ("seq=1&t_send_ns=2&u=0,", number("")),
        ("seq=1&t_send_ns=2&u=0;5", number("0;5")),
        (
            "seq=1&t_send_ns=2&u=1,2,3",
            E::Signals {
                field: "u",
                given: 3,
                needed: "a plant has one or two inputs",
            },
        ),
        ("seq=1&t_send_ns=2&u=1%0a", number("1\\n")),
        ("seq=1&t_send_ns=2&u=%ff", number("\u{fffd}")),
    ];
    for (text, error) in table {
        assert_eq!(text.parse::<Command>(), Err(error), "{text}");
    }
    let long = format!("seq=1&t_send_ns=2&u=0.{}", "0".repeat(MAX_BYTES));
    assert_eq!(
        long.parse::<Command>(),
        Err(E::TooLong { bytes: long.len() })
    );
    // What an error repeats of a hostile text is short.
    let shout = format!("{}=1", "A".repeat(900));
    assert!(
        shout
            .parse::<Command>()
            .is_err_and(|error| error.to_string().len() < 150)
    );
}

#[test]
fn an_answer_counts_only_for_its_own_command_and_in_its_own_mode() {
    let command = Command {
        seq: 7,
        t_send_ns: 0,
        u: 0.0.into(),
    };
    let ours = "seq=7&t_arrive_ns=5";
    assert!(Answer::parse(Mode::Open, ours, &command).is_ok());
    assert_eq!(
        Answer::parse(Mode::Open, "seq=6&t_arrive_ns=5", &command),
        Err(InvalidMessage::OtherCommand { asked: 7, got: 6 })
    );
    assert!(Answer::parse(Mode::Closed, ours, &command).is_err());
    // A plant that has diverged writes an output that nobody takes.
    let diverged = State {
        seq: 7,
        tick: 1,
        t_arrive_ns: 5,
        y: f64::INFINITY.into(),
        u: 0.0.into(),
    };
    assert!(Answer::parse(Mode::Closed, &diverged.to_string(), &command).is_err());
}

#[test]
fn a_request_has_a_number_for_each_input_of_the_plant() {
    let request = |text: &str| text.parse::<Request>().expect("a valid request");
    assert!(request("u=0.5").check(1).is_ok() && request("u=0.5,1").check(2).is_ok());
    // As where a comma is the decimal point.
    let error = request("u=0,5")
        .check(1)
        .expect_err("one input")
        .to_string();
    assert!(
        error.contains("has 2 numbers") && error.contains("decimal point"),
        "{error}"
    );
    let error = request("u=0.5")
        .check(2)
        .expect_err("two inputs")
        .to_string();
    assert!(
        error.contains("has one number") && error.contains("u=0.35,0.1"),
        "{error}"
    );
}

#[test]
fn two_signals_are_a_list_in_json_and_one_is_a_number() {
    let json = |u: Signals| serde_json::to_string(&u).expect("numbers");
    assert_eq!(
        (json(0.5.into()), json([0.5, -1.0].into())),
        ("0.5".into(), "[0.5,-1.0]".into())
    );
    let read = |text| serde_json::from_str::<Signals>(text);
    assert_eq!(read("[0.5,-1]").ok(), Some([0.5, -1.0].into()));
    assert!(read("[1,2,3]").is_err() && read("[]").is_err());
}
