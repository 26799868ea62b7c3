//! The kinds of sabotage by name, each with its topology and the words by which a reason names it.

use std::sync::LazyLock;

use crate::delay::Held;
use crate::sabotage::{BOTH, DOWN, Sabotage, UP};
use crate::stop::{Beat, Who};

/// A kind of sabotage.
#[derive(Clone, Debug)]
pub(crate) struct Kind {
    pub(crate) name: String,
    /// Its topology, unless another one is given: a built-in one, or `narrow`, which has a rate.
    pub(crate) topology: &'static str,
    /// Its client, unless another one is given: a built-in one, or a program as experiments write it.
    pub(crate) client: &'static str,
    /// Whether its client keeps its connection, as experiments write it.
    pub(crate) connection: &'static str,
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
const LATE: Words = &[
    "late",
    "more than the link",
    "something else delays",
    "resent",
];
const PLAYER: Words = &["player"];
const PLANT: Words = &["plant"];
const CONTROLLER: Words = &["controller"];
const MACHINE: Words = &["machine"];
/// If a player plays another link, echoes show it too.
const LINK: Words = &["link", "echo", "round trip", "late", "quicker"];

/// A program of somebody's that opens a connection for each message and stamps it.
const EACH: &str = "{ name = \"each\", run = [\"./stranger\", \"each\", \"seq\", \"stamp\"] }";

/// All kinds.
pub(crate) static KINDS: LazyLock<Vec<Kind>> = LazyLock::new(|| {
    let mut kinds = whole();
    kinds.extend(shares());
    kinds
});

/// Whatever is done to all messages, or to none.
fn whole() -> Vec<Kind> {
    vec![
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
    ]
}

/// A share of the messages is late, by less than a period or two: over kept connections and over new ones, and with
/// a connection's opening alone.
fn shares() -> Vec<Kind> {
    let mut kinds = vec![
        each("each-clean", Sabotage::Nothing, NOTHING),
        each("each-syn-5ms-up", opening(5, UP), LATE).tested(),
        each("each-syn-5ms-both", opening(5, BOTH), LATE),
        anew("anew-clean", Sabotage::Nothing, NOTHING),
        anew("anew-syn-5ms-up", opening(5, UP), LATE).tested(),
        anew("anew-syn-5ms-both", opening(5, BOTH), LATE),
        anew("anew-delay-3ms-up", delay(3, UP), LATE),
        each("each-delay-3ms-up", delay(3, UP), LATE),
        each("each-delay-3ms-both", delay(3, BOTH), LATE),
    ];
    for percent in [5, 10, 50, 80] {
        for ms in [1, 2, 5, 9] {
            for (way, ways) in [("up", UP), ("both", BOTH)] {
                let held = share(percent, ms, ways);
                let kept = wired(&format!("share-{percent}-{ms}ms-{way}"), held, LATE);
                let is_tested = (percent, ms, way) == (10, 9, "both");
                kinds.push(if is_tested { kept.tested() } else { kept });
                let name = |of: &str| format!("{of}-share-{percent}-{ms}ms-{way}");
                kinds.push(each(&name("each"), held, LATE));
                kinds.push(anew(&name("anew"), held, LATE));
            }
        }
    }
    kinds
}

/// A kind over the default link, whose delay is short and steady.
fn wired(name: &str, sabotage: Sabotage, words: Words) -> Kind {
    Kind {
        name: name.to_owned(),
        topology: "buccoo",
        client: "native",
        connection: "keep",
        sabotage,
        words,
        tested: false,
    }
}

fn loopback(name: &str, sabotage: Sabotage, words: Words) -> Kind {
    Kind {
        topology: "arima",
        ..wired(name, sabotage, words)
    }
}

fn narrow(name: &str, sabotage: Sabotage, words: Words) -> Kind {
    Kind {
        topology: "narrow",
        ..wired(name, sabotage, words)
    }
}

/// A kind over the default link, with a new connection for each message of webloop's own client.
fn anew(name: &str, sabotage: Sabotage, words: Words) -> Kind {
    Kind {
        connection: "new",
        ..wired(name, sabotage, words)
    }
}

/// The same with a program of somebody's.
fn each(name: &str, sabotage: Sabotage, words: Words) -> Kind {
    Kind {
        client: EACH,
        ..wired(name, sabotage, words)
    }
}

impl Kind {
    fn tested(self) -> Kind {
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
    held(Held::Tcp, ms, ways)
}

const fn share(percent: u32, ms: u64, ways: &'static [link::Way]) -> Sabotage {
    held(Held::Share(percent), ms, ways)
}

const fn opening(ms: u64, ways: &'static [link::Way]) -> Sabotage {
    held(Held::Opening, ms, ways)
}

const fn delay_all_but_echoes(ms: u64) -> Sabotage {
    held(Held::AllButEchoes, ms, BOTH)
}

const fn held(held: Held, ms: u64, ways: &'static [link::Way]) -> Sabotage {
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
