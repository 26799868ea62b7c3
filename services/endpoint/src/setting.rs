//! How an experiment configures the two ends. [`crate::preset`] has named settings, [`crate::plant_setting`] those of
//! the plant.
//!
//! Each choice is a word in kebab-case, the same on the command line, in TOML and in a manifest.
//! [`crate::controller`] and [`crate::plant`] have the effects of the words.

use std::{borrow::Cow, fmt, num::NonZeroU16, str::FromStr};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use crate::field::{Field, InvalidSetting, span_field, word_field};
use crate::sample_time::SampleTime;

text::choice!(
    /// Whether the answers steer the plant.
    Mode, "mode", {
        /// The plant only acknowledges: a study of timing.
        Open = "open",
        /// The plant applies u and answers with its state.
        Closed = "closed",
    }
);

text::choice!(
    /// What a message does for its TCP connection.
    Connection, "connection", {
        /// Takes an idle one and leaves it open; opens one when none is idle.
        Keep = "keep",
        /// Opens one of its own and closes it.
        New = "new",
    }
);

text::choice!(
    /// Where the next deadline is.
    Schedule, "schedule", {
        /// start + k h: it does not drift, and what is late stays visible.
        Absolute = "absolute",
        /// h after the last message ended (with one outstanding) or was sent
        /// (with several): it drifts, as a program does that sleeps h in a loop.
        Relative = "relative",
        /// h after the last message was sent, or when one has ended if none
        /// more may be under way: it drifts less, as a program does whose timer
        /// is set anew before all else.
        SinceSend = "since-send",
    }
);

text::choice!(
    /// The time by which the controller's integrator advances at each message.
    Integrate, "integrate", {
        /// The nominal sample time, as the paper's difference equation has it.
        H = "h",
        /// The time since the message before.
        Elapsed = "elapsed",
    }
);

text::choice!(
    /// What an end does with a message that a newer one has overtaken.
    Late, "late", {
        /// Takes messages in order of arrival, as the paper's server did.
        Apply = "apply",
        /// Leaves out those older than the newest it has taken.
        Drop = "drop",
    }
);

text::choice!(
    /// Who may command a plant at a time.
    Lease, "lease", {
        /// Whoever sends, as at the paper's server. A page needs a session all the same.
        None = "none",
        /// One IP address, while it was heard in the last two seconds, or one session.
        Address = "address",
        /// One session, whose token every command has.
        Token = "token",
    }
);

text::choice!(
    /// How the kernel schedules a thread.
    Policy, "scheduling", {
        /// `SCHED_FIFO`: it runs whenever it can, before all ordinary threads.
        Fifo = "fifo",
        /// `SCHED_OTHER`, or whatever else an ordinary thread has: it waits for its turn, as a desktop's programs do.
        Other = "other",
    }
);

text::choice!(
    /// Whose clock stamps the commands that a plant gets.
    Clock, "clock", {
        /// Each controller's own, which runs like the plant's and may show another time.
        Own = "own",
        /// The plant's: both ends are on one machine.
        Shared = "shared",
    }
);

text::choice!(
    /// What carries the messages.
    Transport, "transport", {
        /// A request a message.
        Http = "http",
        /// A request a message, which has its command in a body of JSON.
        Json = "json",
        /// One bare TCP connection for all messages, each a line in it.
        Tcp = "tcp",
        /// A datagram a message, which nobody sends again.
        Udp = "udp",
        /// One WebSocket for all messages, each a text in it.
        WebSocket = "websocket",
    }
);

/// What messages have in common on their way, whatever a transport's bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carriage {
    /// Each is a request and its answer, on a connection that carries no other meanwhile.
    Requests,
    /// All follow each other on one connection.
    Stream,
    /// Each goes for itself, without a connection. What is lost never comes.
    Datagrams,
}

impl Default for Mode {
    /// A closed loop, the subject of the experiments.
    fn default() -> Self {
        Self::Closed
    }
}

impl Default for Lease {
    /// That of the paper's server, and of plans from before there was a choice.
    fn default() -> Self {
        Self::None
    }
}

impl Default for Policy {
    /// What keeps an end punctual beside other programs.
    fn default() -> Self {
        Self::Fifo
    }
}

impl Policy {
    /// Whether it is real time.
    #[must_use]
    pub fn is_fifo(&self) -> bool {
        *self == Self::Fifo
    }

    /// The `SCHED_FIFO` priority to ask for, of a thread whose place it would be; none for an ordinary thread.
    #[must_use]
    pub fn priority(self, priority: u8) -> Option<u8> {
        self.is_fifo().then_some(priority)
    }
}

impl Default for Clock {
    /// What is true of any controller.
    fn default() -> Self {
        Self::Own
    }
}

impl Clock {
    /// Whether it is the controller's own.
    #[must_use]
    pub fn is_own(&self) -> bool {
        *self == Self::Own
    }
}

impl Lease {
    /// One address holds the lease until no command of it was taken for this long.
    pub const SILENCE_NS: u64 = 2_000_000_000;

    /// Whether it is that of the paper's server.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::None
    }
}

impl Default for Transport {
    /// The transport of plans from before there was a choice, which name none.
    fn default() -> Self {
        Self::Http
    }
}

impl Transport {
    /// How its messages are carried.
    #[must_use]
    pub fn carriage(self) -> Carriage {
        match self {
            Self::Http | Self::Json => Carriage::Requests,
            Self::Tcp | Self::WebSocket => Carriage::Stream,
            Self::Udp => Carriage::Datagrams,
        }
    }

    /// Whether webloop's native controller alone has it, and not those in Python and in a browser.
    #[must_use]
    pub fn is_native_only(self) -> bool {
        matches!(self, Self::Json | Self::Tcp | Self::Udp)
    }
}

/// A text that is no number of requests.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("outstanding is `{0}`; give 1 to 8192, or `unlimited`")]
pub struct InvalidOutstanding(String);

/// How many requests the controller may have under way.
///
/// Written as a number or as `unlimited`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outstanding {
    /// At most this many. With 1 the client is blocking: it waits for each answer.
    Limited(NonZeroU16),
    /// No limit below [`Outstanding::CAP`].
    Unlimited,
}

impl Outstanding {
    /// One request at a time.
    pub const ONE: Self = Self::Limited(NonZeroU16::MIN);

    /// The technical limit on `unlimited`, and on any number: each request may need a socket, and a process
    /// has a limited number of them. At 1 kHz and with a timeout of 5 s at most 5000 can be under way.
    pub const CAP: u16 = 8192;

    /// The number of requests that may be under way.
    #[inline]
    #[must_use]
    pub fn limit(self) -> usize {
        match self {
            Self::Limited(n) => usize::from(n.get().min(Self::CAP)),
            Self::Unlimited => usize::from(Self::CAP),
        }
    }
}

impl FromStr for Outstanding {
    type Err = InvalidOutstanding;

    fn from_str(word: &str) -> Result<Self, Self::Err> {
        if word == "unlimited" {
            return Ok(Self::Unlimited);
        }
        match word.parse::<NonZeroU16>() {
            Ok(n) if n.get() <= Self::CAP => Ok(Self::Limited(n)),
            _ => Err(InvalidOutstanding(word.to_owned())),
        }
    }
}

impl fmt::Display for Outstanding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Limited(n) => f.pad(&n.to_string()),
            Self::Unlimited => f.pad("unlimited"),
        }
    }
}

impl JsonSchema for Outstanding {
    fn schema_name() -> Cow<'static, str> {
        "Outstanding".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "How many requests may be under way: a number, or `unlimited`.",
            "type": ["integer", "string"],
            "minimum": 1,
            "maximum": Outstanding::Unlimited.limit(),
            "pattern": "^(unlimited|[0-9]+)$",
        })
    }
}

impl Serialize for Outstanding {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Limited(n) => serializer.serialize_u16(n.get()),
            Self::Unlimited => serializer.serialize_str("unlimited"),
        }
    }
}

impl<'de> Deserialize<'de> for Outstanding {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;

        impl de::Visitor<'_> for Visitor {
            type Value = Outstanding;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("1 to 8192, or `unlimited`")
            }

            fn visit_str<E: de::Error>(self, word: &str) -> Result<Outstanding, E> {
                word.parse().map_err(E::custom)
            }

            fn visit_u64<E: de::Error>(self, n: u64) -> Result<Outstanding, E> {
                self.visit_str(&n.to_string())
            }

            fn visit_i64<E: de::Error>(self, n: i64) -> Result<Outstanding, E> {
                self.visit_str(&n.to_string())
            }
        }

        deserializer.deserialize_any(Visitor)
    }
}

/// Everything that the controller's end is set up with.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ControllerSettings {
    /// Whether the answers steer the plant.
    pub mode: Mode,
    /// Sample time.
    pub h: SampleTime,
    /// The reference; at the start, if it moves.
    pub r: f64,
    /// How many requests may be under way.
    pub outstanding: Outstanding,
    /// What carries the messages. It acts outside this crate, as the next does.
    #[serde(default)]
    pub transport: Transport,
    /// Kept-alive or new connections.
    pub connection: Connection,
    /// Where the next deadline is.
    pub schedule: Schedule,
    /// The time by which the integrator advances.
    pub integrate: Integrate,
    /// What becomes of an answer that a newer one has overtaken.
    pub late: Late,
    /// How long a message waits for its answer. The paper's clients: 5 s.
    pub timeout_ns: u64,
}

impl ControllerSettings {
    /// Settings of a client that sends every h, whatever is outstanding, like the paper's.
    #[must_use]
    pub fn new(mode: Mode, h: SampleTime) -> Self {
        Self {
            mode,
            h,
            r: 1.0,
            outstanding: Outstanding::Unlimited,
            transport: Transport::Http,
            connection: Connection::Keep,
            schedule: Schedule::Absolute,
            integrate: Integrate::H,
            late: Late::Apply,
            timeout_ns: 5_000_000_000,
        }
    }

    /// Checks whether any client can follow these settings.
    ///
    /// # Errors
    /// [`InvalidSetting`], which names the setting to change.
    pub fn check(&self) -> Result<(), InvalidSetting> {
        if self.connection == Connection::Keep {
            return Ok(());
        }
        let problem = match self.transport.carriage() {
            Carriage::Requests => return Ok(()),
            Carriage::Stream => format!(
                "transport `{}` is one connection for all messages",
                self.transport
            ),
            Carriage::Datagrams => format!("transport `{}` has no connections", self.transport),
        };
        Err(InvalidSetting {
            name: "connection",
            problem,
            remedy: "use connection keep, or transport http or json",
        })
    }

    /// Checks whether a client that is none of webloop's native ones can follow these settings; `client` is what it
    /// is called.
    ///
    /// # Errors
    /// [`InvalidSetting`], which names the transport.
    pub fn check_for(&self, client: &str) -> Result<(), InvalidSetting> {
        if !self.transport.is_native_only() {
            return Ok(());
        }
        Err(InvalidSetting {
            name: "transport",
            problem: format!("{client} has no transport `{}`", self.transport),
            remedy: "use http or websocket, or the client native",
        })
    }

    /// Checks whether a message can have a session, as the lease `token` asks.
    ///
    /// # Errors
    /// [`InvalidSetting`], which names the transport.
    pub fn check_session(&self) -> Result<(), InvalidSetting> {
        if self.transport.carriage() != Carriage::Datagrams {
            return Ok(());
        }
        Err(InvalidSetting {
            name: "transport",
            problem: format!(
                "over transport `{}` a command has no session",
                self.transport
            ),
            remedy: "use lease none or address, or another transport",
        })
    }
}

impl ControllerSettings {
    /// Checks whether a message can have a checksum.
    ///
    /// # Errors
    /// [`InvalidSetting`], which names the transport.
    pub fn check_checksum(&self) -> Result<(), InvalidSetting> {
        if self.transport != Transport::Json {
            return Ok(());
        }
        Err(InvalidSetting {
            name: "transport",
            problem: "over transport `json` a command has no checksum".to_owned(),
            remedy: "leave out check, or use another transport",
        })
    }
}

#[rustfmt::skip]
impl ControllerSettings {
    /// The settings that an experiment may choose for any client.
    pub const FIELDS: &[Field<Self>] = &[
        word_field!(transport, "http, json, tcp, udp or websocket; in Python and in a browser http or websocket", "TRANSPORT", true),
        word_field!(outstanding, "Requests under way: a number, or unlimited", "N", false),
        word_field!(connection, "keep or new", "CONNECTION", false),
        word_field!(schedule, "absolute, relative or since-send", "SCHEDULE", true),
        word_field!(integrate, "h or elapsed", "INTEGRATE", false),
        word_field!(late, "Overtaken answers: apply or drop", "LATE", false),
        span_field!("timeout", timeout_ns, "A request is given up after this time", 1),
    ];
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use text::column::UnknownWord;

    use super::*;
    use crate::page::{Sender, Thread, Timer};
    use crate::preset::Preset;

    #[test]
    fn words_read_back_as_they_are_written_and_serde_uses_the_same_ones() {
        fn check<T>(choices: &[T])
        where
            T: FromStr<Err = UnknownWord> + fmt::Display + Serialize + PartialEq + fmt::Debug,
        {
            for choice in choices {
                assert_eq!(choice.to_string().parse().as_ref(), Ok(choice));
                let json = serde_json::to_value(choice).expect("a word");
                assert_eq!(json, serde_json::Value::String(choice.to_string()));
            }
        }
        check(Mode::ALL);
        check(Connection::ALL);
        check(Schedule::ALL);
        check(Integrate::ALL);
        check(Late::ALL);
        check(Transport::ALL);
        check(Policy::ALL);
        check(Clock::ALL);
        check(Lease::ALL);
        check(Preset::ALL);
        check(Thread::ALL);
        check(Sender::ALL);
        check(Timer::ALL);
        assert_eq!(
            "opened".parse::<Mode>().map_err(|error| error.to_string()),
            Err("mode `opened` is unknown; choose open or closed".to_owned())
        );
    }

    #[test]
    fn outstanding_is_a_number_or_unlimited() {
        for (word, limit) in [("1", 1), ("8", 8), ("8192", 8192), ("unlimited", 8192)] {
            let outstanding: Outstanding = word.parse().expect(word);
            assert_eq!(outstanding.limit(), limit);
            assert_eq!(outstanding.to_string(), word);
            let json = serde_json::to_string(&outstanding).expect("a number or a word");
            assert_eq!(
                serde_json::from_str::<Outstanding>(&json).ok(),
                Some(outstanding)
            );
        }
        for word in ["0", "-1", "8193", "many", "", "1.5"] {
            assert!(word.parse::<Outstanding>().is_err(), "{word}");
        }
        assert!(serde_json::from_str::<Outstanding>("0").is_err());
    }

    proptest! {
        /// So that every client, and whoever reads a manifest, has the same reference.
        #[test]
        fn a_number_in_settings_reads_back_to_the_last_bit(r in -1e9..1e9) {
            let h = SampleTime::try_new(10_000_000).expect("10 ms");
            let settings = ControllerSettings { r, ..ControllerSettings::new(Mode::Closed, h) };
            let text = serde_json::to_string(&settings).expect("plain data");
            let read: ControllerSettings = serde_json::from_str(&text).expect("what was written");
            prop_assert_eq!(read.r.to_bits(), r.to_bits());
        }
    }
}
