use super::*;
use crate::compare::tests::{campaign, changed};

#[test]
fn a_tolerance_is_a_share_or_an_amount_whichever_is_more() {
    let rtt = Figure::Rtt50.tolerance();
    assert!(rtt.allows(105.0, 100.0) && !rtt.allows(105.1, 100.0));
    assert!(rtt.allows(0.35, 0.2) && !rtt.allows(0.45, 0.2));
    assert!(rtt.allows(f64::INFINITY, f64::INFINITY) && !rtt.allows(1.0, f64::INFINITY));
}

type Change = fn(&mut Summary, f64);

/// How to multiply each figure by a factor, if it exists.
const CHANGES: [(Figure, Change); 7] = [
    (Figure::Settling, |run, by| scale(&mut run.settling_ms, by)),
    (Figure::Overshoot, |run, by| {
        scale(&mut run.overshoot_pct, by);
    }),
    (Figure::Rtt50, |run, by| {
        scale(&mut run.message_rtt_p50_ms, by);
    }),
    (Figure::Rtt90, |run, by| {
        scale(&mut run.message_rtt_p90_ms, by);
    }),
    (Figure::Rtt99, |run, by| {
        scale(&mut run.message_rtt_p99_ms, by);
    }),
    (Figure::Interval, |run, by| {
        scale(&mut run.control_interval_avg_ms, by);
    }),
    (Figure::IntervalSd, |run, by| {
        scale(&mut run.control_interval_sd_ms, by);
    }),
];

fn scale(figure: &mut Option<f64>, by: f64) {
    *figure = figure.map(|x| x * by);
}

/// Ten runs over a link that stalls every 8.6 s, and ten over one whose delay changes ten times a
/// second, for 6 s each. Figures differ from repeat to repeat.
fn whole() -> Campaign {
    let mut campaign = campaign(1, 10);
    for run in &mut campaign.runs {
        run.cell.duration_ns = 6_000_000_000;
        let of_repeat = 1.0 + 0.001 * f64::from(run.cell.repeat);
        run.summary.overshoot_pct = Some(30.0 * of_repeat);
        run.summary.message_rtt_p90_ms = Some(40.0 * of_repeat);
        run.summary.message_rtt_p99_ms = Some(80.0 * of_repeat);
        run.summary.control_interval_avg_ms = Some(3.0);
        run.summary.control_interval_sd_ms = Some(2.0);
    }
    campaign
}

fn held(agreement: &Agreement, topology: &str, figure: Figure) -> Held {
    let mut groups = agreement.groups.iter();
    let group =
        groups.find(|of| of.kind.topology == topology && of.kind.mode == endpoint::Mode::Closed);
    let figures = group.expect("a group").figures.iter();
    *figures
        .clone()
        .find(|held| held.figure == figure)
        .expect("held")
}

#[test]
fn every_figure_that_is_printed_is_compared() {
    for (figure, change) in CHANGES {
        let b = whole();
        let again = Agreement::of(&b, &b);
        assert_eq!(again.partings().count(), 0);
        assert!(again.to_text().contains(figure.name()));
        let a = changed(whole(), ["diego-vpn", "closed"], |_, run| change(run, 1.3));
        let parted: Vec<Figure> = Agreement::of(&a, &b)
            .partings()
            .map(|(_, held)| held.figure)
            .collect();
        assert_eq!(parted, [figure]);
    }
}

#[test]
fn a_figure_that_one_campaign_lacks_parts() {
    let lacks = changed(whole(), ["diego-vpn", "closed"], |_, run| {
        run.message_rtt_p90_ms = None;
    });
    let agreement = Agreement::of(&lacks, &whole());
    assert!(held(&agreement, "diego-vpn", Figure::Rtt90).parts());
    assert!(agreement.to_text().contains("OFF: only B has it"));
}

/// Of ten runs over the topology, six are ten times as slow in A, and four in B: two pairs differ.
fn slow(topology: &str) -> Agreement {
    let slow = |runs: u32| {
        changed(whole(), [topology, "closed"], |repeat, run| {
            if repeat <= runs {
                scale(&mut run.message_rtt_p90_ms, 10.0);
            }
        })
    };
    Agreement::of(&slow(6), &slow(4))
}

#[test]
fn what_few_draws_spread_is_no_difference_where_most_pairs_agree() {
    let agreement = slow("couva");
    let rtt = held(&agreement, "couva", Figure::Rtt90);
    assert!(rtt.spread && !rtt.agrees && !rtt.parts());
    assert_eq!(agreement.partings().count(), 0);
    let text = agreement.to_text();
    assert!(text.contains("by the law's spread"), "{text}");
    assert!(text.contains("1 of them only in pairs"), "{text}");
    // If most pairs differ, it is a difference over any link.
    let all = changed(whole(), ["couva", "closed"], |_, run| {
        scale(&mut run.message_rtt_p90_ms, 1.3);
    });
    assert!(held(&Agreement::of(&all, &whole()), "couva", Figure::Rtt90).parts());
}

#[test]
fn over_a_link_of_many_draws_medians_are_what_counts() {
    // The link's delay changes sixty times in a run.
    assert!(held(&slow("diego-vpn"), "diego-vpn", Figure::Rtt90).parts());
}
