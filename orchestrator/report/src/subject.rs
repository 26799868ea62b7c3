//! What tables, figures and claims are about: a client with its preset, under one name and in one
//! colour everywhere.

use std::sync::LazyLock;

use chart::Tone;
use endpoint::Preset;
use plan::{Client, ClientSpec};

/// The tone of the plant.
pub(crate) const PLANT_TONE: Tone = tone("plant", [0x7a, 0x7a, 0x7a], 0);
/// A quiet tone, for anything else.
pub(crate) const OTHER_TONE: Tone = tone("other", [0x9c, 0x9c, 0x9c], 0);

/// The tones of programs of one's own, in turn: with those of webloop's clients they can be told apart with any
/// kind of colour vision (M. Okabe and K. Ito, Color Universal Design, 2008).
pub(crate) const OWN_TONES: [Tone; 3] = [
    of_spec(ClientSpec::OWN),
    tone("own-2", [0xe6, 0x9f, 0x00], 0),
    tone("own-3", [0x56, 0xb4, 0xe9], 1),
];

/// The tones of all figures.
pub(crate) static TONES: LazyLock<Vec<Tone>> = LazyLock::new(|| {
    let clients = Client::ALL.into_iter().map(tone_of);
    let others = [PLANT_TONE, OTHER_TONE];
    clients.chain(OWN_TONES).chain(others).collect()
});

/// The tone of a client.
pub(crate) fn tone_of(client: Client) -> Tone {
    of_spec(client.spec())
}

const fn of_spec(spec: &ClientSpec) -> Tone {
    tone(spec.name, spec.rgb, spec.dash)
}

const fn tone(name: &'static str, rgb: [u8; 3], dash: u8) -> Tone {
    Tone { name, rgb, dash }
}

/// A client with its preset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Subject {
    /// The client.
    pub(crate) client: Client,
    /// Its preset.
    pub(crate) preset: Preset,
}

/// webloop's own client, the yardstick.
pub(crate) const NATIVE: Subject = Subject::of(Client::Native, Preset::PaperPython);
/// The paper's Python client.
pub(crate) const PYTHON: Subject = Subject::of(Client::Python, Preset::PaperPython);
/// The paper's JavaScript client in the paper's browser, which decides the claims about JavaScript.
pub(crate) const FIREFOX_2011: Subject = Subject::of(Client::Firefox, Preset::Paper2011);
/// The same program in a browser that the paper does not name: it is shown but decides nothing.
pub(crate) const CHROMIUM_2011: Subject = Subject::of(Client::Chromium, Preset::Paper2011);
/// The paper's program with the timers of today, in Firefox.
pub(crate) const FIREFOX_TODAY: Subject = Subject::of(Client::Firefox, Preset::Today);
/// The paper's program with the timers of today, in Chromium.
pub(crate) const CHROMIUM_TODAY: Subject = Subject::of(Client::Chromium, Preset::Today);
/// The program of today, with a worker, in Firefox.
pub(crate) const FIREFOX_WORKER: Subject = Subject::of(Client::Firefox, Preset::Worker);
/// The program of today, with a worker, in Chromium.
pub(crate) const CHROMIUM_WORKER: Subject = Subject::of(Client::Chromium, Preset::Worker);

impl Subject {
    const fn of(client: Client, preset: Preset) -> Subject {
        Subject { client, preset }
    }

    /// The client, and for a browser its preset: `firefox, paper-2011`.
    pub(crate) fn name(self) -> String {
        self.joined(", ")
    }

    /// The same without a comma, for lists: `firefox paper-2011`.
    pub(crate) fn label(self) -> String {
        self.joined(" ")
    }

    fn joined(self, between: &str) -> String {
        if self.client.is_browser() {
            format!("{}{between}{}", self.client, self.preset)
        } else {
            self.client.to_string()
        }
    }

    /// The client's tone.
    pub(crate) fn tone(self) -> Tone {
        tone_of(self.client)
    }
}
