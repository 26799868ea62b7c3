//! Whom tables, figures and claims are about: a client with its preset, under one name and in one
//! colour everywhere.

use chart::Tone;
use endpoint::Preset;
use plan::Client;

/// webloop's own client.
const NATIVE_TONE: Tone = tone("native", [0x30, 0x30, 0x30], 0);
/// The paper's blue.
const PYTHON_TONE: Tone = tone("python", [0x00, 0x72, 0xb2], 0);
/// Browsers are told apart from the others, and from each other, in grey too.
const CHROMIUM_TONE: Tone = tone("chromium", [0xd5, 0x5e, 0x00], 2);
/// The paper's green.
const FIREFOX_TONE: Tone = tone("firefox", [0x00, 0x9e, 0x73], 1);
/// The plant's.
pub(crate) const PLANT_TONE: Tone = tone("plant", [0x7a, 0x7a, 0x7a], 0);
/// Anything else: quiet.
pub(crate) const OTHER_TONE: Tone = tone("other", [0x9c, 0x9c, 0x9c], 0);

/// The tones of all figures. The clients' are from Okabe and Ito's set
/// (<https://jfly.uni-koeln.de/color/>), which is made to be told apart with any kind of colour vision.
pub(crate) const TONES: [Tone; 6] = [
    NATIVE_TONE,
    PYTHON_TONE,
    CHROMIUM_TONE,
    FIREFOX_TONE,
    PLANT_TONE,
    OTHER_TONE,
];

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
/// The paper's JavaScript client in the paper's browser: what claims on JavaScript are judged by.
pub(crate) const FIREFOX_2011: Subject = Subject::of(Client::Firefox, Preset::Paper2011);
/// The same program in a browser that the paper does not name: shown beside, and decides nothing.
pub(crate) const CHROMIUM_2011: Subject = Subject::of(Client::Chromium, Preset::Paper2011);
/// That program with the timers of today, in Firefox.
pub(crate) const FIREFOX_TODAY: Subject = Subject::of(Client::Firefox, Preset::Today);
/// In Chromium.
pub(crate) const CHROMIUM_TODAY: Subject = Subject::of(Client::Chromium, Preset::Today);
/// What Firefox can do today.
pub(crate) const FIREFOX_WORKER: Subject = Subject::of(Client::Firefox, Preset::Worker);
/// What Chromium can do today.
pub(crate) const CHROMIUM_WORKER: Subject = Subject::of(Client::Chromium, Preset::Worker);

impl Subject {
    const fn of(client: Client, preset: Preset) -> Subject {
        Subject { client, preset }
    }

    /// The client, with its preset where that says more: a browser is known by its page.
    pub(crate) fn name(self) -> String {
        self.joined(", ")
    }

    /// The same as one word of a list: `firefox paper-2011`.
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

    /// The client's.
    pub(crate) fn tone(self) -> Tone {
        match self.client {
            Client::Native => NATIVE_TONE,
            Client::Python => PYTHON_TONE,
            Client::Chromium => CHROMIUM_TONE,
            Client::Firefox => FIREFOX_TONE,
        }
    }
}
