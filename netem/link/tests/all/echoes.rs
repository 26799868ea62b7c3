//! The certificate on echoes made up: through the right link, a late one, and wrong ones.
//! No socket, no clock.
#![allow(clippy::unwrap_used)]

use link::certificate::{Baseline, Certificate, Echo, Edge, Verdict, certify, certify_within};
use link::{Change, Epoch, LinkTime, Profile, Staircase, Timeline, Way};
use proptest::prelude::*;

const MS: u64 = 1_000_000;
const SECOND: u64 = 1_000 * MS;
/// Any instant will do; a machine has been up for an hour, say.
const EPOCH_NS: u64 = 3_600 * SECOND;
const EPOCH: Epoch = Epoch::at_ns(EPOCH_NS);

fn builtin(name: &str) -> Profile {
    Profile::parse(Profile::builtin(name).unwrap(), name).unwrap()
}

fn profile(path: &str) -> Profile {
    let source = format!("name = \"test\"\nabout = \"a link\"\n{path}");
    Profile::parse(&source, "test").unwrap()
}

/// Echoes as a perfect player would let them cross, each `late_ns` late on each way.
fn cross(
    profile: &Profile,
    seed: u64,
    count: u32,
    interval_ns: u64,
    mut late_ns: impl FnMut(u32) -> u64,
) -> Vec<Echo> {
    let mut timeline = Timeline::new(profile, seed, EPOCH);
    (0..count)
        .map(|seq| {
            let t_send_ns = EPOCH_NS + u64::from(seq) * interval_ns;
            let mut way = |way, t_ns| {
                let state = timeline.state_at(way, t_ns);
                (!state.lost).then_some(t_ns + state.delay_ns + late_ns(seq))
            };
            let t_reach_ns = way(Way::Up, t_send_ns);
            let t_back_ns = t_reach_ns.and_then(|reach| way(Way::Down, reach));
            Echo {
                seq,
                t_send_ns,
                t_reach_ns,
                t_back_ns,
            }
        })
        .collect()
}

fn judge(echoes: &[Echo], profile: &Profile, seed: u64) -> Certificate {
    certify(echoes, profile, seed, EPOCH, Baseline::default())
}

fn judge_tc(echoes: &[Echo], profile: &Profile, seed: u64) -> Certificate {
    let timeline = Timeline::new(profile, seed, EPOCH);
    certify_within(echoes, timeline, Baseline::default(), Edge::TC)
}

/// As wide as an edge gets.
fn judge_late_tc(echoes: &[Echo], profile: &Profile, seed: u64) -> Certificate {
    let timeline = Timeline::new(profile, seed, EPOCH);
    let edge = Edge {
        before_ns: 5 * MS,
        ..Edge::TC
    };
    certify_within(echoes, timeline, Baseline::default(), edge)
}

fn broken(certificate: &Certificate, because: &str) -> bool {
    match &certificate.verdict {
        Verdict::Holds => false,
        Verdict::Broken(reasons) => reasons.iter().any(|reason| reason.contains(because)),
    }
}

#[test]
fn a_perfect_player_has_no_residual_on_any_of_the_papers_links() {
    for name in Profile::BUILTIN {
        let profile = builtin(name);
        let echoes = cross(&profile, 3, 400, 50 * MS, |_| 0);
        let certificate = judge(&echoes, &profile, 3);
        assert_eq!(certificate.verdict, Verdict::Holds, "{name}");
        assert!(certificate.residuals.rtt.max_ms < 1e-9, "{name}");
        let (predicted, measured) = (certificate.predicted, certificate.measured);
        assert!((predicted.avg_ms - measured.avg_ms).abs() < 1e-6, "{name}");
        assert!((predicted.loss - measured.loss).abs() < 1e-9, "{name}");
    }
}

/// A constant cost of 30 us each way is 60 us a round trip: the baseline tells it, and takes
/// all of it off.
#[test]
fn the_baseline_takes_off_what_the_empty_link_costs() {
    let empty = Profile::empty();
    let baseline = Baseline::of(&{
        let mut echoes = cross(&empty, 0, 100, 10 * MS, |_| 30_000);
        // Before the epoch, where the empty link plays.
        for echo in &mut echoes {
            echo.t_send_ns -= 1_800 * SECOND;
            echo.t_reach_ns = echo.t_reach_ns.map(|t| t - 1_800 * SECOND);
            echo.t_back_ns = echo.t_back_ns.map(|t| t - 1_800 * SECOND);
        }
        echoes
    })
    .unwrap();
    assert!((baseline.up_ms - 0.03).abs() < 1e-6 && (baseline.rtt_ms - 0.06).abs() < 1e-6);
    let buccoo = builtin("buccoo");
    let echoes = cross(&buccoo, 3, 400, 10 * MS, |_| 30_000);
    let certificate = certify(&echoes, &buccoo, 3, EPOCH, baseline);
    assert!(certificate.residuals.rtt.median_ms < 0.001);
}

/// The goal: 50 of 50 sabotaged links are found out. Ten seeds against five sabotages of each
/// of the paper's shaped links, with the hundred echoes that a short run has at least.
#[test]
fn sabotaged_links_are_found_out() {
    let nothing = profile("[both.delay]\nbase = \"0.01ms\"\n");
    for name in ["buccoo", "couva", "diego-lan", "diego-vpn"] {
        let asked = builtin(name);
        for seed in 0..10 {
            let played = [
                (
                    "another seed",
                    cross(&asked, seed + 1_000, 100, 100 * MS, |_| 20_000),
                ),
                ("no link", cross(&nothing, seed, 100, 100 * MS, |_| 20_000)),
                ("2 ms more", cross(&asked, seed, 100, 100 * MS, |_| MS)),
                (
                    "dead",
                    Vec::from_iter((0..100).map(|seq| Echo {
                        seq,
                        t_send_ns: EPOCH_NS + u64::from(seq) * 100 * MS,
                        t_reach_ns: None,
                        t_back_ns: None,
                    })),
                ),
                (
                    "late epoch",
                    cross(&asked, seed, 100, 100 * MS, |_| 0)
                        .into_iter()
                        .map(|echo| Echo {
                            t_send_ns: echo.t_send_ns + 3 * SECOND,
                            t_reach_ns: echo.t_reach_ns.map(|t| t + 3 * SECOND),
                            t_back_ns: echo.t_back_ns.map(|t| t + 3 * SECOND),
                            ..echo
                        })
                        .collect(),
                ),
            ];
            for (sabotage, echoes) in played {
                for judge in [judge, judge_tc, judge_late_tc] {
                    let certificate = judge(&echoes, &asked, seed);
                    assert!(
                        certificate.verdict != Verdict::Holds,
                        "{name}, seed {seed}: {sabotage} passes: {certificate:#?}"
                    );
                }
            }
        }
    }
}

/// The goal: at most one false alarm in a hundred. A busy machine, here: each way is late by
/// an exponential time of mean 60 us, and each hundredth by a time slice of 4 ms.
#[test]
fn a_busy_machine_raises_no_false_alarm() {
    for name in ["buccoo", "couva", "diego-lan", "diego-vpn"] {
        let asked = builtin(name);
        for seed in 0..50 {
            let mut state = seed + 1;
            let mut uniform = || {
                // Any generator does: Knuth's, MMIX.
                state = u64::wrapping_mul(state, 6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 53) as f64
            };
            let echoes = cross(&asked, seed, 100, 100 * MS, |_| {
                let slice = if uniform() < 0.01 { 4e6 } else { 0.0 };
                (slice - 60e3 * (1.0 - uniform()).ln()) as u64
            });
            // What the empty link would have shown: the median of the sum of two such times,
            // which is 1.68 means.
            let baseline = Baseline {
                up_ms: 0.042,
                down_ms: 0.042,
                rtt_ms: 0.1,
            };
            let certificate = certify(&echoes, &asked, seed, EPOCH, baseline);
            assert_eq!(
                certificate.verdict,
                Verdict::Holds,
                "{name}, seed {seed}: {certificate:#?}"
            );
        }
    }
}

/// A host that takes the processor between an echo's stamp and its sending: it meets a later state of the link, with
/// less delay or without loss, and is no evidence of another one. Nor is a baseline that was measured meanwhile.
#[test]
fn what_is_stamped_and_then_held_is_no_evidence_of_another_link() {
    let jumpy = profile(
        "[both]\norder = \"free\"\n[both.delay]\nbase = \"1ms\"\nhold = \"3ms\"\n\
         spread.table = [[\"0%\", \"0ms\"], [\"100%\", \"20ms\"]]\n\
         [both.loss.random]\nshare = \"20%\"\n",
    );
    let mut links: Vec<Profile> = ["buccoo", "couva", "diego-lan", "diego-vpn"]
        .map(builtin)
        .into();
    links.push(jumpy);
    let baseline = Baseline {
        up_ms: 3.0,
        down_ms: 3.0,
        rtt_ms: 6.0,
    };
    for (asked, seed) in links
        .iter()
        .flat_map(|link| (0..20).map(move |seed| (link, seed)))
    {
        let mut entered = cross(asked, seed, 300, 100 * MS + 130_000, |_| 0);
        for echo in &mut entered {
            echo.t_send_ns -= u64::from(echo.seq) * 7_919_377 % (30 * MS);
        }
        for baseline in [Baseline::default(), baseline] {
            let certificate = certify(&entered, asked, seed, EPOCH, baseline);
            assert!(
                !certificate.is_another(),
                "{}: {certificate:#?}",
                asked.name()
            );
        }
    }
}

/// All other echoes are then sooner than they would be at its cost.
#[test]
fn a_baseline_of_a_busy_moment_is_no_evidence_of_another_link() {
    let baseline = Baseline {
        up_ms: 0.6,
        down_ms: 0.6,
        rtt_ms: 1.2,
    };
    for name in ["buccoo", "couva", "diego-lan", "diego-vpn"] {
        for seed in 0..20 {
            let echoes = cross(&builtin(name), seed, 120, 100 * MS, |_| 35_000);
            let certificate = certify(&echoes, &builtin(name), seed, EPOCH, baseline);
            let held = &certificate.verdict;
            assert_eq!(*held, Verdict::Holds, "{name}: {certificate:#?}");
        }
    }
}

#[test]
fn an_echo_that_should_be_lost_and_is_not_breaks_the_certificate() {
    let lossy = profile("[both.delay]\nbase = \"5ms\"\n[both.loss.random]\nshare = \"5%\"\n");
    let lossless = profile("[both.delay]\nbase = \"5ms\"\n");
    let came = judge(&cross(&lossless, 1, 200, 10 * MS, |_| 0), &lossy, 1);
    assert!(
        broken(&came, "when it should have lost them"),
        "{:?}",
        came.verdict
    );
    let lost = judge(&cross(&lossy, 1, 200, 10 * MS, |_| 0), &lossless, 1);
    assert!(
        broken(&lost, "when the link should have carried them"),
        "{:?}",
        lost.verdict
    );
}

#[test]
fn too_few_answers_are_no_proof() {
    let constant = profile("[both.delay]\nbase = \"5ms\"\n");
    let certificate = judge(&cross(&constant, 1, 10, 10 * MS, |_| 0), &constant, 1);
    assert!(broken(&certificate, "only 10 of 10"));
    assert!(broken(&judge(&[], &constant, 1), "only 0 of 0"));
}

/// With a rate limit other traffic may hold the queue; a probe may be later than its least
/// delay, or dropped by a full queue, but not earlier.
#[test]
fn behind_a_rate_limit_only_earliness_is_judged() {
    let narrow = profile("[both]\nrate = \"1mbit\"\n[both.delay]\nbase = \"5ms\"\n");
    // 84 bytes at 1 Mbit/s take 0.672 ms, which the probe itself adds.
    let transmission_ns = 672_000;
    let mut queued = cross(&narrow, 1, 100, 10 * MS, |seq| {
        transmission_ns + u64::from(seq % 7) * 20 * MS
    });
    queued[50].t_back_ns = None;
    let certificate = judge(&queued, &narrow, 1);
    assert!(!certificate.exact);
    assert_eq!(certificate.verdict, Verdict::Holds);
    let early = judge(&cross(&narrow, 1, 100, 10 * MS, |_| 0), &narrow, 1);
    assert!(
        broken(&early, "from their prediction"),
        "{:?}",
        early.verdict
    );
}

/// Where it is known what entered, the queue is too: echoes between bursts of other packets are judged
/// one by one, and those through another rate are found out.
#[test]
fn behind_a_rate_limit_the_queue_is_known_where_it_is_known_what_entered() {
    let narrow = |rate: &str| {
        profile(&format!(
            "[both]\nrate = \"{rate}\"\n[both.delay]\nbase = \"5ms\"\n"
        ))
    };
    // Every 10 ms an echo, and before every third one a burst that takes 8 ms at 1 Mbit/s.
    let mut packets = Vec::new();
    for seq in 0..200 {
        let t_ns = EPOCH_NS + seq * 10 * MS;
        if seq % 3 == 0 {
            packets.push((t_ns, 1_000));
        }
        packets.push((t_ns + 100_000, 84));
    }
    let through = |rate: &str| {
        let mut link = Timeline::new(&narrow(rate), 1, EPOCH);
        let mut echoes = Vec::new();
        for &(t_ns, bytes) in &packets {
            let link::Fate::Deliver { at: at_ns, .. } = link.transmit(Way::Up, t_ns, bytes) else {
                panic!("the queue has room");
            };
            if bytes == 84 {
                echoes.push(Echo {
                    seq: echoes.len() as u32,
                    t_send_ns: t_ns,
                    t_reach_ns: Some(at_ns),
                    t_back_ns: Some(at_ns + 5_672_000),
                });
            }
        }
        echoes
    };
    let judge = |echoes: &[Echo]| {
        let back = echoes
            .iter()
            .filter_map(|echo| Some((echo.t_reach_ns?, 84)));
        let timeline = Timeline::new(&narrow("1mbit"), 1, EPOCH)
            .with_load(Way::Up, packets.iter().copied())
            .with_load(Way::Down, back);
        certify_within(echoes, timeline, Baseline::default(), Edge::USER)
    };
    let right = judge(&through("1mbit"));
    assert!(right.exact);
    assert_eq!(right.verdict, Verdict::Holds);
    assert!(right.residuals.rtt.max_ms < 0.001, "{:?}", right.residuals);
    assert!(right.measured.max_ms > 15.0, "{:?}", right.measured);
    let other = judge(&through("700kbit"));
    assert!(broken(&other, "from"), "{:?}", other.verdict);
}

/// Echoes as tc would let them cross: by the setting in force, which comes late by up to half
/// a millisecond, and whose fall is a staircase. No packet leaves before the one ahead of it.
fn cross_tc(profile: &Profile, seed: u64, count: u32, interval_ns: u64) -> Vec<Echo> {
    let mut ways = [Way::Up, Way::Down].map(|way| {
        let mut staircase = Staircase::new(profile, seed, way);
        let mut next = staircase.next_before(LinkTime::ZERO.after(1));
        let (mut in_force, mut last_ns) = (None, 0);
        move |t_ns: u64| {
            let now = EPOCH.link_time(t_ns).unwrap();
            let late_ns = |change: &Change| change.at.ns() * 7 % 500_000;
            while let Some(change) = next
                && (change.at == LinkTime::ZERO || change.at.after(late_ns(&change)) <= now)
            {
                in_force = Some(change.setting);
                next = staircase.next_before(now.after(SECOND));
            }
            let setting = in_force.unwrap();
            last_ns = (t_ns + u64::from(setting.delay_us) * 1_000).max(last_ns);
            (!setting.lost).then_some(last_ns)
        }
    });
    (0..count)
        .map(|seq| {
            let t_send_ns = EPOCH_NS + u64::from(seq) * interval_ns;
            let t_reach_ns = ways[0](t_send_ns);
            Echo {
                seq,
                t_send_ns,
                t_reach_ns,
                t_back_ns: t_reach_ns.and_then(&mut ways[1]),
            }
        })
        .collect()
}

#[test]
fn tc_s_steps_and_lateness_raise_no_alarm() {
    for name in ["buccoo", "couva", "diego-lan", "diego-vpn"] {
        let asked = builtin(name);
        for seed in 0..50 {
            let echoes = cross_tc(&asked, seed, 600, 10 * MS);
            let certificate = judge_tc(&echoes, &asked, seed);
            assert_eq!(
                certificate.verdict,
                Verdict::Holds,
                "{name}, seed {seed}: {certificate:#?}"
            );
        }
    }
}

/// Loss by the millisecond cannot be told echo by echo when the edges of each are a
/// millisecond wide. That it is missing, or there for nothing, shows in the sum.
#[test]
fn loss_that_tc_does_not_play_is_found_out_in_the_sum() {
    let lossy = profile("[both.delay]\nbase = \"5ms\"\n[both.loss.random]\nshare = \"2%\"\n");
    let lossless = profile("[both.delay]\nbase = \"5ms\"\n");
    for seed in 0..10 {
        let came = judge_tc(&cross_tc(&lossless, seed, 600, 10 * MS), &lossy, seed);
        assert!(broken(&came, "should have lost"), "{:?}", came.verdict);
        let lost = judge_tc(&cross_tc(&lossy, seed, 600, 10 * MS), &lossless, seed);
        assert!(
            broken(&lost, "when the link should have carried them"),
            "{:?}",
            lost.verdict
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever times an echo has, judging it neither panics nor leaves a number that is
    /// none.
    #[test]
    fn any_echoes_can_be_judged(
        times in prop::collection::vec((0..20 * SECOND, prop::option::of(0..20 * SECOND), prop::option::of(0..20 * SECOND)), 0..60),
    ) {
        let echoes: Vec<Echo> = times
            .into_iter()
            .zip(0..)
            .map(|((send, reach, back), seq)| Echo {
                seq,
                t_send_ns: EPOCH_NS + send,
                t_reach_ns: reach.map(|t| EPOCH_NS + t),
                t_back_ns: back.map(|t| EPOCH_NS + t),
            })
            .collect();
        let certificate = judge(&echoes, &builtin("couva"), 5);
        let text = serde_json::to_string(&certificate).unwrap();
        prop_assert!(!text.contains("null"), "{}", text);
    }
}
