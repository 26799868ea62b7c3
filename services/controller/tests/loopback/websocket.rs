//! Messages over a WebSocket, against a plant by script.

use std::{sync::mpsc, time::Duration};

use controller::{Config, DriveError};
use endpoint::{Connection, ControllerSettings, MessageOutcome, MessageRow, Mode, Preset, report};
use tokio_tungstenite::tungstenite::{
    Message,
    protocol::{CloseFrame, frame::coding::CloseCode},
};

use crate::{
    MS, check, config, drive, h, rows,
    scripted::{Meet, Script, Socket, Then, with_script},
};

fn settings() -> ControllerSettings {
    Preset::Socket.settings(Mode::Open, h(10))
}

/// Drives a controller against a script, and gives its report, its rows and how
/// many sockets it asked for.
fn played<F>(
    settings: ControllerSettings,
    duration_ms: u64,
    script: Script<F>,
) -> (report::Native, Vec<MessageRow>, usize)
where
    F: AsyncFn(usize, &mut Socket) -> Then + Send + 'static,
{
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (report, asked) = with_script(script, |address| {
        drive(&config(folder.path(), address, settings, duration_ms)).expect("a run to its end")
    });
    let messages: Vec<MessageRow> = rows(&folder.path().join("messages.csv"));
    check(&report, &messages, duration_ms / 10);
    for row in &messages {
        if row.outcome == MessageOutcome::Answered {
            assert_eq!(row.t_arrive_ns, Some(row.seq), "another's answer");
        }
    }
    (report, messages, asked)
}

/// A script that does `first` with the first socket and answers on all others.
fn at_first<F>(first: F) -> Script<impl AsyncFn(usize, &mut Socket) -> Then + Send + 'static>
where
    F: AsyncFn(&mut Socket) -> Then + Send + 'static,
{
    Script {
        meet: |_| Meet::Accept,
        socket: async move |n, socket: &mut Socket| {
            if n == 0 {
                return first(socket).await;
            }
            socket.acknowledge_all().await;
            Then::GoOn
        },
    }
}

pub(crate) fn answers_belong_to_their_commands_in_any_order() {
    let (told, farewell) = mpsc::channel();
    let script = at_first(async move |socket: &mut Socket| {
        for _ in 0..10 {
            let (Some(one), Some(two)) = (socket.command().await, socket.command().await) else {
                return Then::GoOn;
            };
            socket.acknowledge(two.seq).await;
            // One that was never asked is nobody's.
            socket.acknowledge(1_000_000).await;
            socket.acknowledge(one.seq).await;
        }
        // Longer than any other may take to be sent.
        while let Some(command) = socket.command().await {
            socket.acknowledge(command.seq).await;
            if command.seq == 39 {
                let _ = told.send(socket.farewell().await);
            }
        }
        Then::GoOn
    });
    let (report, messages, asked) = played(settings(), 400, script);
    assert_eq!(report.first_failure, None);
    assert_eq!(report.counts.answered, report.counts.sent);
    assert_eq!(asked, 1);
    let mut sent = messages.iter().filter(|row| row.t_send_ns.is_some());
    let first_two = [sent.next(), sent.next()].map(|row| row.expect("a row").seq);
    assert!(first_two[0] > first_two[1], "{first_two:?}");
    // The last deadline may have been missed on a busy machine.
    if messages.iter().any(|row| row.seq == 39 && row.u.is_some()) {
        let farewell = farewell.recv().expect("told").expect("a close frame");
        assert_eq!(farewell.code, CloseCode::Normal);
    }
}

pub(crate) fn an_answer_that_is_none_fails_all_under_way_and_the_next_command_connects_again() {
    for garbage in [Message::text("hello"), Message::binary(vec![1, 2, 3])] {
        let expected = match &garbage {
            Message::Text(_) => "field `hello` is unknown",
            _ => "bytes",
        };
        let script = at_first(async move |socket: &mut Socket| {
            for _ in 0..3 {
                socket.command().await;
            }
            socket.send(garbage.clone()).await;
            while socket.command().await.is_some() {}
            Then::GoOn
        });
        let (report, messages, asked) = played(settings(), 300, script);
        let why = report.first_failure.expect("failures");
        assert!(why.contains(expected), "{why}");
        assert!(report.counts.failed >= 3, "{:?}", report.counts);
        assert!(report.counts.answered > 0, "{:?}", report.counts);
        assert_eq!(report.counts.timeout, 0);
        assert_eq!(asked, 2);
        let last = messages.last().expect("rows");
        assert_ne!(last.outcome, MessageOutcome::Failed);
    }
}

pub(crate) fn the_plant_s_reason_to_close_is_said() {
    let script = at_first(async |socket: &mut Socket| {
        for _ in 0..3 {
            socket.command().await;
        }
        let reason = "field `u`: `NaN` is not a finite decimal number".into();
        let code = CloseCode::Policy;
        socket
            .send(Message::Close(Some(CloseFrame { code, reason })))
            .await;
        // What the controller says to that.
        socket.farewell().await;
        Then::GoOn
    });
    let (report, _, asked) = played(settings(), 300, script);
    let why = report.first_failure.expect("failures");
    assert!(why.contains("1008 field `u`: `NaN`"), "{why}");
    assert!(report.counts.failed >= 3, "{:?}", report.counts);
    assert!(report.counts.answered > 0, "{:?}", report.counts);
    assert_eq!(asked, 2);
}

pub(crate) fn a_silent_socket_is_timeouts_and_stays_open() {
    let settings = ControllerSettings {
        outstanding: "2".parse().expect("a valid word"),
        timeout_ns: 50 * MS,
        ..settings()
    };
    let script = at_first(async |socket: &mut Socket| {
        while socket.command().await.is_some() {}
        Then::GoOn
    });
    let (report, _, asked) = played(settings, 200, script);
    assert_eq!(report.counts.timeout, report.counts.sent);
    assert!(report.counts.sent >= 2, "{:?}", report.counts);
    assert!(report.counts.missed > 0, "{:?}", report.counts);
    assert_eq!(asked, 1);
}

pub(crate) fn a_plant_that_comes_back_is_found_again() {
    let script = at_first(async |socket: &mut Socket| {
        for _ in 0..3 {
            if let Some(command) = socket.command().await {
                socket.acknowledge(command.seq).await;
            }
        }
        socket.command().await;
        Then::Vanish(Duration::from_millis(150))
    });
    let (report, messages, asked) = played(settings(), 800, script);
    assert!(report.counts.failed > 0, "{:?}", report.counts);
    assert!(report.counts.answered > 3, "{:?}", report.counts);
    assert_eq!(report.counts.timeout, 0);
    assert_eq!(asked, 2);
    let last = messages.last().expect("rows");
    assert_ne!(last.outcome, MessageOutcome::Failed);
}

pub(crate) fn a_refusal_is_said() {
    let script = Script {
        meet: |_| {
            Meet::Refuse(
                "HTTP/1.1 409 Conflict\r\nConnection: close\r\nContent-Length: 25\r\n\r\na page is in control here\n",
            )
        },
        socket: async |_, _: &mut Socket| Then::GoOn,
    };
    let (report, _, _) = played(settings(), 100, script);
    assert_eq!(report.counts.failed, report.counts.sent);
    let why = report.first_failure.expect("failures");
    assert!(
        why.contains("409 Conflict: a page is in control here"),
        "{why}"
    );
}

pub(crate) fn commands_wait_for_one_attempt_to_connect_and_each_by_its_own_timeout() {
    let settings = ControllerSettings {
        timeout_ns: 100 * MS,
        ..settings()
    };
    // Five attempts of twice the timeout are a second, and the controller begins in its first half.
    let script = Script {
        meet: |n| {
            if n < 5 { Meet::Ignore } else { Meet::Accept }
        },
        socket: async |_, socket: &mut Socket| {
            socket.acknowledge_all().await;
            Then::GoOn
        },
    };
    let (report, _, asked) = played(settings, 2000, script);
    let counts = report.counts;
    assert_eq!(counts.failed, 0, "{:?}", report.first_failure);
    assert!(counts.timeout > 0, "{counts:?}");
    assert!(counts.answered > 0, "{counts:?}");
    assert_eq!(asked, 6);
}

pub(crate) fn a_websocket_with_a_connection_for_each_message_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let settings = ControllerSettings {
        connection: Connection::New,
        ..settings()
    };
    let address = "127.0.0.1:1".parse().expect("an address");
    let config: Config = config(folder.path(), address, settings, 1);
    let error = drive(&config).expect_err("it makes no sense");
    assert!(matches!(error, DriveError::Conflict(_)), "{error}");
    assert!(!folder.path().join("messages.csv").exists());
}
