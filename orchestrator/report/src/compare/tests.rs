use std::path::PathBuf;

use analysis::{LinkFacts, Run, Summary};
use plan::{Instead, Plan, ProfileText, Verdict};
use proptest::prelude::*;

use super::*;

/// Closed loops over two topologies and one open loop over the first, complete and all alike.
pub(crate) fn campaign(seed: u64, repeats: u32) -> Campaign {
    let block = |topologies: &str, mode: &str| {
        format!(
            "[[cells]]\ntopology = [{topologies}]\nclient = [\"native\"]\nmode = \"{mode}\"\n\
             h = [\"3ms\"]\nduration = \"2s\"\nrepeats = {repeats}\n"
        )
    };
    let source = format!(
        "name = \"mine\"\nseed = {seed}\n{}{}",
        block("\"couva\", \"diego-vpn\"", "closed"),
        block("\"couva\"", "open")
    );
    let profile = |name: &str| {
        let source = link::Profile::builtin(name).expect("built in").to_owned();
        Ok(ProfileText {
            source,
            ..ProfileText::default()
        })
    };
    let plan = Plan::resolve(&source, "mine.toml", &Instead::default(), profile);
    let plan = plan.expect("an experiment");
    let runs = plan.cells.iter().map(|cell| {
        let closed = cell.settings.mode == endpoint::Mode::Closed;
        // Repeats differ, as over a real link.
        let of_repeat = 1.0 + 0.01 * f64::from(cell.repeat % 5);
        let known = Summary {
            verdict: Some(Verdict::Complete),
            ..Summary::new(cell, None, LinkFacts::default(), None)
        };
        Run {
            cell: cell.clone(),
            folder: PathBuf::from(&cell.id),
            manifest: None,
            metrics: None,
            recovery: None,
            summary: Summary {
                loop_verdict: closed.then_some(LoopVerdict::Stable),
                settling_ms: closed.then_some(300.0 * of_repeat),
                overshoot_pct: closed.then_some(4.0 * of_repeat),
                iae_s: closed.then_some(0.2 * of_repeat),
                schedule_slope: (!closed).then_some(0.001 * of_repeat),
                sent_share: (!closed).then_some(1.0),
                message_rtt_p50_ms: Some(20.0 * of_repeat),
                ..known
            },
            damage: Vec::new(),
        }
    });
    Campaign {
        folder: PathBuf::from("mine"),
        runs: runs.collect(),
        plan,
    }
}

/// Changes the runs of a topology and mode.
pub(crate) fn changed(
    mut campaign: Campaign,
    of: [&str; 2],
    change: impl Fn(u32, &mut Summary),
) -> Campaign {
    for run in &mut campaign.runs {
        if [run.summary.topology.clone(), run.summary.mode.to_string()] == of {
            change(run.cell.repeat, &mut run.summary);
        }
    }
    campaign
}

fn outcomes(comparison: &Comparison, measure: Measure) -> Vec<Outcome> {
    let measures = comparison.groups.iter().flat_map(|group| &group.measures);
    measures
        .filter(|of| of.measure == measure)
        .map(|of| of.outcome)
        .collect()
}

#[test]
fn a_comparison_reads_like_this() {
    let a = campaign(1, 10);
    let slower = changed(campaign(1, 10), ["diego-vpn", "closed"], |repeat, run| {
        run.settling_ms = run.settling_ms.map(|ms| ms * 1.2).filter(|_| repeat != 3);
        run.loop_verdict = Some(match repeat {
            3 => LoopVerdict::Unstable,
            _ => LoopVerdict::Stable,
        });
    });
    let b = changed(slower, ["couva", "open"], |repeat, run| {
        // Changes that are large enough to matter, in alternating directions.
        let way = if repeat % 2 == 0 { 1.0 } else { -0.4 };
        run.schedule_slope = run.schedule_slope.map(|slope| slope + 0.2 * way);
        run.verdict = Some(match repeat {
            7 => Verdict::Invalid,
            _ => Verdict::Complete,
        });
    });
    let comparison = Comparison::of(&a, &b, 0.05);
    assert!(comparison.is_worse());
    insta::assert_snapshot!("text", comparison.to_text("before", "after"));
    insta::assert_snapshot!("csv", comparison.to_csv());
}

#[test]
fn worse_takes_both_that_it_is_no_chance_and_that_it_matters() {
    let a = campaign(1, 10);
    let settling = |change: &dyn Fn(u32) -> f64| {
        let b = changed(campaign(1, 10), ["couva", "closed"], |repeat, run| {
            run.settling_ms = run.settling_ms.map(|ms| ms * change(repeat));
        });
        let comparison = Comparison::of(&a, &b, 0.05);
        let outcome = outcomes(&comparison, Measure::Settling)[0];
        (outcome, comparison.is_worse())
    };
    assert_eq!(settling(&|_| 1.0), (Outcome::Alike, false));
    assert_eq!(settling(&|_| 1.04), (Outcome::Alike, false));
    assert_eq!(settling(&|_| 1.06), (Outcome::Worse, true));
    assert_eq!(settling(&|_| 0.9), (Outcome::Better, false));
    let now_and_then = |repeat: u32| if repeat > 4 { 1.2 } else { 0.8 };
    assert_eq!(settling(&now_and_then), (Outcome::Unclear, false));
    // One stall of the machine does not change a median.
    let once = |repeat: u32| if repeat == 3 { 9.0 } else { 1.0 };
    assert_eq!(settling(&once), (Outcome::Alike, false));
}

#[test]
fn a_loop_that_never_settled_settles_later_than_any() {
    let a = campaign(1, 10);
    let never = |campaign| {
        changed(campaign, ["couva", "closed"], |_, run| {
            run.settling_ms = None;
            run.loop_verdict = Some(LoopVerdict::NotSettled);
        })
    };
    let worse = Comparison::of(&a, &never(campaign(1, 10)), 0.05);
    assert_eq!(outcomes(&worse, Measure::Settling)[0], Outcome::Worse);
    assert_eq!(worse.changed[0].repeats, (1..=10).collect::<Vec<_>>());
    let better = Comparison::of(&never(campaign(1, 10)), &a, 0.05);
    assert_eq!(outcomes(&better, Measure::Settling)[0], Outcome::Better);
    assert!(!better.is_worse());
    let neither = Comparison::of(&never(campaign(1, 10)), &never(campaign(1, 10)), 0.05);
    assert_eq!(outcomes(&neither, Measure::Settling)[0], Outcome::Alike);
    assert!(neither.changed.is_empty());
}

#[test]
fn a_loop_that_became_unstable_is_worse_without_statistics() {
    let unstable = changed(campaign(1, 1), ["couva", "closed"], |_, run| {
        run.loop_verdict = Some(LoopVerdict::Unstable);
    });
    assert!(Comparison::of(&campaign(1, 1), &unstable, 0.05).is_worse());
    assert!(!Comparison::of(&unstable, &campaign(1, 1), 0.05).is_worse());
}

#[test]
fn fewer_than_six_pairs_are_shown_and_judged_by_nobody() {
    let b = changed(campaign(1, 5), ["couva", "closed"], |_, run| {
        run.settling_ms = run.settling_ms.map(|ms| ms * 9.0);
    });
    let comparison = Comparison::of(&campaign(1, 5), &b, 0.05);
    let settling = &comparison.groups[0].measures[0];
    assert_eq!(settling.outcome, Outcome::TooFew);
    assert!((settling.change.expect("nine times") - 8.0).abs() < 1e-9);
    assert!(
        comparison
            .to_text("a", "b")
            .contains("too few pairs to tell")
    );
    assert!(!comparison.is_worse());
}

#[test]
fn what_cannot_be_compared_is_named_with_the_reason() {
    let a = campaign(1, 6);
    let reasons = |change: &dyn Fn(&mut Campaign)| {
        let mut b = campaign(1, 6);
        change(&mut b);
        let comparison = Comparison::of(&a, &b, 0.05);
        let reasons = comparison.lone.iter();
        reasons
            .map(|lone| format!("{}: {}", lone.kind, lone.reason))
            .collect::<Vec<_>>()
            .join("\n")
    };
    let is_vpn = |run: &Run| run.cell.topology == "diego-vpn";
    let answers = [
        reasons(&|b| *b = campaign(2, 6)),
        reasons(&|b| b.runs.retain(|run| !is_vpn(run))),
        reasons(&|b| {
            let vpn = b.runs.iter_mut().filter(|run| is_vpn(run));
            vpn.for_each(|run| run.cell.duration_ns = 8_000_000_000);
        }),
        reasons(&|b| {
            let vpn = b.runs.iter_mut().filter(|run| is_vpn(run));
            vpn.for_each(|run| run.summary.verdict = Some(Verdict::Failed));
        }),
        reasons(&|b| {
            let vpn = b.plan.profiles.get_mut("diego-vpn").expect("planned");
            vpn.source += "# another\n";
        }),
    ];
    insta::assert_snapshot!("reasons", answers.join("\n\n"));
}

#[test]
fn json_has_the_outcomes_in_words_and_no_infinity() {
    let b = changed(campaign(1, 10), ["couva", "closed"], |_, run| {
        run.settling_ms = None;
    });
    let json = Comparison::of(&campaign(1, 10), &b, 0.05).to_json();
    let value: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let settling = &value["groups"][0]["measures"][0];
    assert_eq!(settling["outcome"], "worse");
    assert_eq!(settling["b"], serde_json::Value::Null);
    assert_eq!(value["groups"][0]["topology"], "couva");
}

proptest! {
    #[test]
    fn what_is_worse_one_way_is_better_the_other(
        factors in prop::collection::vec(0.5f64..2.0, 8..=8),
    ) {
        let a = campaign(1, 8);
        let b = changed(campaign(1, 8), ["couva", "closed"], |repeat, run| {
            run.settling_ms = run.settling_ms.map(|ms| ms * factors[repeat as usize - 1]);
        });
        // 5 % more in one direction are 4.8 % less in the other.
        let (there, back) = (Comparison::of(&a, &b, 0.0), Comparison::of(&b, &a, 0.0));
        let turned = |outcome: &Outcome| match outcome {
            Outcome::Worse => Outcome::Better,
            Outcome::Better => Outcome::Worse,
            other => *other,
        };
        let back: Vec<Outcome> = outcomes(&back, Measure::Settling).iter().map(turned).collect();
        prop_assert_eq!(outcomes(&there, Measure::Settling), back);
    }

    #[test]
    fn a_campaign_is_like_itself(seed in 0u64..100, repeats in 1u32..12) {
        let campaign = campaign(seed, repeats);
        let comparison = Comparison::of(&campaign, &campaign, 0.0);
        prop_assert!(!comparison.is_worse() && comparison.lone.is_empty());
        prop_assert!(comparison.changed.is_empty());
        prop_assert_eq!(comparison.count(Outcome::Worse) + comparison.count(Outcome::Better), 0);
    }
}
