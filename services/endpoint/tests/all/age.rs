//! What a plant does with commands that were held, repeated, overtaken, lost, or stamped by a wrong clock: a thousand
//! of each kind under each lease, with and without a limit of age, by a clock that is shared and by one of its own,
//! with silences around the lease's time before them.
//!
//! What is true is known, since the test sends: no command older than the limit is applied, none twice, and a good
//! clock is heard again within a second.

use std::{collections::BTreeSet, net::IpAddr};

use control::{Continuous, Method, Plant, TransferFunction};
use endpoint::{
    ArrivalOutcome, Clock, Command, Inbox, Late, Lease, Mode, Output, PlantEnd, PlantSettings,
    Request, SampleTime,
};
use proptest::prelude::*;

/// A thousand, where it is measured; fewer in a build for tests.
const EACH: u64 = if cfg!(debug_assertions) { 100 } else { 1000 };

const MS: u64 = 1_000_000;
const S: u64 = 1_000 * MS;
const MAX_AGE: u64 = 50 * MS;
const H: u64 = 10 * MS;

/// Splitmix64.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ mixed >> 31) % limit
    }

    fn of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len() as u64) as usize]
    }
}

/// A plant, a controller, the way between them, and what was applied.
struct World {
    plant: PlantEnd,
    random: Random,
    has_limit: bool,
    /// The controller's clock shows this much more than the plant's.
    ahead_ns: i64,
    /// The way of a command that nothing holds up: this, and up to 5 ms more.
    way_ns: u64,
    now_ns: u64,
    seq: u64,
    good: Vec<Command>,
    applied: BTreeSet<u64>,
}

impl World {
    fn new(seed: u64, settings: PlantSettings) -> Self {
        let mut random = Random(seed);
        let motor = TransferFunction::try_new([1.0], [1.0, 1.0], Continuous).expect("valid");
        let sampled = Plant::new(&motor, Method::ZeroOrderHold).sampled(settings.h.ns());
        let stepper = sampled.expect("it can be sampled").stepper();
        let ahead_ns = match settings.clock {
            Clock::Shared => 0,
            Clock::Own => random.below(2_000 * S).cast_signed() - (1_000 * S).cast_signed(),
        };
        Self {
            plant: PlantEnd::new(&settings, stepper, 0),
            has_limit: settings.max_age_ns.is_some(),
            ahead_ns,
            way_ns: random.below(30 * MS),
            now_ns: 5_000 * S + random.below(S),
            seq: 0,
            good: Vec::new(),
            applied: BTreeSet::new(),
            random,
        }
    }

    /// A command that is sent now, whose stamp is wrong by so much.
    fn stamped(&mut self, wrong_ns: i64) -> Command {
        self.seq += 1;
        let own_ns = self.now_ns.cast_signed() + self.ahead_ns + wrong_ns;
        Command {
            seq: self.seq,
            t_send_ns: own_ns as u64,
            u: 1.0.into(),
        }
    }

    /// What becomes of a command that arrives now. None is applied twice.
    fn arrives(&mut self, command: &Command) -> bool {
        let (row, _) = self.plant.command(Mode::Closed, command, self.now_ns);
        let is_applied = row.outcome == ArrivalOutcome::Applied;
        if is_applied {
            assert!(self.applied.insert(command.seq), "applied twice");
        }
        is_applied
    }

    /// A command with a right stamp and no hindrance, and the next deadline; whether it was applied.
    fn good(&mut self) -> bool {
        let command = self.stamped(0);
        let sent_ns = self.now_ns;
        self.now_ns += self.way_ns + self.random.below(5 * MS);
        let is_applied = self.arrives(&command);
        self.good.push(command);
        self.now_ns = (sent_ns + H).max(self.now_ns);
        is_applied
    }

    /// A controller has run for a while, and perhaps been silent.
    fn warm(&mut self) {
        for n in 0..5 + self.random.below(40) {
            assert!(self.good(), "good command {n}");
        }
        self.now_ns += self
            .random
            .of(&[0, 0, 500 * MS, 1_900 * MS, 2_000 * MS, 2_100 * MS, 6 * S]);
    }

    /// Longer than any command may be under way.
    fn long(&mut self) -> u64 {
        let some = 90 * MS + self.random.below(10 * S);
        self.random
            .of(&[90 * MS, S, 1_900 * MS, 2_200 * MS, 5 * S, some])
    }

    /// Good commands again: one is heard within a second, and then all.
    fn recovers(&mut self, what: &str) {
        let from_ns = self.now_ns;
        let mut heard = 0;
        while self.now_ns - from_ns < S {
            heard += u64::from(self.good());
        }
        assert!(heard > 0, "{what}: not heard for a second");
        let heard = (0..20).filter(|_| self.good()).count();
        assert!(heard == 20, "{what}: {heard} of 20 heard");
    }
}

/// A kind of error, made once in a world that is warm.
type Kind = (&'static str, fn(&mut World));

/// Commands that wait somewhere and come together.
fn held_back(world: &mut World) {
    let count = 1 + world.random.below(20);
    let mut held = Vec::new();
    for _ in 0..count {
        held.push(world.stamped(0));
        world.now_ns += MS;
    }
    world.now_ns += world.long();
    for command in held {
        let is_applied = world.arrives(&command);
        assert!(!world.has_limit || !is_applied, "{command:?} was held");
        world.now_ns += world.random.below(MS);
    }
}

/// A link that becomes slow, and lets commands out as they came, for three seconds.
fn slow(world: &mut World) {
    let more_ns = world.long();
    let commands: Vec<_> = (0..300)
        .map(|_| {
            let command = world.stamped(0);
            world.now_ns += H;
            command
        })
        .collect();
    world.now_ns += more_ns.saturating_sub(300 * H);
    // The first is as late as the link is slow, or later, and so are all others.
    for command in commands {
        let sent_ns = (command.t_send_ns.cast_signed() - world.ahead_ns) as u64;
        world.now_ns = world.now_ns.max(sent_ns + more_ns);
        let is_applied = world.arrives(&command);
        assert!(!world.has_limit || !is_applied, "{command:?} was slow");
    }
}

/// A clock that is wrong for a while, by the same for all commands, then right again.
fn wrong_by(world: &mut World, wrong_ns: i64) {
    for _ in 0..1 + world.random.below(40) {
        let command = world.stamped(wrong_ns);
        world.arrives(&command);
        world.now_ns += H;
    }
}

fn ahead(world: &mut World) {
    let some = world.random.below(10 * S);
    let by_ns = world.random.of(&[MS, 20 * MS, 50 * MS, S, 10 * S, some]);
    wrong_by(world, by_ns.cast_signed());
}

fn behind(world: &mut World) {
    let some = world.random.below(10 * S);
    let by_ns = world.random.of(&[MS, 20 * MS, 50 * MS, S, 10 * S, some]);
    wrong_by(world, -(by_ns.cast_signed()));
}

/// A clock that shows something else each time.
fn jumping(world: &mut World) {
    for _ in 0..1 + world.random.below(40) {
        let by_ns = world.random.below(20 * S).cast_signed() - (10 * S).cast_signed();
        let command = world.stamped(by_ns);
        world.arrives(&command);
        world.now_ns += H;
    }
}

/// Commands that were taken come again, at once or later.
fn repeated(world: &mut World) {
    if !world.has_limit {
        // The lease is over after a silence, and numbers begin anew: what tells an old command then is its age.
        world.good();
    }
    let good = world.good.clone();
    for _ in 0..20 {
        let command = world.random.of(&good);
        assert!(!world.arrives(&command), "{command:?} came twice");
        world.now_ns += world.random.below(10 * MS);
    }
}

/// A command that a newer one has overtaken.
fn overtaken(world: &mut World) {
    let late = world.stamped(0);
    assert!(world.good(), "the newer one");
    assert!(!world.arrives(&late), "the older one");
}

/// Commands that never come.
fn lost(world: &mut World) {
    for _ in 0..1 + world.random.below(1000) {
        world.stamped(0);
        world.now_ns += H;
    }
    assert!(world.good(), "the first that comes");
}

const KINDS: [Kind; 8] = [
    ("held", held_back),
    ("slow", slow),
    ("ahead", ahead),
    ("behind", behind),
    ("jumping", jumping),
    ("repeated", repeated),
    ("overtaken", overtaken),
    ("lost", lost),
];

#[test]
fn a_thousand_of_each_kind_under_each_lease_and_age_apply_nothing_old_and_harm_briefly() {
    for (kind, make) in KINDS {
        for lease in [Lease::None, Lease::Address, Lease::Token] {
            for clock in [Clock::Own, Clock::Shared] {
                for max_age_ns in [None, Some(MAX_AGE)] {
                    let settings = PlantSettings {
                        late: Late::Drop,
                        max_age_ns,
                        clock,
                        lease,
                        ..PlantSettings::new(SampleTime::try_new(H).expect("10 ms"))
                    };
                    for seed in 0..EACH {
                        let mut world = World::new(seed, settings);
                        world.warm();
                        make(&mut world);
                        world
                            .recovers(&format!("{kind}, {lease}, {clock}, {max_age_ns:?}, {seed}"));
                    }
                }
            }
        }
        println!(
            "row 17: {kind}, {EACH} times under each lease, clock and limit: none older than the limit applied, none \
             twice, a good clock heard within a second"
        );
    }
}

fn inbox(clock: Clock) -> Inbox {
    let settings = PlantSettings {
        max_age_ns: Some(MAX_AGE),
        clock,
        ..PlantSettings::new(SampleTime::try_new(H).expect("10 ms"))
    };
    Inbox::new(&settings, 1)
}

/// Whether a command is applied that is stamped and arrives at these times.
fn takes(inbox: &mut Inbox, t_send_ns: u64, now_ns: u64) -> bool {
    let request = Request {
        seq: None,
        t_send_ns: Some(t_send_ns),
        u: 1.0.into(),
    };
    let (row, _) = inbox.command(Mode::Closed, &request, Output::default(), now_ns);
    row.outcome == ArrivalOutcome::Applied
}

const REMOTE: IpAddr = IpAddr::V4(std::net::Ipv4Addr::new(10, 0, 0, 1));
const OTHER: IpAddr = IpAddr::V4(std::net::Ipv4Addr::new(10, 0, 0, 2));
const HERE: IpAddr = IpAddr::V4(std::net::Ipv4Addr::LOCALHOST);

/// So that it holds after the plant was started anew, and for whoever comes first.
#[test]
fn by_a_shared_clock_even_the_first_command_is_old_and_the_future_moves_nothing() {
    for mut inbox in [inbox(Clock::Shared), {
        let mut inbox = inbox(Clock::Own);
        inbox.hear(HERE, None);
        inbox
    }] {
        assert!(!takes(&mut inbox, 100 * S, 105 * S), "held for 5 s");
        assert!(!takes(&mut inbox, 120 * S, 110 * S), "stamped 10 s ahead");
        assert!(takes(&mut inbox, 110 * S, 110 * S + MS));
        // For ten seconds all are ahead; the first that is right is heard.
        let mut ahead = (0..1000).map(|n| 111 * S + n * H);
        ahead.by_ref().for_each(|now_ns| {
            takes(&mut inbox, now_ns + 10 * S, now_ns);
        });
        assert!(takes(&mut inbox, 122 * S, 122 * S + MS));
        assert!(!takes(&mut inbox, 122 * S, 122 * S + 51 * MS));
    }
}

#[test]
fn a_clock_that_is_wrong_at_one_address_is_nothing_to_another() {
    let mut inbox = inbox(Clock::Own);
    for n in 0..1000 {
        let now_ns = 100 * S + n * H;
        inbox.hear(OTHER, None);
        takes(&mut inbox, now_ns + 10 * S, now_ns + MS);
        inbox.hear(REMOTE, None);
        assert!(takes(&mut inbox, now_ns, now_ns + MS), "{n}");
        assert!(!takes(&mut inbox, now_ns - S, now_ns + MS), "{n}");
    }
}

#[test]
fn neither_a_silence_nor_another_controller_nor_a_reset_makes_old_commands_young() {
    let forgets: [fn(&mut Inbox); 4] = [
        |_| {},
        Inbox::welcome,
        Inbox::reset,
        |inbox| inbox.hear(REMOTE, Some(100 * S)),
    ];
    for forget in forgets {
        let mut inbox = inbox(Clock::Own);
        inbox.hear(REMOTE, None);
        assert!(takes(&mut inbox, 7 * S, 101 * S));
        for silent_ns in [0, 2 * S, 100 * S] {
            forget(&mut inbox);
            let now_ns = 101 * S + silent_ns;
            let late_ns = 51 * MS + silent_ns / 4000;
            let sent_ns = now_ns + late_ns - 94 * S - late_ns;
            assert!(!takes(&mut inbox, sent_ns, now_ns + late_ns + MS));
            assert!(takes(&mut inbox, sent_ns, now_ns));
        }
    }
}

/// A machine that was started anew counts from 0, and looks older than any command can be. A session shows that it is
/// not, for its token is newer.
#[test]
fn a_clock_that_was_set_back_is_heard_in_a_new_session_and_nothing_older_with_it() {
    let mut inbox = inbox(Clock::Own);
    inbox.hear(REMOTE, None);
    assert!(takes(&mut inbox, 5_000 * S, 7_000 * S));
    assert!(!takes(&mut inbox, 10 * S, 7_010 * S), "it was set back");
    inbox.hear(REMOTE, Some(7_011 * S));
    assert!(takes(&mut inbox, 12 * S, 7_012 * S), "in a session");
    assert!(!takes(&mut inbox, 12 * S, 7_012 * S + 51 * MS), "held");
}

proptest! {
    /// Of two machines, with quartzes as they are, for hours, and whatever the way adds.
    #[test]
    fn a_clock_that_drifts_is_heard_for_ever(ppm in -200..=200_i64, ahead_s in 0..4000_u64, seed: u64) {
        let mut inbox = inbox(Clock::Own);
        inbox.hear(REMOTE, None);
        let mut random = Random(seed);
        for n in 0..7200_u64 {
            let sent_ns = 5_000 * S + n * S;
            let drift_ns = n.cast_signed() * 1_000 * ppm;
            let stamp_ns = (sent_ns + ahead_s * S).cast_signed() + drift_ns;
            let way_ns = 20 * MS + random.below(20 * MS);
            prop_assert!(takes(&mut inbox, stamp_ns as u64, sent_ns + way_ns), "after {n} s");
        }
    }

    /// A controller whose first commands came slowly is heard when its link is quick, within a second.
    #[test]
    fn a_link_that_becomes_quick_is_believed_within_a_second(slow_ms in 100..5000_u64, h_ms in 1..300_u64) {
        let mut inbox = inbox(Clock::Own);
        inbox.hear(REMOTE, None);
        let mut sent_ns = 100 * S;
        for _ in 0..5 {
            prop_assert!(takes(&mut inbox, sent_ns, sent_ns + slow_ms * MS));
            sent_ns += h_ms * MS;
        }
        let quick_ns = sent_ns;
        while !takes(&mut inbox, sent_ns, sent_ns + MS) {
            sent_ns += h_ms * MS;
            prop_assert!(sent_ns - quick_ns < S);
        }
        prop_assert!(!takes(&mut inbox, sent_ns, sent_ns + slow_ms * MS));
    }
}
