//! Who is in control of the plant: a page with a session, controllers without one, or no client.
//!
//! A pure state machine that gets the time as an argument. A session is one page's exclusive right to
//! command: it begins with a claim, lasts as long as it is used, and ends when its page says so or is
//! silent. Native controllers need no session, unless the plant's lease is `token`; a page cannot take the plant
//! from one that is running. With the lease `address` there is one of them at a time, told by its IP address.

use std::net::IpAddr;

use endpoint::Lease;
use serde::Serialize;

use crate::{
    ending::Ending,
    token::{Pass, Token},
};

/// A session ends if nothing is heard of it for this long: its page was closed or lost. A page sends
/// rows every second, and a link may stall for 5 s.
pub(crate) const SILENCE_NS: u64 = 15_000_000_000;

/// A controller without a session is in control until no command of it was taken for this long. One that only
/// repeats old commands does not keep others out, nor itself when it starts anew.
const PLAIN_NS: u64 = Lease::SILENCE_NS;

/// Greatest length of a client's name. However it is written in JSON, it fits into a claim.
pub(crate) const CLIENT_CHARS: usize = 80;

/// A page's name for itself, fit for a line of text.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub(crate) struct Client(String);

impl Client {
    /// Accepts a name that is short and has no control characters.
    pub(crate) fn try_new(name: String) -> Result<Self, InvalidClient> {
        let chars = name.chars().count();
        if chars > CLIENT_CHARS {
            return Err(InvalidClient::Long { chars });
        }
        if name.chars().any(char::is_control) {
            return Err(InvalidClient::Control);
        }
        Ok(Self(name))
    }
}

/// Why a client's name is invalid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum InvalidClient {
    #[error("`client` has {chars} characters; give at most {CLIENT_CHARS}")]
    Long { chars: usize },
    #[error("`client` has a control character; give one line of text")]
    Control,
}

/// Why a request is denied.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Denied {
    #[error(
        "`{}` is in control, heard {idle_ms} ms ago; wait until its session ends, at the latest \
         after {} s of silence",
        client.0,
        SILENCE_NS / 1_000_000_000
    )]
    Held { client: Client, idle_ms: u64 },
    #[error(
        "a controller without a session is in control, heard {idle_ms} ms ago; wait until it has been silent for {} s",
        PLAIN_NS / 1_000_000_000
    )]
    Plain { idle_ms: u64 },
    #[error(
        "a controller at another address is in control, heard {idle_ms} ms ago; wait until it has been silent \
         for {} s",
        PLAIN_NS / 1_000_000_000
    )]
    Address { idle_ms: u64 },
    #[error("this session is over or unknown; begin another with POST /session")]
    Over,
    #[error("this needs a session; begin one with POST /session")]
    Missing,
}

impl Denied {
    /// Its kind in the plant's report.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Held { .. } | Self::Plain { .. } | Self::Address { .. } => "lease",
            Self::Over | Self::Missing => "session",
        }
    }
}

/// Who sends a request.
#[derive(Clone, Debug)]
pub(crate) struct Sender {
    pub(crate) pass: Pass,
    pub(crate) address: IpAddr,
}

/// The public status of the control session.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Status {
    state: &'static str,
    client: Client,
    commands: u64,
    rows: u64,
    idle_ms: u64,
    /// Present once it has ended.
    #[serde(flatten)]
    ending: Ending,
}

/// Decides who is in control.
#[derive(Debug)]
pub(crate) struct Control {
    lease: Lease,
    state: State,
    sessions: u64,
    plain: Option<Plain>,
}

/// The controller without a session that was heard last.
#[derive(Clone, Copy, Debug)]
struct Plain {
    address: IpAddr,
    heard_ns: u64,
}

#[derive(Debug)]
enum State {
    Free,
    Held(Session),
    /// Kept until the next session, for observers from outside.
    Ended(Session),
}

#[derive(Debug)]
struct Session {
    token: Token,
    client: Client,
    begun_ns: u64,
    heard_ns: u64,
    commands: u64,
    rows: u64,
    ending: Ending,
}

impl Control {
    /// A state in which no client is in control.
    pub(crate) fn new(lease: Lease) -> Self {
        Self {
            lease,
            state: State::Free,
            sessions: 0,
            plain: None,
        }
    }

    /// Number of sessions so far; each has the number of its claim, from 1.
    pub(crate) fn sessions(&self) -> u64 {
        self.sessions
    }

    /// Begins a session, unless a client is in control. Returns its number.
    pub(crate) fn claim(
        &mut self,
        token: Token,
        client: Client,
        now_ns: u64,
    ) -> Result<u64, Denied> {
        self.expire(now_ns);
        if let State::Held(session) = &self.state {
            return Err(session.held(now_ns));
        }
        if let Some((_, idle_ms)) = self.plain_holder(now_ns) {
            return Err(Denied::Plain { idle_ms });
        }
        self.plain = None;
        self.sessions += 1;
        self.state = State::Held(Session {
            token,
            client,
            begun_ns: now_ns,
            heard_ns: now_ns,
            commands: 0,
            rows: 0,
            ending: Ending::default(),
        });
        Ok(self.sessions)
    }

    /// Admits or denies a request. Returns the number of its session, if it has one; that session has
    /// then been heard.
    pub(crate) fn admit(&mut self, pass: &Pass, now_ns: u64) -> Result<Option<u64>, Denied> {
        self.expire(now_ns);
        match (&mut self.state, pass) {
            (State::Held(session), Pass::Nothing) => Err(session.held(now_ns)),
            (State::Free | State::Ended(_), Pass::Nothing) => Ok(None),
            (State::Held(session), Pass::Token(token)) if session.token.is(token) => {
                session.heard_ns = now_ns;
                Ok(Some(self.sessions))
            }
            (_, Pass::Token(_) | Pass::Unreadable) => Err(Denied::Over),
        }
    }

    /// Like [`Control::admit`], for requests that need a session; returns its number.
    pub(crate) fn hear(&mut self, pass: &Pass, now_ns: u64) -> Result<u64, Denied> {
        self.admit(pass, now_ns)?.ok_or(Denied::Missing)
    }

    /// Like [`Control::admit`], for a command: it is counted in its session; without a session the lease
    /// decides. Returns whether its sender is another controller than before, as far as the lease can tell.
    pub(crate) fn command(&mut self, sender: &Sender, now_ns: u64) -> Result<bool, Denied> {
        if self.admit(&sender.pass, now_ns)?.is_some() {
            if let State::Held(session) = &mut self.state {
                session.commands += 1;
            }
            return Ok(false);
        }
        let is_new = self.lease(sender, now_ns)?;
        if is_new || self.lease == Lease::None {
            self.plain = Some(Plain {
                address: sender.address,
                heard_ns: now_ns,
            });
        }
        Ok(is_new)
    }

    /// What the lease says of a sender without a session: whether it is new, or why it may not command.
    fn lease(&self, sender: &Sender, now_ns: u64) -> Result<bool, Denied> {
        match (self.lease, self.plain_holder(now_ns)) {
            (Lease::None, _) => Ok(false),
            (Lease::Token, _) => Err(Denied::Missing),
            (Lease::Address, None) => Ok(true),
            (Lease::Address, Some((address, _))) if address == sender.address => Ok(false),
            (Lease::Address, Some((_, idle_ms))) => Err(Denied::Address { idle_ms }),
        }
    }

    /// The controller without a session that is in control, and for how long it has been silent, ms.
    fn plain_holder(&self, now_ns: u64) -> Option<(IpAddr, u64)> {
        let plain = self.plain?;
        let idle_ns = now_ns.saturating_sub(plain.heard_ns);
        (idle_ns < PLAIN_NS).then_some((plain.address, idle_ns / 1_000_000))
    }

    /// When the session in control began, if one is: its token was told then, so no command with it is older.
    pub(crate) fn since_ns(&self) -> Option<u64> {
        match &self.state {
            State::Held(session) => Some(session.begun_ns),
            State::Free | State::Ended(_) => None,
        }
    }

    /// Takes notice that a command of the present holder was taken.
    pub(crate) fn renew(&mut self, now_ns: u64) {
        if let (Some(plain), State::Free | State::Ended(_)) = (&mut self.plain, &self.state) {
            plain.heard_ns = now_ns;
        }
    }

    /// Like [`Control::admit`], for a WebSocket, which carries commands only.
    pub(crate) fn open(&mut self, pass: &Pass, now_ns: u64) -> Result<Option<u64>, Denied> {
        match self.admit(pass, now_ns)? {
            None if self.lease == Lease::Token => Err(Denied::Missing),
            session => Ok(session),
        }
    }

    /// Whether `sender` may put the plant back to rest: it is in control, or nobody is.
    pub(crate) fn reset(&mut self, sender: &Sender, now_ns: u64) -> Result<(), Denied> {
        if self.admit(&sender.pass, now_ns)?.is_none() && self.lease == Lease::Address {
            self.lease(sender, now_ns)?;
        }
        Ok(())
    }

    /// Records the session's total of rows.
    pub(crate) fn count_rows(&mut self, number: u64, rows: u64) {
        if let State::Held(session) | State::Ended(session) = &mut self.state
            && number == self.sessions
        {
            // Two answers of the filer may be processed in either order.
            session.rows = session.rows.max(rows);
        }
    }

    /// Ends a session at its page's request.
    pub(crate) fn end(&mut self, number: u64, ending: Ending) {
        if number == self.sessions {
            self.state = match std::mem::replace(&mut self.state, State::Free) {
                State::Held(session) => State::Ended(Session { ending, ..session }),
                other => other,
            };
        }
    }

    /// Cancels a session as if it had never been held.
    pub(crate) fn withdraw(&mut self, number: u64) {
        if number == self.sessions {
            self.state = State::Free;
        }
    }

    /// Whether `pass` belongs to the session that ended last: its page repeats its report because it
    /// received no answer.
    pub(crate) fn has_ended(&self, pass: &Pass) -> bool {
        match (&self.state, pass) {
            (State::Ended(session), Pass::Token(token)) => session.token.is(token),
            _ => false,
        }
    }

    /// Time left until a session must be heard again; `None` if it has ended.
    pub(crate) fn left_ns(&mut self, number: u64, now_ns: u64) -> Option<u64> {
        self.expire(now_ns);
        match &self.state {
            State::Held(session) if number == self.sessions => {
                Some(SILENCE_NS - now_ns.saturating_sub(session.heard_ns))
            }
            _ => None,
        }
    }

    /// The public status of the control session.
    pub(crate) fn status(&mut self, now_ns: u64) -> Status {
        self.expire(now_ns);
        let (state, session) = match &self.state {
            State::Free => {
                return Status {
                    state: "free",
                    ..Status::default()
                };
            }
            State::Held(session) => ("held", session),
            State::Ended(session) => ("ended", session),
        };
        Status {
            state,
            client: session.client.clone(),
            commands: session.commands,
            rows: session.rows,
            idle_ms: session.idle_ms(now_ns),
            ending: session.ending.clone(),
        }
    }

    fn expire(&mut self, now_ns: u64) {
        if let State::Held(session) = &self.state
            && now_ns.saturating_sub(session.heard_ns) >= SILENCE_NS
        {
            self.state = State::Free;
        }
    }
}

impl Session {
    fn idle_ms(&self, now_ns: u64) -> u64 {
        now_ns.saturating_sub(self.heard_ns) / 1_000_000
    }

    fn held(&self, now_ns: u64) -> Denied {
        Denied::Held {
            client: self.client.clone(),
            idle_ms: self.idle_ms(now_ns),
        }
    }
}

#[cfg(test)]
mod laws;
