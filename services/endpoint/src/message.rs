//! The messages between the two ends.
//!
//! On the wire a message is a URI-encoded query, as in the paper: `seq=7&t_send_ns=1200000&u=0.35`.
//! `Display` writes that form and `FromStr` reads it strictly ([`crate::query`]). Where a plant has two inputs
//! or outputs, both stand in one field: `u=0.35,0.1`. Numbers are written
//! with the fewest digits that read back to the same f64. A client may send and request the same fields as a
//! JSON object ([`mod@crate::json`]). An output that is no longer finite is written as `inf` or `NaN`, which the
//! reader rejects.

use std::{fmt, str::FromStr};

use control::Signals;
use serde::{Deserialize, Serialize};

use crate::{
    query::{InvalidMessage, count, fields, fields_of, flag, signals},
    setting::Mode,
};

/// From controller to plant: use this input.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Command {
    /// Number of the deadline at which it was sent.
    pub seq: u64,
    /// When it was sent, on the controller's clock.
    pub t_send_ns: u64,
    /// The plant's input u, or both of them.
    pub u: Signals,
}

/// A [`Command`] as a plant takes it: what a simple controller does not know is optional.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// Number of the deadline at which it was sent; the plant numbers messages without.
    pub seq: Option<u64>,
    /// When it was sent, on the controller's clock.
    pub t_send_ns: Option<u64>,
    /// The plant's input u, or both of them.
    pub u: Signals,
}

impl Request {
    /// Checks that it has a value for each of so many inputs.
    ///
    /// # Errors
    /// [`InvalidMessage::Signals`] if it has more or fewer.
    pub fn check(&self, inputs: usize) -> Result<(), InvalidMessage> {
        if self.u.count() == inputs {
            return Ok(());
        }
        Err(InvalidMessage::Signals {
            field: "u",
            given: self.u.count(),
            needed: if inputs == 1 {
                "this plant has one input; write its decimal point as `.`"
            } else {
                "this plant has two inputs; write both, like u=0.35,0.1"
            },
        })
    }
}

impl From<&Command> for Request {
    fn from(command: &Command) -> Self {
        Self {
            seq: Some(command.seq),
            t_send_ns: Some(command.t_send_ns),
            u: command.u,
        }
    }
}

/// From plant to controller in closed loop: the plant's state.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct State {
    /// The command that this answers.
    pub seq: u64,
    /// The plant's latest tick.
    pub tick: u64,
    /// When the command arrived, on the plant's clock.
    pub t_arrive_ns: u64,
    /// The output after that tick, or both of them.
    pub y: Signals,
    /// The input that the plant holds from now on, or both of them.
    pub u: Signals,
}

/// From plant to controller in open loop: the command arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Acknowledgement {
    /// The command that this answers.
    pub seq: u64,
    /// When it arrived, on the plant's clock.
    pub t_arrive_ns: u64,
}

/// The plant's state, read without sending a command.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Observation {
    /// When it was read, on the plant's clock.
    pub t_ns: u64,
    /// The latest tick.
    pub tick: u64,
    /// The output after that tick, or both of them.
    pub y: Signals,
    /// The commanded input that the plant holds, or both of them.
    pub u: Signals,
    /// The input of the latest tick, behind watchdog and actuator, or both of them.
    pub u_applied: Signals,
    /// Whether the watchdog acts, since no command has come for too long.
    #[serde(default)]
    pub safe: bool,
    /// How often it has begun to act.
    #[serde(default)]
    pub trips: u64,
}

/// The plant's answer to a command, by the mode of the loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Answer {
    /// In closed loop.
    State(State),
    /// In open loop.
    Acknowledgement(Acknowledgement),
}

impl Answer {
    /// Reads the answer to `command`.
    ///
    /// # Errors
    /// [`InvalidMessage`], which names the field. An answer to another command is rejected too, since
    /// its y belongs to another time.
    pub fn parse(mode: Mode, text: &str, command: &Command) -> Result<Self, InvalidMessage> {
        let answer = match mode {
            Mode::Closed => Self::State(text.parse()?),
            Mode::Open => Self::Acknowledgement(text.parse()?),
        };
        answer.to(command)
    }

    /// The answer, if it is one to `command`.
    #[inline]
    pub(crate) fn to(self, command: &Command) -> Result<Self, InvalidMessage> {
        if self.seq() == command.seq {
            Ok(self)
        } else {
            Err(InvalidMessage::OtherCommand {
                asked: command.seq,
                got: self.seq(),
            })
        }
    }

    /// The sequence number of the command that this answers.
    #[must_use]
    pub fn seq(&self) -> u64 {
        match self {
            Self::State(state) => state.seq,
            Self::Acknowledgement(acknowledgement) => acknowledgement.seq,
        }
    }

    /// When that command arrived, on the plant's clock.
    #[must_use]
    pub fn t_arrive_ns(&self) -> u64 {
        match self {
            Self::State(state) => state.t_arrive_ns,
            Self::Acknowledgement(acknowledgement) => acknowledgement.t_arrive_ns,
        }
    }
}

/// Writes a count behind its name, by hand: with `write!` a message takes half as long again.
fn write_count(f: &mut fmt::Formatter<'_>, name: &str, count: u64) -> fmt::Result {
    f.write_str(name)?;
    f.write_str(itoa::Buffer::new().format(count))
}

impl fmt::Display for Command {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_count(f, "seq=", self.seq)?;
        write_count(f, "&t_send_ns=", self.t_send_ns)?;
        f.write_str("&u=")?;
        self.u.fmt(f)
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            seq,
            tick,
            t_arrive_ns,
            y,
            u,
        } = self;
        write_count(f, "seq=", *seq)?;
        write_count(f, "&tick=", *tick)?;
        write_count(f, "&t_arrive_ns=", *t_arrive_ns)?;
        f.write_str("&y=")?;
        y.fmt(f)?;
        f.write_str("&u=")?;
        u.fmt(f)
    }
}

impl fmt::Display for Acknowledgement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_count(f, "seq=", self.seq)?;
        write_count(f, "&t_arrive_ns=", self.t_arrive_ns)
    }
}

impl fmt::Display for Observation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            t_ns,
            tick,
            y,
            u,
            u_applied,
            safe,
            trips,
        } = self;
        write!(
            f,
            "t_ns={t_ns}&tick={tick}&y={y}&u={u}&u_applied={u_applied}&safe={safe}&trips={trips}"
        )
    }
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::State(state) => state.fmt(f),
            Self::Acknowledgement(acknowledgement) => acknowledgement.fmt(f),
        }
    }
}

impl FromStr for Command {
    type Err = InvalidMessage;

    fn from_str(text: &str) -> Result<Self, InvalidMessage> {
        let [seq, t_send_ns, u] = fields(text, ["seq", "t_send_ns", "u"])?;
        Ok(Self {
            seq: count("seq", &seq)?,
            t_send_ns: count("t_send_ns", &t_send_ns)?,
            u: signals("u", &u)?,
        })
    }
}

impl FromStr for Request {
    type Err = InvalidMessage;

    fn from_str(text: &str) -> Result<Self, InvalidMessage> {
        let [u, seq, t_send_ns] = fields_of(text, ["u", "seq", "t_send_ns"], 1)?;
        let optional = |name, value: Option<_>| -> Result<Option<u64>, InvalidMessage> {
            value
                .map(|text: std::borrow::Cow<'_, str>| count(name, &text))
                .transpose()
        };
        Ok(Self {
            seq: optional("seq", seq)?,
            t_send_ns: optional("t_send_ns", t_send_ns)?,
            u: signals("u", &u.unwrap_or_default())?,
        })
    }
}

impl FromStr for State {
    type Err = InvalidMessage;

    fn from_str(text: &str) -> Result<Self, InvalidMessage> {
        let [seq, tick, t_arrive_ns, y, u] =
            fields(text, ["seq", "tick", "t_arrive_ns", "y", "u"])?;
        Ok(Self {
            seq: count("seq", &seq)?,
            tick: count("tick", &tick)?,
            t_arrive_ns: count("t_arrive_ns", &t_arrive_ns)?,
            y: signals("y", &y)?,
            u: signals("u", &u)?,
        })
    }
}

impl FromStr for Acknowledgement {
    type Err = InvalidMessage;

    fn from_str(text: &str) -> Result<Self, InvalidMessage> {
        let [seq, t_arrive_ns] = fields(text, ["seq", "t_arrive_ns"])?;
        Ok(Self {
            seq: count("seq", &seq)?,
            t_arrive_ns: count("t_arrive_ns", &t_arrive_ns)?,
        })
    }
}

impl FromStr for Observation {
    type Err = InvalidMessage;

    fn from_str(text: &str) -> Result<Self, InvalidMessage> {
        // A plant without a watchdog need not tell the last three.
        let names = ["t_ns", "tick", "y", "u", "u_applied", "safe", "trips"];
        let [t_ns, tick, y, u, u_applied, safe, trips] = fields_of(text, names, 4)?;
        let u = signals("u", &u.unwrap_or_default())?;
        Ok(Self {
            t_ns: count("t_ns", &t_ns.unwrap_or_default())?,
            tick: count("tick", &tick.unwrap_or_default())?,
            y: signals("y", &y.unwrap_or_default())?,
            u,
            u_applied: u_applied.map_or(Ok(u), |text| signals("u_applied", &text))?,
            safe: safe.map_or(Ok(false), |text| flag("safe", &text))?,
            trips: trips.map_or(Ok(0), |text| count("trips", &text))?,
        })
    }
}
