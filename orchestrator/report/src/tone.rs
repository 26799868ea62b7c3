//! The colours of figures: one for each client, the same everywhere.

use std::sync::LazyLock;

use chart::Tone;
use plan::{Client, ClientSpec};

/// The tone of the plant.
pub const PLANT_TONE: Tone = tone("plant", [0x7a, 0x7a, 0x7a], 0);
/// A quiet tone, for anything else.
pub const OTHER_TONE: Tone = tone("other", [0x9c, 0x9c, 0x9c], 0);

/// The tones of programs of one's own, in turn: with those of webloop's clients they can be told apart with any
/// kind of colour vision (M. Okabe and K. Ito, Color Universal Design, 2008).
pub const OWN_TONES: [Tone; 3] = [
    of_spec(ClientSpec::OWN),
    tone("own-2", [0xe6, 0x9f, 0x00], 0),
    tone("own-3", [0x56, 0xb4, 0xe9], 1),
];

/// The tones of all figures.
pub static TONES: LazyLock<Vec<Tone>> = LazyLock::new(|| {
    let clients = Client::ALL.into_iter().map(tone_of);
    let others = [PLANT_TONE, OTHER_TONE];
    clients.chain(OWN_TONES).chain(others).collect()
});

/// The tone of a client.
#[must_use]
pub fn tone_of(client: Client) -> Tone {
    of_spec(client.spec())
}

const fn of_spec(spec: &ClientSpec) -> Tone {
    tone(spec.name, spec.rgb, spec.dash)
}

const fn tone(name: &'static str, rgb: [u8; 3], dash: u8) -> Tone {
    Tone { name, rgb, dash }
}
