//! A loop's commands over one connection, whatever frames them: a text in, its answer out, as HTTP would give it.
//!
//! One connection carries a whole loop. `route` executes commands; a [`Carrier`] takes texts out of the bytes, as a
//! WebSocket (`socket`) or as lines (`line`). A message that cannot be read ends the connection with the reason, since
//! a client that sends one has an error.

use std::{
    cell::RefCell,
    ops::Deref,
    task::{Context, Poll},
    time::Duration,
};

use clock::{now::now_ns, patience::Patience};
use endpoint::Mode;
use tokio::{sync::watch, time::Instant};
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;

use crate::{
    handler::Handler,
    place::Place,
    refusal::Refusal,
    session::Sender,
    shared::{Shared, WITHIN},
    token::Pass,
    turn::Turn,
};

/// The longest reason that fits a close frame (RFC 6455, 5.5).
const REASON_BYTES: usize = 123;

/// After this silence the other end is asked whether it is there: clients that wait for the start of a run
/// are silent for some seconds.
const SILENCE: Duration = Duration::from_secs(2);

/// How long it may take to answer that, by a pong or any message. One that is gone must not keep its place.
const PONG_WITHIN: Duration = WITHIN;

/// The purpose of a conversation.
#[derive(Debug)]
pub(crate) struct Opening {
    pub(crate) mode: Mode,
    pub(crate) sender: Sender,
    /// The number of its session, if it belongs to one.
    pub(crate) session: Option<u64>,
    /// The latest session that has ended.
    pub(crate) over: watch::Receiver<u64>,
}

/// Why we end a conversation.
pub(crate) struct Closing {
    pub(crate) code: CloseCode,
    pub(crate) reason: String,
}

/// What comes from the other end.
pub(crate) enum Incoming<T> {
    /// A command.
    Text(T),
    /// A sign of life.
    Sign,
    /// What cannot be read, and how its connection is closed for it.
    Wrong(CloseCode, String),
    /// Nothing more.
    End,
}

/// Takes texts out of a connection, and puts texts into it.
pub(crate) trait Carrier {
    /// A text that has come.
    type Text: Deref<Target = str>;
    /// What is sent, in its frame.
    type Framed;
    /// Of which kind what cannot be read is, in the plant's report.
    const KIND: &'static str;
    /// What a sign of life is called.
    const PONG: &'static str;

    /// An answer's frame.
    fn answer(text: String) -> Self::Framed;

    /// What the other end answers by a sign of life.
    fn ping() -> Self::Framed;

    fn poll_heard(&mut self, context: &mut Context<'_>) -> Poll<Incoming<Self::Text>>;

    /// Whether there is room to send; `None` if the connection is broken.
    fn poll_ready(&mut self, context: &mut Context<'_>) -> Poll<Option<()>>;

    /// Sends as much as fits at once.
    fn start_send(&mut self, framed: Self::Framed) -> Option<()>;

    /// Sends the rest.
    fn poll_flush(&mut self, context: &mut Context<'_>) -> Poll<Option<()>>;
}

/// Reads `mode=closed|open[&session=..]`, by which a conversation begins.
pub(crate) fn query(query: &str) -> Result<(Mode, Pass), Refusal> {
    let expected = "`mode=closed` or `mode=open`, and perhaps `session=` with 32 hex digits";
    let refuse = || Refusal::Query { expected };
    let (mut mode, mut pass) = (None, None);
    for (key, value) in form_urlencoded::parse(query.as_bytes()) {
        let again = match &*key {
            "mode" => mode.replace(value.parse().map_err(|_| refuse())?).is_some(),
            "session" => pass.replace(Pass::from(value.as_bytes())).is_some(),
            _ => true,
        };
        if again {
            return Err(refuse());
        }
    }
    Ok((mode.ok_or_else(refuse)?, pass.unwrap_or(Pass::Nothing)))
}

/// Answers messages until the end; returns why we end it, unless the other end did.
pub(crate) async fn converse<C: Carrier>(
    carrier: &mut C,
    opening: Opening,
    shared: &Shared,
    place: &Place,
) -> Option<Closing> {
    let handler = &*shared.handler;
    let Opening {
        mode,
        sender,
        session,
        over,
    } = opening;
    let mut on_end_of = std::pin::pin!(wait_for_end(session, over));
    let (mut heard, mut is_asked) = (Instant::now(), false);
    let mut patience = Patience::default();
    loop {
        let until = heard
            + if is_asked {
                SILENCE + PONG_WITHIN
            } else {
                SILENCE
            };
        let message = tokio::select! {
            biased;
            message = patience.before(until, |context| carrier.poll_heard(context)) => message,
            () = &mut on_end_of => {
                return Some(Closing::new(CloseCode::Policy, "the session is over"));
            }
        };
        if message.is_some() {
            (heard, is_asked) = (Instant::now(), false);
        }
        let mut turn = shared.turns.wait(place).await;
        match message {
            Some(Incoming::Text(text)) => match answer(&text, mode, &sender, handler, place) {
                Ok(answer) => {
                    send(carrier, C::answer(answer), &mut turn, &mut patience).await?;
                }
                Err(closing) => return Some(closing),
            },
            Some(Incoming::Sign) => turn.end().await,
            Some(Incoming::Wrong(code, reason)) => {
                return Some(Closing::refused(handler, C::KIND, code, reason));
            }
            Some(Incoming::End) => return None,
            None if !is_asked => {
                is_asked = true;
                send(carrier, C::ping(), &mut turn, &mut patience).await?;
            }
            None => {
                let reason = format!("no {} within {} s", C::PONG, PONG_WITHIN.as_secs());
                return Some(Closing::new(CloseCode::Away, reason));
            }
        }
    }
}

/// Waits for the end of a session; for ever, if there is none.
async fn wait_for_end(session: Option<u64>, mut over: watch::Receiver<u64>) {
    match session {
        Some(number) => drop(over.wait_for(|over| *over >= number).await),
        None => std::future::pending().await,
    }
}

/// Executes a command, and gives its answer; or why we close the connection.
fn answer(
    text: &str,
    mode: Mode,
    sender: &Sender,
    handler: &RefCell<Handler>,
    place: &Place,
) -> Result<String, Closing> {
    let now_ns = now_ns();
    let told = handler.borrow_mut().command(mode, text, sender, now_ns);
    let told = told.map_err(|refusal| {
        let code = refusal.close_code();
        Closing::refused(handler, refusal.kind(), code, refusal.to_string())
    })?;
    place.on_command(now_ns);
    place.on_answer();
    Ok(told.text())
}

/// Sends a message: into the socket at once, and what does not fit after the turn. `None` if the other end does
/// not read, or is gone.
async fn send<C: Carrier>(
    carrier: &mut C,
    framed: C::Framed,
    turn: &mut Turn<'_>,
    patience: &mut Patience,
) -> Option<()> {
    let until = Instant::now() + WITHIN;
    let is_free = patience.before(until, |context| carrier.poll_ready(context));
    is_free.await??;
    carrier.start_send(framed)?;
    turn.end().await;
    let is_sent = patience.before(until, |context| carrier.poll_flush(context));
    is_sent.await?
}

impl Closing {
    pub(crate) fn new(code: CloseCode, reason: impl Into<String>) -> Self {
        let mut reason = reason.into();
        let end = (0..=REASON_BYTES).rfind(|end| reason.is_char_boundary(*end));
        reason.truncate(end.unwrap_or_default());
        Self { code, reason }
    }

    /// A closing that is counted as a refusal of this kind.
    pub(crate) fn refused(
        handler: &RefCell<Handler>,
        kind: &'static str,
        code: CloseCode,
        reason: impl Into<String>,
    ) -> Self {
        handler.borrow_mut().refuse(kind);
        Self::new(code, reason)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_query_has_a_mode_and_perhaps_a_session() {
        let session = "0123456789abcdef0123456789abcdef";
        let read = |text: &str| query(text).ok();
        assert!(matches!(
            read("mode=open"),
            Some((Mode::Open, Pass::Nothing))
        ));
        let text = format!("session={session}&mode=closed");
        assert!(matches!(read(&text), Some((Mode::Closed, Pass::Token(_)))));
        let text = "mode=closed&session=";
        assert!(matches!(read(text), Some((Mode::Closed, Pass::Unreadable))));
        for wrong in [
            "",
            "mode=",
            "mode=ajar",
            "mode=open&mode=open",
            "mode=open&u=1",
        ] {
            assert!(read(wrong).is_none(), "{wrong}");
        }
    }

    #[test]
    fn a_reason_is_cut_between_letters() {
        let closing = Closing::new(CloseCode::Policy, "é".repeat(100));
        assert_eq!(closing.reason, "é".repeat(61));
    }
}
