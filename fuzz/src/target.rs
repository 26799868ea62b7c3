//! A function for each parser.

use std::io::Cursor;
use std::str::from_utf8;

use endpoint::{ArrivalRow, Command, MessageRow, Mode, Request, State, TickRow, checksum, datagram, json};
use endpoint::http::framing::Rest;
use endpoint::http::{lines, request};
use link::{Profile, Twist, Way};
use plan::{Plan, ProbeRow, ProfileText};
use plan::system::System;
use tungstenite::protocol::Role;
use tungstenite::{Message, WebSocket};

pub const ALL: [(&str, fn(&[u8])); 11] = [
    ("agent", agent),
    ("answer", answer),
    ("command", command),
    ("experiment", experiment),
    ("head", head),
    ("manifest", manifest),
    ("packet", packet),
    ("plan", plan),
    ("profile", profile),
    ("row", row),
    ("system", system),
];

/// What goes between orchestrator and agent.
fn agent(bytes: &[u8]) {
    containers::fuzz(bytes);
}

/// A plant's answer, as a controller reads it, over HTTP or a WebSocket.
fn answer(bytes: &[u8]) {
    for rest in [Rest::MayCome, Rest::IsMissing] {
        if let Ok(Some(answer)) = endpoint::http::answer::read(bytes, rest, 1 << 16) {
            assert!(answer.body.len() <= bytes.len());
        }
    }
    let mut socket = WebSocket::from_raw_socket(Cursor::new(bytes.to_vec()), Role::Client, None);
    while let Ok(message) = socket.read() {
        if let Message::Text(text) = message {
            state(&text);
        }
    }
    if let Ok(text) = from_utf8(bytes) {
        state(text);
    }
}

fn state(text: &str) {
    let Ok((text, _)) = checksum::checked(text, false) else {
        return;
    };
    if let Ok(state) = text.parse::<State>() {
        assert_eq!(state.to_string().parse::<State>().ok(), Some(state));
    }
}

/// A command, as a plant reads it, over HTTP, a WebSocket, TCP or UDP.
fn command(bytes: &[u8]) {
    let mut socket = WebSocket::from_raw_socket(Cursor::new(bytes.to_vec()), Role::Server, None);
    while let Ok(message) = socket.read() {
        if let Message::Text(text) = message {
            request(&text);
        }
    }
    if let Ok(text) = from_utf8(bytes) {
        request(text);
        if let Ok((_, text)) = datagram::read(text) {
            request(text);
        }
    }
    if let Ok(request) = json::request(bytes) {
        assert!(request.u.first.is_finite());
    }
}

fn request(text: &str) {
    let Ok((text, _)) = checksum::checked(text, false) else {
        return;
    };
    if let Ok(request) = text.parse::<Request>() {
        // Whatever passes is finite.
        if request.check(1).is_ok() {
            assert!(request.u.first.is_finite());
        }
    }
    if let Ok(command) = text.parse::<Command>() {
        assert_eq!(command.to_string().parse::<Command>().ok(), Some(command));
        for mode in [Mode::Open, Mode::Closed] {
            let _ = endpoint::Answer::parse(mode, text, &command);
        }
    }
}

/// An experiment, of built-in topologies and systems.
fn experiment(bytes: &[u8]) {
    if let Ok(text) = from_utf8(bytes)
        && let Ok(plan) = Plan::resolve(text, "fuzz.toml", &plan::Instead::default(), built_in)
    {
        again(&plan);
    }
}

fn built_in(asked: &str) -> Result<ProfileText, String> {
    let source = Profile::builtin(asked).ok_or("there is no such topology")?;
    Ok(ProfileText {
        source: source.to_owned(),
        ..ProfileText::default()
    })
}

fn again(plan: &Plan) {
    assert_eq!(Plan::from_json(&plan.to_json()).as_ref(), Ok(plan));
}

/// The head of a request to the plant, which must be the same however it arrives.
fn head(bytes: &[u8]) {
    let mut room = lines::room();
    let Ok(Some(whole)) = request::read(bytes, &mut room) else {
        return;
    };
    assert!(whole.bytes <= bytes.len());
    for end in 0..whole.bytes {
        let is_whole = matches!(request::read(&bytes[..end], &mut lines::room()), Ok(Some(_)));
        assert!(!is_whole, "{end}");
    }
    let mut room = lines::room();
    let exact = request::read(&bytes[..whole.bytes], &mut room);
    assert!(matches!(exact, Ok(Some(head)) if head.framing == whole.framing));
}

fn manifest(bytes: &[u8]) {
    if let Ok(text) = from_utf8(bytes) {
        let _ = record::Manifest::from_json(text);
    }
}

/// A packet that a link's fault changes.
fn packet(bytes: &[u8]) {
    let [bits, rest @ ..] = bytes else { return };
    let way = if bits & 1 == 0 { Way::Up } else { Way::Down };
    let twist = Twist {
        flip: (bits & 2 != 0).then_some(u32::from(*bits) << 3),
        reset: bits & 4 != 0,
        rebind: bits & 8 != 0,
        ..Twist::NONE
    };
    let mut packet = rest.to_vec();
    let (length, _) = shaper::fuzz(&mut packet, way, twist);
    assert!(length <= rest.len());
}

fn plan(bytes: &[u8]) {
    if let Ok(text) = from_utf8(bytes)
        && let Ok(plan) = Plan::from_json(text)
    {
        again(&plan);
    }
}

fn profile(bytes: &[u8]) {
    if let Ok(text) = from_utf8(bytes) {
        let _ = Profile::read(text, "fuzz", &|_: &str| Ok("0 1\n1 2\n".to_owned()));
    }
}

/// The rows of every file that the analysis reads.
fn row(bytes: &[u8]) {
    let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(bytes);
    let Ok(header) = reader.headers().cloned() else {
        return;
    };
    for record in reader.records().map_while(Result::ok) {
        let _ = record.deserialize::<TickRow>(Some(&header));
        let _ = record.deserialize::<ArrivalRow>(Some(&header));
        let _ = record.deserialize::<MessageRow>(Some(&header));
        let _ = record.deserialize::<ProbeRow>(Some(&header));
    }
}

fn system(bytes: &[u8]) {
    if let Ok(text) = from_utf8(bytes) {
        let _ = System::read(text);
    }
}
