//! The rules of sessions, tested with made-up times.

use super::*;

use std::net::Ipv4Addr;

const S: u64 = 1_000_000_000;

fn client(name: &str) -> Client {
    Client::try_new(name.to_owned()).expect("a short name")
}

fn pass(byte: u8) -> Pass {
    Pass::Token(Token::of(byte))
}

/// A sender at the address 10.0.0.`host`.
fn at(host: u8, pass: Pass) -> Sender {
    let address = Ipv4Addr::new(10, 0, 0, host).into();
    Sender { pass, address }
}

fn by(pass: Pass) -> Sender {
    at(1, pass)
}

fn held(idle_ms: u64) -> Denied {
    Denied::Held {
        client: client("first"),
        idle_ms,
    }
}

/// A client in control since 100 s, with token 1.
fn control() -> Control {
    let mut control = Control::new(Lease::None);
    let number = control.claim(Token::of(1), client("first"), 100 * S);
    assert_eq!(number, Ok(1));
    control
}

#[test]
fn while_a_session_is_held_nobody_else_may() {
    let mut control = control();
    let now_ns = 101 * S;
    let second = control.claim(Token::of(2), client("second"), now_ns);
    assert_eq!(second, Err(held(1000)));
    assert_eq!(control.command(&by(Pass::Nothing), now_ns), Err(held(1000)));
    for stranger in [pass(2), Pass::Unreadable] {
        assert_eq!(
            control.command(&by(stranger.clone()), now_ns),
            Err(Denied::Over)
        );
        assert_eq!(control.hear(&stranger, now_ns), Err(Denied::Over));
    }
    let status = control.status(now_ns);
    assert_eq!(
        (status.commands, status.idle_ms),
        (0, 1000),
        "nothing was heard"
    );
    assert_eq!(control.command(&by(pass(1)), now_ns), Ok(false));
    let status = control.status(now_ns);
    assert_eq!(
        (status.state, status.commands, status.idle_ms),
        ("held", 1, 0)
    );
}

#[test]
fn a_session_lasts_as_long_as_it_is_heard_and_15_s() {
    let mut control = control();
    for k in 1..100 {
        let now_ns = 100 * S + k * (15 * S - 1);
        assert_eq!(control.hear(&pass(1), now_ns), Ok(1));
        assert_eq!(control.left_ns(1, now_ns), Some(15 * S));
    }
    let heard_ns = 100 * S + 99 * (15 * S - 1);
    assert_eq!(control.left_ns(1, heard_ns + 15 * S - 1), Some(1));
    // A query from outside does not count as hearing the session.
    assert_eq!(control.status(heard_ns + 15 * S - 1).state, "held");
    assert_eq!(control.status(heard_ns + 15 * S).state, "free");
    assert_eq!(control.left_ns(1, heard_ns + 15 * S), None);
    assert_eq!(
        control.command(&by(pass(1)), heard_ns + 16 * S),
        Err(Denied::Over),
        "a page that comes back has to claim again"
    );
    assert_eq!(
        control.command(&by(Pass::Nothing), heard_ns + 16 * S),
        Ok(false)
    );
}

#[test]
fn no_command_of_a_session_is_older_than_its_claim() {
    let mut control = control();
    assert_eq!(control.command(&by(pass(1)), 110 * S), Ok(false));
    assert_eq!(control.since_ns(), Some(100 * S));
    control.end(1, Ending::default());
    assert_eq!(control.since_ns(), None, "nobody's");
    assert_eq!(
        control.claim(Token::of(2), client("second"), 120 * S),
        Ok(2)
    );
    assert_eq!(control.since_ns(), Some(120 * S));
}

#[test]
fn silence_is_seen_whatever_comes_first() {
    let late_ns = 116 * S;
    assert_eq!(
        control().claim(Token::of(2), client("second"), late_ns),
        Ok(2)
    );
    assert_eq!(control().admit(&Pass::Nothing, late_ns), Ok(None));
    assert_eq!(control().hear(&pass(1), late_ns), Err(Denied::Over));
    assert_eq!(
        control().status(late_ns),
        Status {
            state: "free",
            ..Status::default()
        }
    );
}

#[test]
fn a_controller_without_a_session_keeps_pages_out_for_2_s() {
    let mut control = Control::new(Lease::None);
    assert_eq!(control.hear(&Pass::Nothing, 0), Err(Denied::Missing));
    assert_eq!(control.command(&by(Pass::Nothing), 10 * S), Ok(false));
    assert_eq!(control.status(10 * S).state, "free");
    let mut claim = |now_ns| control.claim(Token::of(1), client("first"), now_ns);
    assert_eq!(claim(11 * S), Err(Denied::Plain { idle_ms: 1000 }));
    assert_eq!(claim(12 * S - 1), Err(Denied::Plain { idle_ms: 1999 }));
    assert_eq!(claim(12 * S), Ok(1));
}

#[test]
fn looking_at_a_socket_is_not_commanding() {
    let mut control = Control::new(Lease::None);
    assert_eq!(control.admit(&Pass::Nothing, 0), Ok(None));
    assert_eq!(control.claim(Token::of(1), client("first"), 0), Ok(1));
}

#[test]
fn an_ended_session_stays_visible_until_the_next() {
    let mut control = control();
    control.count_rows(1, 7);
    control.count_rows(1, 5);
    control.end(1, Ending::default());
    let status = control.status(130 * S);
    assert_eq!(
        (status.state, status.rows, status.idle_ms),
        ("ended", 7, 30_000)
    );
    assert!(control.has_ended(&pass(1)) && !control.has_ended(&pass(2)));
    assert_eq!(control.command(&by(pass(1)), 130 * S), Err(Denied::Over));
    assert_eq!(
        control.claim(Token::of(2), client("second"), 130 * S),
        Ok(2)
    );
    assert!(!control.has_ended(&pass(1)));
    // Orders of an old session that are processed late do not affect the next one.
    control.end(1, Ending::default());
    control.withdraw(1);
    control.count_rows(1, 9);
    let status = control.status(130 * S);
    assert_eq!((status.state, status.rows), ("held", 0));
}

#[test]
fn a_client_has_a_short_name_of_one_line() {
    for name in ["", "Mozilla/5.0 (X11)", &"é".repeat(80)] {
        assert_eq!(client(name).0, name);
    }
    for name in ["a\nb", "\u{7f}", &"é".repeat(81)] {
        assert!(Client::try_new(name.to_owned()).is_err(), "{name:?}");
    }
}

#[test]
fn with_the_lease_address_one_address_commands_until_it_is_silent_for_2_s() {
    let mut control = Control::new(Lease::Address);
    let mut command = |host, now_ns| {
        let said = control.command(&at(host, Pass::Nothing), now_ns);
        if said.is_ok() {
            control.renew(now_ns);
        }
        said
    };
    assert_eq!(command(1, 10 * S), Ok(true));
    assert_eq!(command(1, 11 * S), Ok(false));
    assert_eq!(command(2, 12 * S), Err(Denied::Address { idle_ms: 1000 }));
    assert_eq!(command(2, 13 * S), Ok(true), "the first was silent for 2 s");
    assert_eq!(command(1, 14 * S), Err(Denied::Address { idle_ms: 1000 }));
    assert_eq!(command(2, 17 * S), Ok(true), "it comes back as another");
}

#[test]
fn a_controller_whose_commands_are_not_taken_does_not_keep_the_lease() {
    let mut control = Control::new(Lease::Address);
    let mut command = |now_ns| control.command(&by(Pass::Nothing), now_ns);
    assert_eq!(command(10 * S), Ok(true));
    assert_eq!(command(11 * S), Ok(false));
    assert_eq!(command(12 * S), Ok(true), "it was not renewed");
}

#[test]
fn with_the_lease_token_every_command_needs_a_session() {
    let mut control = Control::new(Lease::Token);
    let plain = by(Pass::Nothing);
    assert_eq!(control.command(&plain, 0), Err(Denied::Missing));
    assert_eq!(control.open(&Pass::Nothing, 0), Err(Denied::Missing));
    assert_eq!(control.claim(Token::of(1), client("first"), 0), Ok(1));
    assert_eq!(control.command(&by(pass(1)), S), Ok(false));
    assert_eq!(control.open(&pass(1), S), Ok(Some(1)));
    assert_eq!(control.command(&plain, S), Err(held(0)));
}

#[test]
fn only_who_is_in_control_resets_a_plant_or_anybody_if_nobody_is() {
    let (first, second) = (at(1, Pass::Nothing), at(2, Pass::Nothing));
    let mut control = Control::new(Lease::Address);
    assert_eq!(control.reset(&second, 0), Ok(()));
    assert_eq!(control.command(&first, S), Ok(true));
    assert_eq!(control.reset(&first, S), Ok(()));
    assert_eq!(
        control.reset(&second, S),
        Err(Denied::Address { idle_ms: 0 })
    );
    let mut control = Control::new(Lease::Token);
    assert_eq!(control.reset(&first, 0), Ok(()));
    assert_eq!(control.claim(Token::of(1), client("first"), 0), Ok(1));
    assert_eq!(control.reset(&first, 0), Err(held(0)));
    assert_eq!(control.reset(&by(pass(1)), 0), Ok(()));
}
