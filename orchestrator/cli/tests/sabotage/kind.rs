//! The kinds of sabotage by name, each with its topology and the words by which a reason names it.

use crate::delay::Held;
use crate::sabotage::{BOTH, DOWN, Sabotage, UP};
use crate::stop::{Beat, Who};

/// A kind of sabotage.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kind {
    pub(crate) name: &'static str,
    /// Its topology, unless another one is given: a built-in one, or `narrow`, which has a rate.
    pub(crate) topology: &'static str,
    pub(crate) sabotage: Sabotage,
    /// A reason names the sabotage if it contains one of these. Empty if nothing is done.
    pub(crate) words: Words,
    /// Whether it is one of the few that a test run makes.
    pub(crate) tested: bool,
}

type Words = &'static [&'static str];

// Words in reasons about messages, and about what affected them. Everything that depends on
// webloop's wording is here.
const NOTHING: Words = &[];
const QUICK: Words = &["quicker"];
const LOST: Words = &["lost", "resent"];
const LATE: Words = &["late", "more than the link", "resent"];
const PLAYER: Words = &["player"];
const PLANT: Words = &["plant"];
const CONTROLLER: Words = &["controller"];
const MACHINE: Words = &["machine"];
/// If a player plays another link, echoes show it too.
const LINK: Words = &["link", "echo", "round trip", "late", "quicker"];

/// All kinds.
pub(crate) const KINDS: &[Kind] = &[
    wired("clean", Sabotage::Nothing, NOTHING).tested(),
    wired("around-both", Sabotage::Around(BOTH), QUICK).tested(),
    wired("around-up", Sabotage::Around(UP), QUICK),
    wired("around-down", Sabotage::Around(DOWN), QUICK).tested(),
    wired("drop-1", drop(1), LOST),
    wired("drop-2", drop(2), LOST).tested(),
    wired("drop-5", drop(5), LOST),
    wired("delay-2ms-both", delay(2, BOTH), LATE),
    wired("delay-2ms-up", delay(2, UP), LATE).tested(),
    wired("delay-2ms-down", delay(2, DOWN), LATE),
    wired("delay-10ms-both", delay(10, BOTH), LATE),
    wired("delay-10ms-up", delay(10, UP), LATE),
    wired("delay-10ms-down", delay(10, DOWN), LATE),
    wired("echoes-first-2ms", delay_all_but_echoes(2), LATE),
    wired("echoes-first-400kbit", bucket_but_echoes("400kbit"), LATE).tested(),
    wired("player-stop-20ms", once(Who::Player, 20), PLAYER),
    wired("player-stop-50ms", once(Who::Player, 50), PLAYER),
    wired("player-stop-300ms", once(Who::Player, 300), PLAYER),
    wired("player-stop-20ms-100ms", player(20, 100), PLAYER).tested(),
    wired("player-stop-20ms-170ms", player(20, 170), PLAYER),
    wired("player-stop-50ms-1s", player(50, 1000), PLAYER),
    wired("plant-stop-10ms-200ms", plant(10, 200), PLANT),
    wired("plant-stop-10ms-100ms", plant(10, 100), PLANT).tested(),
    wired("plant-stop-50ms-1s", plant(50, 1000), PLANT),
    wired(
        "controller-stop-10ms-200ms",
        controller(10, 200),
        CONTROLLER,
    ),
    wired(
        "controller-stop-10ms-100ms",
        controller(10, 100),
        CONTROLLER,
    )
    .tested(),
    wired("controller-stop-50ms-1s", controller(50, 1000), CONTROLLER),
    wired("hog-10ms-20ms", hog(10, 20), MACHINE).tested(),
    wired("hog-50ms-100ms", hog(50, 100), MACHINE),
    wired("seed", Sabotage::Seed, LINK).tested(),
    wired("rate-64kbit", Sabotage::Rate("64kbit"), LINK),
    wired("rate-1mbit", Sabotage::Rate("1mbit"), LINK).tested(),
    wired("bucket-64kbit", bucket("64kbit"), LATE),
    // At 333 Hz less goes through the link than this rate lets through, so hardly any packet waits.
    wired("bucket-1mbit", bucket("1mbit"), LATE),
    loopback("loopback-clean", Sabotage::Nothing, NOTHING),
    loopback("loopback-drop-1", drop(1), LOST),
    loopback("loopback-drop-5", drop(5), LOST).tested(),
    loopback("loopback-delay-2ms", delay(2, BOTH), LATE).tested(),
    loopback("loopback-delay-10ms", delay(10, BOTH), LATE),
    loopback("loopback-bucket-1mbit", bucket("1mbit"), LATE),
    loopback("loopback-plant-stop", plant(10, 100), PLANT),
    loopback("loopback-controller-stop", controller(10, 100), CONTROLLER),
    loopback("loopback-hog", hog(10, 20), MACHINE),
    narrow("narrow-clean", Sabotage::Nothing, NOTHING),
    narrow("narrow-around-both", Sabotage::Around(BOTH), QUICK).tested(),
    narrow("narrow-around-down", Sabotage::Around(DOWN), QUICK),
    narrow("narrow-drop-2", drop(2), LOST),
    narrow("narrow-delay-2ms-up", delay(2, UP), LATE),
    narrow("narrow-delay-10ms-up", delay(10, UP), LATE),
    narrow("narrow-player-stop-20ms-100ms", player(20, 100), PLAYER),
    narrow("narrow-rate-1mbit", Sabotage::Rate("1mbit"), LINK),
    narrow("narrow-bucket-64kbit", bucket("64kbit"), LATE),
];

/// A kind over the default link, whose delay is short and steady.
const fn wired(name: &'static str, sabotage: Sabotage, words: Words) -> Kind {
    Kind {
        name,
        topology: "buccoo",
        sabotage,
        words,
        tested: false,
    }
}

const fn loopback(name: &'static str, sabotage: Sabotage, words: Words) -> Kind {
    Kind {
        topology: "arima",
        ..wired(name, sabotage, words)
    }
}

const fn narrow(name: &'static str, sabotage: Sabotage, words: Words) -> Kind {
    Kind {
        topology: "narrow",
        ..wired(name, sabotage, words)
    }
}

impl Kind {
    const fn tested(self) -> Kind {
        Kind {
            tested: true,
            ..self
        }
    }
}

const fn drop(percent: u32) -> Sabotage {
    Sabotage::Drop { percent }
}

const fn delay(ms: u64, ways: &'static [link::Way]) -> Sabotage {
    let held = Held::Tcp;
    Sabotage::Delay { held, ms, ways }
}

const fn delay_all_but_echoes(ms: u64) -> Sabotage {
    let (held, ways) = (Held::AllButEchoes, BOTH);
    Sabotage::Delay { held, ms, ways }
}

const fn bucket(rate: &'static str) -> Sabotage {
    let spares_echoes = false;
    Sabotage::Bucket {
        rate,
        spares_echoes,
    }
}

const fn bucket_but_echoes(rate: &'static str) -> Sabotage {
    let spares_echoes = true;
    Sabotage::Bucket {
        rate,
        spares_echoes,
    }
}

const fn once(who: Who, length_ms: u64) -> Sabotage {
    Sabotage::Stop(who, Beat::once(length_ms))
}

const fn player(length_ms: u64, every_ms: u64) -> Sabotage {
    Sabotage::Stop(Who::Player, Beat::each(length_ms, every_ms))
}

const fn plant(length_ms: u64, every_ms: u64) -> Sabotage {
    Sabotage::Stop(Who::Plant, Beat::each(length_ms, every_ms))
}

const fn controller(length_ms: u64, every_ms: u64) -> Sabotage {
    Sabotage::Stop(Who::Controller, Beat::each(length_ms, every_ms))
}

const fn hog(length_ms: u64, every_ms: u64) -> Sabotage {
    Sabotage::Hog(Beat::each(length_ms, every_ms))
}
