//! The colours of figures: one for each client, the same everywhere.

use std::sync::LazyLock;

use analysis::Campaign;
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

/// The tones of figures about clients.
pub static TONES: LazyLock<Vec<Tone>> = LazyLock::new(|| {
    let clients = Client::ALL.into_iter().map(tone_of);
    let others = [PLANT_TONE, OTHER_TONE];
    clients.chain(OWN_TONES).chain(others).collect()
});

/// The same, with those of the parts of a delay.
pub static TONES_WITH_PARTS: LazyLock<Vec<Tone>> =
    LazyLock::new(|| TONES.iter().copied().chain(PART_TONES).collect());

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

/// The clients' tones in one campaign: those of one's own take theirs in turn, in the plan's order.
#[derive(Debug, Clone)]
pub struct Tones(Vec<Client>);

impl Tones {
    /// The tones for the clients of a campaign.
    #[must_use]
    pub fn of(campaign: &Campaign) -> Tones {
        let mut own: Vec<Client> = Vec::new();
        for client in campaign.runs.iter().map(|run| run.cell.client) {
            if client.is_own() && !own.contains(&client) {
                own.push(client);
            }
        }
        Tones(own)
    }

    /// A client's tone.
    #[must_use]
    pub fn tone(&self, client: Client) -> Tone {
        match self.0.iter().position(|own| *own == client) {
            Some(nth) => OWN_TONES[nth % OWN_TONES.len()],
            None => tone_of(client),
        }
    }
}

/// The tones of the parts of a sample's delay, in the order of
/// [`Part::ALL`](analysis::budget::Part::ALL): the link's are warm, the ends'
/// are blue, and waiting is grey and green.
pub const PART_TONES: [Tone; 8] = [
    tone("read", [0x00, 0x9e, 0x73], 0),
    tone("answer", [0x56, 0xb4, 0xe9], 0),
    tone("down", [0xe6, 0x9f, 0x00], 0),
    tone("law", [0xc8, 0xc8, 0xc8], 0),
    tone("late", [0xcc, 0x79, 0xa7], 0),
    tone("up", [0xd5, 0x5e, 0x00], 0),
    tone("request", [0x00, 0x72, 0xb2], 0),
    tone("tick", [0x7f, 0xd3, 0xb5], 0),
];
