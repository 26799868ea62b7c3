//! What a machine adds to a link: how long programs and their kernels take, as measured.
//!
//! A run's rows show each of these numbers: `late` is `t_send - t_due`, `up` is `t_arrive - t_send`
//! less the link's part, `down` is `t_receive - t_arrive` less the link's part. They are given as
//! measured spreads; `webloop calibrate` measures them on the machine it runs on.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::spread::Spread;

/// How long a client and its plant take over messages, whatever the link.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Timing {
    /// From a deadline to the message's leaving.
    pub late_ns: Spread,
    /// From there to the plant's having it, on an open connection, but for the link.
    pub up_ns: Spread,
    /// From there to the client's having the answer, but for the link.
    pub down_ns: Spread,
    /// The same as `up_ns` for the first message on a new connection, beyond its handshake.
    pub opened_up_ns: Spread,
    /// How long the client's thread is busy with sending a message: it does nothing else.
    pub send_ns: u32,
    /// The same with taking an answer.
    pub take_ns: u32,
    /// How long the plant's thread is busy with a message.
    pub serve_ns: u32,
    /// The least that a timer within a timer waits: browsers' setTimeout, on a page's main thread.
    #[serde(default)]
    pub clamp_ns: u32,
    /// What a player adds to a packet's way through a link, each way.
    pub player_ns: u32,
    /// Ticks a second of the kernel's timers (`CONFIG_HZ`): what is lost is sent again with one.
    #[serde(default = "hz")]
    pub hz: u32,
}

/// Most kernels have this.
const HZ: u32 = 250;

fn hz() -> u32 {
    HZ
}

impl Timing {
    /// A machine that takes no time: only deadlines, ticks and the link remain.
    pub const IDEAL: Self = Self {
        late_ns: Spread::constant(0),
        up_ns: Spread::constant(0),
        down_ns: Spread::constant(0),
        opened_up_ns: Spread::constant(0),
        send_ns: 0,
        take_ns: 0,
        serve_ns: 0,
        clamp_ns: 0,
        player_ns: 0,
        hz: HZ,
    };
}
