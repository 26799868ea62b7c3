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
                loop_verdict: closed.then_some(LoopVerdict::Holds),
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

fn outcomes(comparison: &Comparison, measure: Measure) -> Vec<Conclusion> {
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
            3 => LoopVerdict::Lost,
            _ => LoopVerdict::Holds,
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
    assert_eq!(settling(&|_| 1.0), (Conclusion::Alike, false));
    assert_eq!(settling(&|_| 1.04), (Conclusion::Alike, false));
    assert_eq!(settling(&|_| 1.06), (Conclusion::Worse, true));
    assert_eq!(settling(&|_| 0.9), (Conclusion::Better, false));
    let now_and_then = |repeat: u32| if repeat > 4 { 1.2 } else { 0.8 };
    assert_eq!(settling(&now_and_then), (Conclusion::Unclear, false));
    // More or less by what does not matter is no answer that is open.
    assert_eq!(
        settling(&|repeat| 0.98 + 0.004 * f64::from(repeat)),
        (Conclusion::Alike, false)
    );
    // One stall of the machine does not change a median.
    let once = |repeat: u32| if repeat == 3 { 9.0 } else { 1.0 };
    assert_eq!(settling(&once), (Conclusion::Alike, false));
}

#[test]
fn a_loop_that_never_settled_settles_later_than_any() {
    let a = campaign(1, 10);
    let never = |campaign| {
        changed(campaign, ["couva", "closed"], |_, run| {
            run.settling_ms = None;
            run.loop_verdict = Some(LoopVerdict::Unsettled);
        })
    };
    let worse = Comparison::of(&a, &never(campaign(1, 10)), 0.05);
    assert_eq!(outcomes(&worse, Measure::Settling)[0], Conclusion::Worse);
    assert_eq!(worse.changed[0].repeats, (1..=10).collect::<Vec<_>>());
    let better = Comparison::of(&never(campaign(1, 10)), &a, 0.05);
    assert_eq!(outcomes(&better, Measure::Settling)[0], Conclusion::Better);
    assert!(!better.is_worse());
    let neither = Comparison::of(&never(campaign(1, 10)), &never(campaign(1, 10)), 0.05);
    assert_eq!(outcomes(&neither, Measure::Settling)[0], Conclusion::Alike);
    assert!(neither.changed.is_empty());
}

#[test]
fn a_loop_that_became_unstable_is_worse_without_statistics() {
    let unstable = changed(campaign(1, 1), ["couva", "closed"], |_, run| {
        run.loop_verdict = Some(LoopVerdict::Lost);
    });
    assert!(Comparison::of(&campaign(1, 1), &unstable, 0.05).is_worse());
    assert!(!Comparison::of(&unstable, &campaign(1, 1), 0.05).is_worse());
}

#[test]
fn with_too_few_pairs_it_cannot_be_told_and_how_many_would_tell_is_said() {
    let doubled = |repeats| {
        let b = changed(campaign(1, repeats), ["couva", "closed"], |_, run| {
            run.settling_ms = run.settling_ms.map(|ms| ms * 2.0);
        });
        Comparison::of(&campaign(1, repeats), &b, 0.05)
    };
    let comparison = doubled(5);
    let settling = &comparison.groups[0].measures[0];
    assert_eq!(settling.outcome, Conclusion::TooFew);
    assert!((settling.change.expect("twice") - 1.0).abs() < 1e-9);
    assert_eq!(comparison.answer, Answer::CannotTell);
    // Settling is tested in two groups: 2 x 0.5^6 is 0.031, and 2 x 0.5^5 is 0.062.
    assert_eq!(settling.would_tell, Some(6));
    let text = comparison.to_text("a", "b");
    assert!(text.contains("cannot tell: 6 pairs would"), "{text}");
    let last = "Whether B is worse cannot be told: 0 worse, 0 better and 1 open of 11 measures. 6 pairs of each \
                would tell, if they go like these.\n";
    assert!(text.ends_with(last), "{text}");
    assert_eq!(doubled(6).answer, Answer::Worse);
}

/// The same runs over these topologies, each a group of its own.
fn over(topologies: &[&str], repeats: u32) -> Campaign {
    let mut all = campaign(1, repeats);
    let closed: Vec<Run> = all
        .runs
        .iter()
        .filter(|run| run.summary.topology == "couva" && run.summary.loop_verdict.is_some())
        .cloned()
        .collect();
    all.runs = topologies
        .iter()
        .flat_map(|topology| {
            closed.iter().cloned().map(move |mut run| {
                run.cell.topology = (*topology).to_owned();
                run.summary.topology = (*topology).to_owned();
                run
            })
        })
        .collect();
    all
}

#[test]
fn six_of_six_pairs_that_doubled_are_worse_in_three_groups_and_in_four_seven_pairs_would_tell() {
    let all = ["a", "b", "c", "d"];
    let answer = |topologies: &[&str], repeats| {
        let a = over(topologies, repeats);
        let b = changed(over(topologies, repeats), ["d", "closed"], |_, run| {
            run.settling_ms = run.settling_ms.map(|ms| ms * 2.0);
        });
        let comparison = Comparison::of(&a, &b, 0.05);
        let would = comparison.open().next().and_then(|of| of.would_tell);
        (comparison.answer, would)
    };
    assert_eq!(answer(&all[1..], 6), (Answer::Worse, None));
    assert_eq!(answer(&all, 6), (Answer::CannotTell, Some(7)));
    assert_eq!(answer(&all, 7), (Answer::Worse, None));
}

#[test]
fn a_change_that_is_small_in_the_middle_is_no_answer_if_it_may_be_large() {
    let by = |factors: [f64; 6]| {
        let b = changed(campaign(1, 6), ["couva", "closed"], |repeat, run| {
            run.iae_s = run.iae_s.map(|iae| iae * factors[repeat as usize - 1]);
        });
        let comparison = Comparison::of(&campaign(1, 6), &b, 0.05);
        let iae = comparison.groups[0]
            .measures
            .iter()
            .find(|of| of.measure == Measure::Iae);
        (comparison.answer, iae.map(|of| (of.outcome, of.would_tell)))
    };
    let alike = Some((Conclusion::Alike, None));
    assert_eq!(
        by([1.0, 1.01, 0.99, 1.02, 1.03, 0.98]),
        (Answer::NotWorse, alike)
    );
    // One of six is far off: with so few it may be one of two. Of 11 two may be, by the sign test.
    let open = Some((Conclusion::Unclear, Some(11)));
    assert_eq!(
        by([1.0, 1.01, 0.99, 1.02, 9.0, 0.98]),
        (Answer::CannotTell, open)
    );
    // Far off for the better only: not worse.
    let better = Some((Conclusion::Unclear, None));
    assert_eq!(
        by([1.0, 1.01, 0.99, 1.02, 0.1, 0.98]),
        (Answer::NotWorse, better)
    );
}

#[test]
fn a_median_round_trip_among_messages_without_an_answer_is_later_than_any() {
    let b = changed(campaign(1, 10), ["diego-vpn", "closed"], |_, run| {
        run.messages_answered = Some(400);
        run.messages_timeout = Some(1600);
        run.message_rtt_p50_ms = None;
    });
    let comparison = Comparison::of(&campaign(1, 10), &b, 0.05);
    assert!(outcomes(&comparison, Measure::Rtt).contains(&Conclusion::Worse));
    assert!(comparison.to_text("a", "b").contains("never"));
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
        let turned = |outcome: &Conclusion| match outcome {
            Conclusion::Worse => Conclusion::Better,
            Conclusion::Better => Conclusion::Worse,
            other => *other,
        };
        let back: Vec<Conclusion> = outcomes(&back, Measure::Settling).iter().map(turned).collect();
        prop_assert_eq!(outcomes(&there, Measure::Settling), back);
    }

    #[test]
    fn a_campaign_is_like_itself(seed in 0u64..100, repeats in 1u32..12) {
        let campaign = campaign(seed, repeats);
        let comparison = Comparison::of(&campaign, &campaign, 0.0);
        prop_assert!(!comparison.is_worse() && comparison.lone.is_empty());
        prop_assert!(comparison.changed.is_empty());
        prop_assert_eq!(comparison.count(Conclusion::Worse) + comparison.count(Conclusion::Better), 0);
    }
}
