//! Who closes the loop, which is the paper's question: an entry for each client, with everything that
//! webloop knows about it.

use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;
use std::time::Duration;

use endpoint::report::Engine;
use endpoint::{ControllerSettings, InvalidSetting, Lease, Preset, Transport};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use text::column::{EntryType, Typed};
use text::one_of;

use crate::allowance::{Allowance, Tail};
use crate::client_name::{CHROMIUM, FIREFOX, NATIVE, PYTHON};
use crate::file_name::{CONTROLLER_LOG, CONTROLLER_REPORT, MESSAGES, PAGE_REPORT};
use crate::own::OwnName;

/// Everything that webloop knows about a client.
#[derive(Debug, Clone, Copy)]
pub struct ClientSpec {
    /// Name in plans, tables and commands; the container image is `webloop-` with this name. A program of
    /// one's own has its [`OwnName`] instead.
    pub name: &'static str,
    /// Name in a sentence.
    pub prose: &'static str,
    /// Role of `webloop serve` that runs it.
    pub role: &'static str,
    /// The browser that it needs, if it is a page.
    pub engine: Option<Engine>,
    /// Time from its start until it waits for its first deadline, on this machine: a browser has to
    /// start, with two busy cores, and its page has to load and check its clock.
    pub start_time: Duration,
    /// How long it may take to end after its last deadline and time-out. A page still has to send its
    /// last rows, over the link.
    pub grace: Duration,
    /// The files that it writes at its own end.
    pub files: &'static [&'static str],
    /// Its files at the plant's end: a page cannot write files, so it sends its rows to the plant.
    pub files_at_plant: &'static [&'static str],
    /// Mean length of a message's IP packets over HTTP, bytes: the request up and the answer down. They
    /// take time if the link has a rate limit. Counted on real links, except for browsers, whose values
    /// are computed from their HTTP headers.
    pub http_bytes: [u32; 2],
    /// Whether a message that finds no idle connection waits for the one that is opened for it, rather
    /// than for whichever is free first: each worker of the Python client keeps its own.
    pub keeps_own_connections: bool,
    /// The preset where an experiment names none: the one that suits it best.
    pub preset: Preset,
    /// How much of a message's time the judge allows it.
    pub allowance: Allowance,
    /// Its colour in figures as red, green and blue, from the set of Okabe and Ito
    /// (<https://jfly.uni-koeln.de/color/>), which is designed for every kind of colour vision.
    pub rgb: [u8; 3],
    /// Index of its first dash and marker in figures, so that browsers differ from the others, and from
    /// each other, in grey too.
    pub dash: u8,
}

/// Defines [`Client`] from the entries, so that each client is described in one place.
macro_rules! clients {
    ($($(#[$meta:meta])* $client:ident = $spec:expr;)+) => {
        /// A program that can be the controller.
        #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Client {
            $($(#[$meta])* $client,)+
            /// A program of one's own, by its name in the plan.
            Own(OwnName),
        }

        impl Client {
            /// Every client of webloop's.
            pub const ALL: [Client; [$(Client::$client),+].len()] = [$(Client::$client),+];

            /// The client's entry.
            #[must_use]
            pub const fn spec(self) -> &'static ClientSpec {
                match self {
                    $(Client::$client => const { &$spec },)+
                    Client::Own(_) => const { &OWN },
                }
            }
        }
    };
}

clients! {
    /// webloop's own, in Rust.
    #[default]
    Native = ClientSpec {
        name: NATIVE,
        prose: "native",
        role: "controller",
        engine: None,
        start_time: Duration::ZERO,
        grace: Duration::from_secs(10),
        files: &[MESSAGES, CONTROLLER_REPORT, CONTROLLER_LOG],
        files_at_plant: &[],
        http_bytes: [166, 288],
        keeps_own_connections: false,
        preset: Preset::PaperPython,
        allowance: Allowance {
            enters_within_ms: 1.0,
            strays_within_ms: 3.0,
            late_share: 0.005,
            up_floor_ms: 0.8,
            down_floor_ms: 0.8,
            opening_ms: 0.7,
            tail: [tail(0.6, 0.02), tail(2.5, 0.01)],
            message_ms: 0.1,
            clock_ms: 0.0,
            keeps_time: true,
        },
        rgb: [0x30, 0x30, 0x30],
        dash: 0,
    };
    /// The paper's, in Python.
    Python = ClientSpec {
        name: PYTHON,
        prose: "Python",
        role: "python",
        engine: None,
        start_time: Duration::from_millis(300),
        grace: Duration::from_secs(10),
        files: &[MESSAGES, CONTROLLER_REPORT, CONTROLLER_LOG],
        files_at_plant: &[],
        http_bytes: [179, 287],
        keeps_own_connections: true,
        preset: Preset::PaperPython,
        allowance: Allowance {
            enters_within_ms: 3.0,
            strays_within_ms: 10.0,
            late_share: 0.005,
            up_floor_ms: 1.2,
            down_floor_ms: 1.2,
            opening_ms: 1.0,
            tail: [tail(1.5, 0.03), tail(4.0, 0.015)],
            message_ms: 1.0,
            clock_ms: 0.0,
            keeps_time: false,
        },
        // The paper's blue.
        rgb: [0x00, 0x72, 0xb2],
        dash: 0,
    };
    /// A page in Chromium, or in Chrome.
    Chromium = page(CHROMIUM, "Chromium", Engine::Chromium, [0xd5, 0x5e, 0x00], 2);
    // The paper's green.
    /// A page in Firefox.
    Firefox = page(FIREFOX, "Firefox", Engine::Firefox, [0x00, 0x9e, 0x73], 1);
}

/// The entry of every program of one's own, of which nothing is known but its processor time: what it may take is what
/// webloop's own takes, and that time twice, which `judge` adds.
const OWN: ClientSpec = ClientSpec {
    name: "own",
    prose: "own",
    role: "program",
    engine: None,
    start_time: Duration::from_secs(2),
    grace: Duration::from_secs(5),
    files: &[CONTROLLER_REPORT, CONTROLLER_LOG],
    files_at_plant: &[],
    http_bytes: [179, 287],
    keeps_own_connections: false,
    preset: Preset::PaperPython,
    allowance: Allowance {
        enters_within_ms: 3.0,
        strays_within_ms: 20.0,
        late_share: 0.015,
        up_floor_ms: 0.8,
        down_floor_ms: 0.8,
        opening_ms: 1.0,
        tail: [tail(0.6, 0.02), tail(2.5, 0.01)],
        message_ms: 1.0,
        clock_ms: 0.1,
        keeps_time: false,
    },
    // The purple of the same set.
    rgb: [0xcc, 0x79, 0xa7],
    dash: 3,
};

/// A step of a tail.
const fn tail(beyond_ms: f64, share: f64) -> Tail {
    Tail { beyond_ms, share }
}

/// The entry of the page in a browser; the parameters are all that differs between browsers.
const fn page(
    name: &'static str,
    prose: &'static str,
    engine: Engine,
    rgb: [u8; 3],
    dash: u8,
) -> ClientSpec {
    ClientSpec {
        name,
        prose,
        role: "browser",
        engine: Some(engine),
        start_time: Duration::from_secs(6),
        grace: Duration::from_secs(70),
        files: &[CONTROLLER_REPORT, CONTROLLER_LOG],
        files_at_plant: &[MESSAGES, PAGE_REPORT],
        http_bytes: [520, 400],
        keeps_own_connections: false,
        preset: Preset::Worker,
        allowance: Allowance {
            enters_within_ms: 10.0,
            strays_within_ms: 20.0,
            late_share: 0.015,
            up_floor_ms: 5.0,
            down_floor_ms: 5.0,
            opening_ms: 3.0,
            tail: [tail(4.0, 0.05), tail(9.0, 0.02)],
            message_ms: 2.0,
            clock_ms: 1.5,
            keeps_time: false,
        },
        rgb,
        dash,
    }
}

impl ClientSpec {
    /// The entry of every program of one's own.
    pub const OWN: &'static ClientSpec = &OWN;
}

impl Client {
    /// The clients with which every client's settling is compared: webloop's own, and the paper's.
    pub const YARDSTICKS: [Client; 2] = [Client::Native, Client::Python];

    /// Whether it is a program of one's own.
    #[must_use]
    pub const fn is_own(self) -> bool {
        matches!(self, Client::Own(_))
    }

    /// Its name in plans, tables and commands.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Client::Own(name) => name.as_str(),
            client => client.spec().name,
        }
    }

    /// Its name in a sentence.
    #[must_use]
    pub fn prose(&self) -> &str {
        match self {
            Client::Own(name) => name.as_str(),
            client => client.spec().prose,
        }
    }

    /// Whether it is a page in a browser.
    #[must_use]
    pub fn is_browser(self) -> bool {
        self.spec().engine.is_some()
    }

    /// Checks whether it can follow these settings of a controller whose plant has this lease. A program of one's own
    /// is told them, and may say that it cannot.
    ///
    /// # Errors
    /// [`InvalidSetting`], which names the setting to change.
    pub fn check(self, settings: &ControllerSettings, lease: Lease) -> Result<(), InvalidSetting> {
        settings.check()?;
        if lease == Lease::Token {
            settings.check_session()?;
        }
        match self {
            Client::Native | Client::Own(_) => Ok(()),
            Client::Python | Client::Chromium | Client::Firefox => {
                settings.check_for(&format!("client `{}`", self.name()))
            }
        }
    }

    /// Mean length of a message's IP packets up and down, bytes; see [`ClientSpec::http_bytes`].
    #[must_use]
    pub fn message_bytes(self, transport: Transport) -> [u32; 2] {
        match transport {
            Transport::Http => self.spec().http_bytes,
            // Only the native client has these three. Counted by the player of buccoo, beside the other two.
            Transport::Json => [239, 283],
            Transport::Tcp => [107, 138],
            Transport::Udp => [94, 113],
            Transport::WebSocket => [112, 139],
        }
    }

    /// What to give in place of a word that is no client.
    fn or_nearest(word: &str) -> String {
        let names = Client::ALL.map(|client| client.spec().name);
        let remedy = format!("choose {}", Client::choices());
        if word.contains([' ', '.', '/']) {
            return format!("{remedy}; a program of your own runs by `webloop try -- {word}`");
        }
        text::or_nearest(word, names, &remedy)
    }

    /// The names to choose from: `native, python, chromium or firefox`.
    #[must_use]
    pub fn choices() -> String {
        one_of(&Client::ALL.map(|client| client.spec().name))
    }
}

/// A word that is not the name of a client.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("client `{0}` is unknown; {remedy}", remedy = Client::or_nearest(.0))]
pub struct UnknownClient(String);

impl Typed for Client {
    const ENTRY: EntryType = EntryType::String;
}

impl FromStr for Client {
    type Err = UnknownClient;

    fn from_str(word: &str) -> Result<Self, UnknownClient> {
        Client::ALL
            .into_iter()
            .find(|client| client.spec().name == word)
            .ok_or_else(|| UnknownClient(word.to_owned()))
    }
}

impl fmt::Display for Client {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl Serialize for Client {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for Client {
    /// A name that is none of webloop's clients is one's own; the plan says whether there is such a program.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let word = String::deserialize(deserializer)?;
        match word.parse() {
            Ok(client) => Ok(client),
            Err(UnknownClient(_)) => word.parse().map(Client::Own).map_err(D::Error::custom),
        }
    }
}

impl JsonSchema for Client {
    fn schema_name() -> Cow<'static, str> {
        "Client".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": format!(
                "A program that can be the controller: {}, or one of the plan's `programs`.",
                Client::choices()
            ),
            "type": "string",
            "pattern": "^[a-z0-9][a-z0-9-]{0,23}$"
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::client_name::NAMES;

    #[test]
    fn the_names_that_no_program_may_have_are_those_of_all_clients() {
        assert_eq!(Client::ALL.map(|client| client.spec().name), NAMES);
    }

    #[test]
    fn a_client_is_read_as_it_is_written_and_as_a_plan_has_it() {
        for client in Client::ALL {
            assert_eq!(client.to_string().parse(), Ok(client));
            let json = serde_json::to_value(client).expect("a word");
            assert_eq!(json, client.to_string());
        }
        let own: Client = serde_json::from_str("\"mine\"").expect("a name");
        assert!(own.is_own() && own.to_string() == "mine");
        assert!("mine".parse::<Client>().is_err());
    }
}
