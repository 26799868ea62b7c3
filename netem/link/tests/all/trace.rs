//! Recorded links: what `ping` sees through them against numpy, where they begin, and what is drawn of a link.
//!
//! The fixtures are made by `tests/fixtures/make.py`.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::fmt::Write as _;

use link::{
    Diagnostic, Drawn, Edition, Link, LinkTime, Pings, Profile, Staircase, Way, describe, predict,
    shares_within, typical,
};
use proptest::prelude::*;

const MS: u64 = 1_000_000;
const CAFE: &str = include_str!("../fixtures/cafe.csv");
const UNEVEN: &str = include_str!("../fixtures/uneven.csv");
const TOLD: &str = include_str!("../fixtures/traces.json");
/// As `webloop margin` looks at a link.
const LOOKS: Pings = Pings {
    count: 200_000,
    interval_ns: 10 * MS,
};

/// An instant of link time.
fn at(ns: u64) -> LinkTime {
    LinkTime::from_ns(ns)
}

fn read(edition: Edition, source: &str) -> (Option<Profile>, Vec<Diagnostic>) {
    let files = |name: &str| match name {
        "cafe.csv" => Ok(CAFE.to_owned()),
        "uneven.csv" => Ok(UNEVEN.to_owned()),
        _ => Err("lost".to_owned()),
    };
    Profile::read_as(edition, source, "p", &files)
}

/// A profile with these keys of both directions.
fn both(keys: &str) -> Profile {
    let source = format!("name = 'p'\nabout = ''\n[both]\n{keys}\n");
    let (profile, findings) = read(Edition::Second, &source);
    profile.unwrap_or_else(|| panic!("{source}\n{findings:?}"))
}

/// A trace of these steps, in ms, with these keys beside them.
fn steps(steps: &[(u64, u64)], keys: &str) -> String {
    let mut text = format!("[both.trace]\n{keys}\n");
    for (t_ms, delay_ms) in steps {
        let _ = writeln!(
            text,
            "[[both.trace.steps]]\nt = '{t_ms}ms'\ndelay = '{delay_ms}ms'"
        );
    }
    format!("name = 'p'\nabout = ''\n{text}")
}

#[test]
fn round_trips_over_a_trace_are_those_that_numpy_finds_over_its_whole_span() {
    let told: serde_json::Value = serde_json::from_str(TOLD).unwrap();
    for (name, of_orders) in told.as_object().unwrap() {
        for due in of_orders.as_array().unwrap() {
            let order = due["order"].as_str().unwrap();
            let profile = both(&format!("order = '{order}'\ntrace.file = '{name}.csv'"));
            let of = |key: &str| due[key].as_f64().unwrap();
            let about = |what: &str, found: f64, due: f64, off: f64| {
                assert!(
                    (found / due - 1.0).abs() < off,
                    "{name} {order} {what}: {found}, not {due}"
                );
            };
            let span_ns = profile.trace_span_ns().unwrap();
            about("span", span_ns as f64 / 1e6, of("span_ms"), 1e-9);
            let expected = predict(&profile, Pings::TABLE_2).expected;
            about("mean", expected.avg_ms, of("mean_ms"), 2e-3);
            let typical = typical(&profile).unwrap();
            about("p50", typical.p50_ms, of("p50_ms"), 3e-3);
            about("p90", typical.p90_ms, of("p90_ms"), 3e-3);
            for limit in due["within"].as_array().unwrap() {
                let limit_ns = (limit[0].as_f64().unwrap() * 1e6) as u64;
                let share = shares_within(&profile, 1, LOOKS, [84, 84], &[limit_ns])[0];
                // What is printed is a tenth of a per cent.
                let off = share - limit[1].as_f64().unwrap();
                assert!(off.abs() < 5e-4, "{name} {order} {limit}: {share}");
            }
        }
    }
}

#[test]
fn pings_over_a_trace_meet_each_part_of_it_as_often() {
    for (span, pings) in [
        ("120s", LOOKS),
        ("120s", Pings::TABLE_2),
        ("97ms", Pings::TABLE_2),
        ("3600s", LOOKS),
    ] {
        let trace = format!(
            "trace = {{ repeat = '{span}', steps = [{{ t = '0s', delay = '1ms' }}, {{ t = '30ms', delay = '2ms' }}] }}"
        );
        let profile = both(&trace);
        let span_ns = profile.trace_span_ns().unwrap();
        let even = pings.evenly_over(&profile);
        assert_eq!(even.count, pings.count);
        assert!(even.interval_ns >= pings.interval_ns);
        let mut tenths = [0_u32; 10];
        for k in 0..u64::from(even.count) {
            tenths[((k * even.interval_ns % span_ns) * 10 / span_ns) as usize] += 1;
        }
        let due = even.count / 10;
        assert!(
            tenths
                .iter()
                .all(|count| count.abs_diff(due) <= 2 + due / 100),
            "{span} {tenths:?}"
        );
    }
    assert_eq!(LOOKS.evenly_over(&Profile::empty()), LOOKS);
}

#[test]
fn each_seed_begins_a_trace_elsewhere_and_all_of_it_alike() {
    let profile = both("order = 'free'\ntrace.file = 'uneven.csv'");
    let first = |seed, way| {
        Link::new(&profile, seed)
            .path_mut(way)
            .state_at(at(0))
            .delay_ns
    };
    let seeds = 4_000;
    let delays: Vec<u64> = (0..seeds).map(|seed| first(seed, Way::Up)).collect();
    let mean_ms = delays.iter().sum::<u64>() as f64 / f64::from(seeds as u32) / 1e6;
    // Half of numpy's mean round trip in free order; the sd of a level is 17 ms, so five standard errors.
    assert!(
        (mean_ms - 60.748_531 / 2.0).abs() < 5.0 * 17.0 / f64::from(seeds as u32).sqrt(),
        "{mean_ms}"
    );
    assert!(delays.iter().collect::<BTreeSet<_>>().len() > 200);
}

#[test]
fn an_explicit_start_and_end_are_played_as_they_are_written() {
    let trace = [(0, 5), (10, 1), (30, 9)];
    let level = |source: &str, t_ms: u64| {
        let (profile, findings) = read(Edition::Second, &format!("{source}\n"));
        let source = profile.unwrap_or_else(|| panic!("{findings:?}"));
        Link::new(&source, 7).up.state_at(at(t_ms * MS)).delay_ns / MS
    };
    let free = |keys: &str| format!("{}[both]\norder = 'free'\n", steps(&trace, keys));
    // The last step lasts as long as the shorter of the two others: the span is 40 ms.
    for (keys, instants) in [
        (
            "start = '0s'",
            [(0, 5), (10, 1), (30, 9), (39, 9), (40, 5), (75, 9)],
        ),
        (
            "start = '10ms'",
            [(0, 1), (20, 9), (29, 9), (30, 5), (40, 1), (65, 9)],
        ),
        (
            "start = '0s'\nrepeat = '100ms'",
            [(0, 5), (10, 1), (30, 9), (99, 9), (100, 5), (130, 9)],
        ),
        (
            "repeat = 'never'",
            [(0, 5), (10, 1), (30, 9), (40, 9), (75, 9), (1000, 9)],
        ),
        (
            "start = '12ms'\nrepeat = 'never'",
            [(0, 1), (17, 1), (18, 9), (40, 9), (75, 9), (1000, 9)],
        ),
    ] {
        for (t_ms, due_ms) in instants {
            assert_eq!(level(&free(keys), t_ms), due_ms, "{keys} at {t_ms}");
        }
    }
}

#[test]
fn the_first_edition_holds_the_last_step_and_begins_with_the_first() {
    let source = steps(&[(0, 5), (10, 1), (30, 9)], "");
    let repeats = steps(&[(0, 5), (10, 1), (30, 9)], "repeat = '40ms'");
    let states = |edition, source: &str, seed| {
        let profile = read(edition, source).0.unwrap();
        let mut link = Link::new(&profile, seed);
        (0..200)
            .map(|t_ms| link.down.state_at(at(t_ms * MS)))
            .collect::<Vec<_>>()
    };
    let (first, second) = (Edition::First, Edition::Second);
    let held = source.replace("[both.trace]\n", "[both.trace]\nrepeat = 'never'\n");
    assert_eq!(states(first, &source, 1), states(second, &held, 9));
    let fixed = repeats.replace("[both.trace]\n", "[both.trace]\nstart = '0s'\n");
    assert_eq!(states(first, &repeats, 1), states(second, &fixed, 9));
    assert_ne!(states(second, &source, 1), states(second, &source, 2));
}

#[test]
fn both_directions_of_one_recording_stay_in_step() {
    let profile = both("order = 'free'\ntrace.file = 'cafe.csv'");
    for seed in 0..50 {
        let mut link = Link::new(&profile, seed);
        for t_ms in (0..300_000).step_by(777) {
            let [up, down] = Way::BOTH.map(|way| link.path_mut(way).state_at(at(t_ms * MS)));
            assert_eq!(up, down, "seed {seed} at {t_ms} ms");
        }
    }
    assert_eq!(profile.drawn(at(u64::MAX)), [Drawn::Start]);
}

#[test]
fn tc_is_told_the_same_trace_from_the_same_instant() {
    let profile = both("trace.file = 'uneven.csv'");
    for seed in [1, 2, 3] {
        for way in Way::BOTH {
            let mut staircase = Staircase::new(&profile, seed, way);
            let mut link = Link::new(&profile, seed);
            while let Some(change) = staircase.next_before(at(40_000 * MS)) {
                let state = link.path_mut(way).state_at(change.at);
                let apart_ns = (u64::from(change.setting.delay_us) * 1000).abs_diff(state.delay_ns);
                assert!(
                    apart_ns <= link::STEP_NS / 2 + 1000,
                    "{apart_ns} ns at {:?}",
                    change.at
                );
            }
        }
    }
}

#[test]
fn a_link_is_described_with_what_is_drawn_of_it_and_no_figure_that_is_not_a_number() {
    let mut told = String::new();
    for (keys, faults) in [
        ("trace.file = 'cafe.csv'", ""),
        ("trace = { file = 'cafe.csv', start = '0s' }", ""),
        ("trace = { file = 'cafe.csv', repeat = 'never' }", ""),
        ("trace.file = 'cafe.csv'\nloss.random.share = '1%'", ""),
        ("delay.base = '5ms'", ""),
        ("delay.base = '5ms'\nloss.random.share = '100%'", ""),
        (
            "delay.base = '5ms'",
            "[[fault]]\nat = '1s'\nfor = '1s'\nevery = '9s'\nloss = '30%'\n",
        ),
        (
            "trace.steps = [{ t = '0s', delay = '5ms', loss = '100%' }]",
            "",
        ),
    ] {
        let source = format!("name = 'p'\nabout = ''\n{faults}[both]\n{keys}\n");
        let text = describe(&read(Edition::Second, &source).0.unwrap());
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        let _ = writeln!(told, "# {keys} {faults}\n{text}");
    }
    insta::assert_snapshot!(told);
}

/// Keys of one direction, and what they draw.
fn laws() -> Vec<(&'static str, &'static [Drawn])> {
    vec![
        ("delay.base = '5ms'", &[]),
        ("delay.base = '5ms'\nrate = '1mbit'", &[]),
        (
            "delay = { base = '5ms', hold = '9ms', spread.constant.value = '1ms' }",
            &[],
        ),
        (
            "delay = { base = '5ms', hold = '9ms', spread.table = [['0%', '1ms'], ['100%', '1ms']] }",
            &[],
        ),
        (
            "delay = { base = '5ms', hold = '9ms', min = '9ms', max = '9ms', spread.exponential.mean = '1ms' }",
            &[],
        ),
        (
            "delay = { base = '5ms', hold = '9ms', spread.exponential.mean = '1ms' }",
            &[Drawn::Delay],
        ),
        (
            "delay = { base = '5ms', hold = '9ms', spread.exponential.mean = '1ms' }\nloss.random.share = '100%'",
            &[],
        ),
        (
            "delay.base = '5ms'\nstall = { every = '900ms', length.constant.value = '20ms' }",
            &[Drawn::Stalls],
        ),
        (
            "delay.base = '5ms'\nstall = { every = '900ms', length.constant.value = '0ms' }",
            &[],
        ),
        ("delay.base = '5ms'\nloss.random.share = '0%'", &[]),
        (
            "delay.base = '5ms'\nloss.random.share = '30%'",
            &[Drawn::Losses],
        ),
        ("delay.base = '5ms'\nloss.random.share = '100%'", &[]),
        (
            "delay.base = '5ms'\nloss.gilbert-elliott = { good = '1s', bad = '1s' }",
            &[Drawn::Losses],
        ),
        (
            "delay.base = '5ms'\nloss.gilbert-elliott = { good = '1s', bad = '1s', in-bad = '0%' }",
            &[],
        ),
        (
            "delay.base = '5ms'\nloss.gilbert-elliott = { good = '1s', bad = '1s', in-good = '100%' }",
            &[],
        ),
        ("trace.file = 'cafe.csv'", &[Drawn::Start]),
        ("trace = { file = 'cafe.csv', start = '3s' }", &[]),
        ("trace = { file = 'cafe.csv', repeat = 'never' }", &[]),
        (
            "trace.steps = [{ t = '0s', delay = '5ms' }, { t = '1s', delay = '5ms' }]",
            &[],
        ),
        (
            "trace.steps = [{ t = '0s', delay = '5ms', loss = '50%' }]",
            &[Drawn::Losses],
        ),
        (
            "trace.steps = [{ t = '0s', delay = '5ms' }, { t = '1s', delay = '6ms', loss = '100%' }]",
            &[Drawn::Start],
        ),
        (
            "trace.steps = [{ t = '0s', delay = '5ms', loss = '100%' }, { t = '1s', delay = '6ms', loss = '100%' }]",
            &[],
        ),
        // Within the 20 s that are looked at there is no step that loses some.
        (
            "trace = { start = '0s', repeat = '100s', steps = [{ t = '0s', delay = '5ms' }, { t = '30s', delay = '6ms', loss = '9%' }] }",
            &[],
        ),
    ]
}

/// Faults, and what they draw over a link that draws nothing.
fn faults() -> Vec<(&'static str, &'static [Drawn])> {
    vec![
        ("at = '1s', for = '1s', down = true", &[]),
        ("at = '1s', for = '1s', period = '2s', delay = '9ms'", &[]),
        (
            "at = '1s', for = '1s', every = '3s', delay = '9ms'",
            &[Drawn::FaultTimes],
        ),
        (
            "at = '1s', for = '1s', every = '3s', times = 1, delay = '9ms'",
            &[],
        ),
        ("at = '1s', for = '1s', every = '1s', delay = '9ms'", &[]),
        ("at = '1s', for = '1s', every = '60s', delay = '9ms'", &[]),
        (
            "at = '1s', for = '1s', loss = '40%'",
            &[Drawn::FaultPackets],
        ),
        ("at = '1s', for = '1s', loss = '100%'", &[]),
        ("at = '50s', for = '1s', loss = '40%'", &[]),
        ("at = '1s', for = '1s', every = '3s', loss = '0%'", &[]),
        ("at = '0s', for = '60s', down = true", &[]),
        (
            "at = '1s', for = '1s', every = '3s', reorder = '50%'",
            &[Drawn::FaultPackets, Drawn::FaultTimes],
        ),
    ]
}

#[test]
fn nothing_is_drawn_exactly_where_all_seeds_give_one_link() {
    let until = at(20_000 * MS);
    let delay = "[both]\ndelay.base = '5ms'\n";
    let of_laws = laws()
        .into_iter()
        .map(|(keys, due)| (format!("[both]\n{keys}\n"), due));
    let of_faults = faults()
        .into_iter()
        .map(|(keys, due)| (format!("fault = [{{ {keys} }}]\n{delay}"), due));
    for (keys, due) in of_laws.chain(of_faults) {
        let source = format!("name = 'p'\nabout = ''\n{keys}");
        let (profile, findings) = read(Edition::Second, &source);
        let profile = profile.unwrap_or_else(|| panic!("{source} {findings:?}"));
        assert_eq!(profile.drawn(until), due, "{keys}");
        assert_eq!(profile.varies_by_seed(until), !due.is_empty());
        let fates = |seed| {
            let mut link = Link::new(&profile, seed);
            let instants = (0..20_000).step_by(3).map(|t_ms| at(t_ms * MS));
            let fates = instants
                .flat_map(|t| Way::BOTH.map(|way| link.path_mut(way).transmit(t, 100).arrives()));
            fates.collect::<Vec<_>>()
        };
        let one = fates(0);
        let is_one = (1..8).all(|seed| fates(seed) == one);
        assert_eq!(is_one, due.is_empty(), "{keys}");
    }
    let arima = Profile::parse(Profile::builtin("arima").unwrap(), "arima").unwrap();
    assert_eq!(arima.drawn(until), []);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// A link over a trace is the trace from some instant on, over and over, and so is its other direction.
    #[test]
    fn a_trace_repeats_over_its_own_span_from_wherever_it_begins(
        gaps in prop::collection::vec((1_u64..90, 1_u64..60), 2..30), seed: u64,
    ) {
        let mut t_ms = 0;
        let trace: Vec<(u64, u64)> = gaps.iter().map(|(gap_ms, delay_ms)| {
            let step = (t_ms, *delay_ms);
            t_ms += gap_ms;
            step
        }).collect();
        let mut lengths: Vec<u64> = trace.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
        lengths.sort_unstable();
        let span_ms = trace[trace.len() - 1].0 + lengths[(lengths.len() - 1) / 2];
        let source = format!("{}[both]\norder = 'free'\n", steps(&trace, ""));
        let profile = read(Edition::Second, &source).0.unwrap();
        prop_assert_eq!(profile.trace_span_ns(), Some(span_ms * MS));
        let mut link = Link::new(&profile, seed);
        let mut level = |t_ms: u64| link.up.state_at(at(t_ms * MS)).delay_ns / MS;
        let played: Vec<u64> = (0..2 * span_ms).map(&mut level).collect();
        let due = |t_ms: u64| trace.iter().rfind(|step| step.0 <= t_ms % span_ms).unwrap().1;
        // Between two whole milliseconds, so one of the whole ones is its place to within one.
        let begins = (0..span_ms).any(|start_ms| {
            let off = |(t_ms, level): (usize, &u64)| {
                let t_ms = start_ms + t_ms as u64;
                *level != due(t_ms) && *level != due(t_ms + 1)
            };
            !played.iter().enumerate().any(off)
        });
        prop_assert!(begins, "{:?}", played);
    }

    /// Order is kept for any trace and any start, whoever asks.
    #[test]
    fn no_packet_overtakes_another_over_a_trace_that_begins_within(
        gaps in prop::collection::vec((1_u64..90, 1_u64..400), 2..20), seed: u64,
    ) {
        let mut t_ms = 0;
        let trace: Vec<(u64, u64)> = gaps.iter().map(|(gap_ms, delay_ms)| {
            let step = (t_ms, *delay_ms);
            t_ms += gap_ms;
            step
        }).collect();
        let profile = read(Edition::Second, &steps(&trace, "")).0.unwrap();
        let mut one = Link::new(&profile, seed);
        let leaves: Vec<u64> = (0..4_000).map(|t_ms| {
            t_ms * MS + one.down.state_at(at(t_ms * MS)).delay_ns
        }).collect();
        prop_assert!(leaves.is_sorted());
        // Asked backwards, which finds each without the one before.
        let mut two = Link::new(&profile, seed);
        for t_ms in (0..4_000).rev().step_by(37) {
            let t_ns = t_ms * MS;
            prop_assert_eq!(t_ns + two.down.state_at(at(t_ns)).delay_ns, leaves[t_ms as usize]);
        }
    }
}
