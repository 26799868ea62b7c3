//! Runs in virtual time to which one thing was done, and whether blame names it.

use std::ops::Range;
use std::sync::LazyLock;

use analysis::blame::{Blame, Cause, End, Facts, Stamps};
use control::preset::{paper_pi, paper_plant};
use endpoint::{
    ArrivalRow, ControllerSettings, MessageOutcome, MessageRow, Mode, Outstanding, TickRow,
    Transport,
};
use link::{Epoch, Profile, Timeline};
use proptest::prelude::*;
use sim::{Pool, Record, Setup, Spread, Timing, run};

const MS: u64 = 1_000_000;
const START_NS: u64 = 500 * MS;
const DURATION_NS: u64 = 3_500 * MS;

#[derive(Default, Clone)]
struct Rows {
    ticks: Vec<TickRow>,
    arrivals: Vec<ArrivalRow>,
    messages: Vec<MessageRow>,
}

impl Record for Rows {
    fn tick(&mut self, row: &TickRow) {
        self.ticks.push(*row);
    }

    fn arrival(&mut self, row: &ArrivalRow) {
        self.arrivals.push(*row);
    }

    fn message(&mut self, row: &MessageRow) {
        self.messages.push(*row);
    }
}

/// What is done to a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Deed {
    /// The link holds all packets for a while, one way or both.
    Stall,
    /// All packets of a while are lost.
    Burst,
    /// The first messages over a long link open connections.
    Opening,
    /// The controller stands still as for a collection of garbage.
    Garbage,
    /// The controller is stopped for long.
    Pause,
    /// The plant is stopped for long.
    PlantPause,
    /// The plant has too little of its processor.
    SlowPlant,
    /// The link is lost for good.
    Cut,
    /// Nothing: the link is long.
    Long,
    /// The controller sends nothing any more.
    Silence,
    /// Nothing, over a short link.
    Nothing,
}

const DEEDS: [(Deed, Cause); 11] = [
    (Deed::Stall, Cause::Link),
    (Deed::Burst, Cause::Loss),
    (Deed::Opening, Cause::Connection),
    (Deed::Garbage, Cause::Controller),
    (Deed::Pause, Cause::Controller),
    (Deed::PlantPause, Cause::Plant),
    (Deed::SlowPlant, Cause::Plant),
    (Deed::Cut, Cause::Loss),
    (Deed::Long, Cause::Link),
    (Deed::Silence, Cause::Controller),
    (Deed::Nothing, Cause::Sampling),
];

/// Numbers without a pattern, the same in each test.
struct Draw(u64);

impl Draw {
    /// A whole number of a range (Steele, Lea and Flood, `SplitMix64`, 2014).
    fn of(&mut self, range: Range<u64>) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        range.start + (z ^ (z >> 31)) % (range.end - range.start)
    }
}

/// A run to which something is done, ready to be asked about.
struct Made {
    rows: Rows,
    link: Timeline,
    facts: Facts,
    about: String,
}

/// The link of a run: a base delay with some jitter, and what is done to it.
fn profile(deed: Deed, base_us: u64, way: &str, at_ms: u64, times_ms: u64) -> Profile {
    let (at_ms, jitter_us) = (at_ms + START_NS / MS, base_us / 20 + 1);
    let fault = match deed {
        Deed::Stall => format!("{way}at = '{at_ms}ms'\nfor = '2ms'\ndelay = '{times_ms}ms'"),
        Deed::Burst => format!("{way}at = '{at_ms}ms'\nfor = '{times_ms}ms'\nloss = '100%'"),
        Deed::Cut => format!("at = '{at_ms}ms'\nfor = '60s'\ndown = true"),
        _ => "at = '90s'\nfor = '1s'\ndown = true".to_owned(),
    };
    let text = format!(
        "name = 'm'\nabout = 'x'\n[both.delay]\nbase = '{base_us}us'\nhold = '5ms'\n\
         spread.normal = {{ mean = '{jitter_us}us', sd = '{jitter_us}us' }}\n[[fault]]\n{fault}\n"
    );
    let (profile, findings) = Profile::read(&text, "m", &|_| Err("no trace".to_owned()));
    profile.unwrap_or_else(|| panic!("{text}\n{findings:?}"))
}

/// When the controller stands still, and when the plant does: once, or again and again.
fn stops(deed: Deed, once: Range<u64>, h_ms: u64) -> [Vec<Range<u64>>; 2] {
    let slow = (0..)
        .map(|k| START_NS + k * 8 * h_ms * MS)
        .take_while(|t_ns| *t_ns < START_NS + DURATION_NS)
        .map(|t_ns| t_ns..t_ns + 6 * h_ms * MS);
    match deed {
        Deed::Garbage | Deed::Pause | Deed::Silence => [[once].into(), Vec::new()],
        Deed::PlantPause => [Vec::new(), [once].into()],
        Deed::SlowPlant => [Vec::new(), slow.collect()],
        _ => [Vec::new(), Vec::new()],
    }
}

fn make(deed: Deed, seed: u64) -> Made {
    let mut draw = Draw(seed * DEEDS.len() as u64 + deed as u64);
    let h_ms = [2, 5, 10, 20][draw.of(0..4) as usize];
    let outstanding = if draw.of(0..3) == 0 {
        Outstanding::ONE
    } else {
        Outstanding::Unlimited
    };
    let transport = Transport::ALL[draw.of(0..Transport::ALL.len() as u64) as usize];
    let (base_us, at_ms) = match deed {
        Deed::Opening => (h_ms * 1_000 + draw.of(4_000..15_000), 0),
        Deed::Long => (h_ms * 2_000 + draw.of(10_000..40_000), 0),
        _ => (draw.of(100..h_ms * 300), draw.of(1_000..2_400)),
    };
    let times_ms = match deed {
        Deed::Stall | Deed::Burst => draw.of(6 * h_ms + 20..20 * h_ms + 400),
        Deed::Garbage => draw.of(5 * h_ms + 20..5 * h_ms + 120),
        Deed::Pause | Deed::PlantPause => draw.of(150..1_000),
        _ => 4_000,
    };
    let way = ["way = 'up'\n", "way = 'down'\n", ""][draw.of(0..3) as usize];
    let profile = profile(deed, base_us, way, at_ms, times_ms);
    let from_ns = START_NS + at_ms * MS + draw.of(0..h_ms * MS);
    let stops = stops(deed, from_ns..from_ns + times_ms * MS, h_ms);
    let h = format!("{h_ms}ms").parse().expect("a sample time");
    // Over a long link it is connections that count, unless there is only one.
    let (outstanding, transport) = match deed {
        Deed::Opening => (Outstanding::Unlimited, Transport::Http),
        Deed::Long => (outstanding, Transport::WebSocket),
        _ => (outstanding, transport),
    };
    let settings = ControllerSettings {
        outstanding,
        transport,
        timeout_ns: 5_000 * MS,
        ..ControllerSettings::new(Mode::Closed, h)
    };
    let timing = Timing {
        late_ns: Spread::constant(60_000),
        up_ns: Spread::constant(80_000),
        down_ns: Spread::constant(70_000),
        opened_up_ns: Spread::constant(150_000),
        ..Timing::IDEAL
    };
    let plant = paper_plant().sampled(settings.h.ns()).expect("regular");
    let setup = Setup {
        seed,
        pool: [Pool::Shared, Pool::Own][draw.of(0..2) as usize],
        frozen: [&stops[0], &stops[1]],
        timing: &timing,
        start_ns: START_NS,
        after_ns: 500 * MS,
        ..Setup::ideal(
            &profile,
            settings,
            plant.stepper(),
            paper_pi().into(),
            DURATION_NS,
        )
    };
    let mut rows = Rows::default();
    run(&setup, &mut rows).expect("can be simulated");
    Made {
        rows,
        link: Timeline::new(&profile, seed, Epoch::at_ns(0)),
        facts: Facts {
            start_ns: START_NS,
            end_ns: START_NS + DURATION_NS,
            is_lost: false,
            h_ns: settings.h.ns(),
            outstanding: settings.outstanding,
            connection: settings.connection,
            transport: settings.transport,
            timeout_ns: settings.timeout_ns,
            bytes: setup.message_bytes,
        },
        about: format!(
            "h {h_ms} ms, base {base_us} us, {way:?} {times_ms} ms at {at_ms} ms, {:?}, {:?}, {:?}",
            settings.outstanding, settings.transport, setup.pool
        ),
    }
}

impl Made {
    fn blame(&self) -> Blame {
        let Rows {
            ticks,
            arrivals,
            messages,
        } = &self.rows;
        Blame::among(
            messages,
            arrivals,
            ticks,
            Some(self.link.clone()),
            &self.facts,
        )
        .expect("ticks")
    }
}

/// Of so many runs those that are not named rightly, in words.
fn misnamed(
    deed: Deed,
    runs: u64,
    right: impl Fn(&Blame, Transport) -> bool,
    change: impl Fn(&mut Made),
) -> Vec<String> {
    let wrong = |seed: u64| {
        let mut made = make(deed, seed);
        change(&mut made);
        let blame = made.blame();
        let sum: u64 = blame.parts_ns.iter().sum();
        assert_eq!(sum, blame.age_ns(), "{deed:?} {seed}");
        (!right(&blame, made.facts.transport))
            .then(|| format!("{deed:?} {seed} ({}): {blame}", made.about))
    };
    (1..=runs).filter_map(wrong).collect()
}

#[test]
fn of_a_hundred_runs_with_one_known_cause_it_is_named_in_ninety_five() {
    for (deed, cause) in DEEDS {
        let wrong = misnamed(deed, 100, |blame, _| blame.cause() == cause, |_| {});
        assert!(wrong.len() <= 5, "{wrong:#?}");
    }
}

#[test]
fn a_controller_that_is_silent_to_the_end_is_told_to_be() {
    let blame = make(Deed::Silence, 1).blame();
    assert!(blame.end == End::Over && blame.stands_out(), "{blame}");
    let silent_ns = DURATION_NS - blame.from_ns;
    assert_eq!(silent_ns, blame.age_ns());
    assert!(
        blame.part_ns(Cause::Controller) * 10 > silent_ns * 9,
        "{blame}"
    );
}

#[test]
fn what_comes_after_the_loop_was_lost_is_not_to_blame() {
    let mut made = make(Deed::Silence, 1);
    let silence = made.blame();
    // Lost before the silence, and in the midst of it.
    made.facts.is_lost = true;
    made.facts.end_ns = START_NS + silence.from_ns;
    let before = made.blame();
    assert_ne!(before.cause(), Cause::Controller, "{before}");
    made.facts.end_ns += 300 * MS;
    let amid = made.blame();
    assert_eq!((amid.end, amid.age_ns()), (End::Lost, 300 * MS), "{amid}");
    let words = amid.to_string();
    assert!(words.contains("until the loop was lost at"), "{words}");
}

static PLAIN: LazyLock<Made> = LazyLock::new(|| make(Deed::Nothing, 1));

proptest! {
    /// Files may be damaged: whatever the stamps, the parts are the age.
    #[test]
    fn the_parts_are_the_age_whatever_the_stamps(
        stamps in prop::collection::vec((any::<u64>(), prop::option::of(any::<u64>()), prop::option::of(any::<u64>()), prop::option::of(any::<u64>()), 0u64..9), 0..30),
        ticks in prop::collection::vec((any::<u64>(), any::<u64>(), prop::option::of(0u64..9)), 1..30),
        near in any::<bool>(),
    ) {
        let of = |t_ns: u64| if near { START_NS + t_ns % (20 * MS) } else { t_ns };
        let made = &*PLAIN;
        let like = made.rows.messages[0];
        let messages: Vec<MessageRow> = (0..).zip(&stamps).map(|(seq, (due, send, arrive, receive, tick))| MessageRow {
            seq,
            t_due_ns: of(*due),
            t_send_ns: send.map(of),
            t_arrive_ns: arrive.map(of),
            t_receive_ns: receive.map(of),
            tick: Some(*tick),
            ..like
        }).collect();
        let like = made.rows.ticks[0];
        let ticks: Vec<TickRow> = (0..).zip(&ticks).map(|(k, (due, tick, seq))| TickRow {
            k,
            t_due_ns: of(*due),
            t_tick_ns: of(*tick),
            seq: *seq,
            ..like
        }).collect();
        let blame = Blame::among(&messages, &[], &ticks, Some(made.link.clone()), &made.facts).expect("ticks");
        prop_assert_eq!(blame.parts_ns.iter().sum::<u64>(), blame.age_ns());
        prop_assert!(blame.age_ns() <= DURATION_NS);
        let _ = blame.to_string();
    }
}

/// What the plant's rows have of a program of one's own: which messages arrived, and when it says that it sent them.
fn as_of_a_stranger(made: &mut Made, says_when: bool) {
    made.facts.outstanding = Outstanding::ONE;
    for row in &mut made.rows.messages {
        if row.t_arrive_ns.is_none() {
            row.outcome = MessageOutcome::Missed;
            row.t_send_ns = None;
            continue;
        }
        row.outcome = MessageOutcome::Arrived;
        row.t_send_ns = row.t_send_ns.filter(|_| says_when);
        (row.t_receive_ns, row.y, row.e) = (None, None, None);
    }
}

#[test]
fn of_a_program_that_says_when_it_sends_the_cause_is_named_as_often() {
    for (deed, cause) in DEEDS {
        // A message that never came is not known to have been sent, and no datagram comes that was lost.
        let unseen = |blame: &Blame, transport| {
            let is_unseen =
                deed == Deed::Cut || (deed == Deed::Burst && transport == Transport::Udp);
            is_unseen && blame.cause() == Cause::Controller
        };
        let wrong = misnamed(
            deed,
            40,
            |blame, transport| blame.cause() == cause || unseen(blame, transport),
            |made| as_of_a_stranger(made, true),
        );
        assert!(wrong.len() <= 3, "{wrong:#?}");
    }
}

#[test]
fn of_a_program_that_does_not_say_it_the_link_and_the_plant_are_named_and_the_rest_is_not_told() {
    for (deed, cause) in DEEDS {
        let may = match cause {
            // A connection that is opened looks like a message that is sent later.
            Cause::Link | Cause::Connection => Cause::Link,
            Cause::Plant | Cause::Sampling => cause,
            _ => Cause::Untold,
        };
        let wrong = misnamed(
            deed,
            40,
            |blame, _| [cause, may].contains(&blame.cause()) && blame.stamps == Stamps::None,
            |made| as_of_a_stranger(made, false),
        );
        assert!(wrong.len() <= 3, "{wrong:#?}");
    }
}
