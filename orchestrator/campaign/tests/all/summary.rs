//! How a sweep's result is printed and drawn: a table, sentences, figures.

use analysis::sweep::{PointRuns, borders, findings, summary};
use chart::{Along, Tile};
use plan::sweep::Sweep;
use report::sweep::maps;

use crate::lab;

fn run(source: &str) -> (Sweep, Vec<PointRuns>) {
    let sweep = lab::resolve(source);
    let points = PointRuns::all(&sweep, &lab::run_all(&sweep));
    (sweep, points)
}

const WAITING: &str = "name = 'waiting'\n[sweep]\nduration = '30s'\nrepeats = 3\nclient = 'ideal'\n\
    topology = ['arima', 'diego-lan', 'diego-vpn']\nh = '3ms'\n\
    outstanding = ['unlimited', '4', '1']\n";

#[test]
fn waiting_for_each_answer_over_the_vpn_is_found_and_drawn() {
    let (sweep, points) = run(WAITING);
    let found = findings(&sweep, &points);
    let first = found.first().expect("a finding");
    assert_eq!(
        (first.level.as_str(), first.at.as_str()),
        ("diego-vpn", "1")
    );
    // Four times becomes far more.
    assert!((3.0..5.0).contains(&first.at_home), "{first}");
    assert!(first.ratio > 5.0 * first.at_home, "{first}");
    insta::assert_snapshot!(summary(&sweep, &points, &[]));

    let charts = maps(&sweep, &points, &[]);
    let names: Vec<&str> = charts.iter().map(|chart| chart.name.as_str()).collect();
    assert_eq!(names, ["settling", "overshoot", "iae", "cost"]);
    let panel = &charts[0].panels[0];
    let lines: Vec<&str> = panel.series.iter().map(|line| line.name.as_str()).collect();
    assert_eq!(lines, ["arima", "diego-lan", "diego-vpn"]);
    let named = panel.map.as_ref().map(|map| &map.x);
    let levels = ["unlimited", "4", "1"].map(str::to_owned);
    assert_eq!(named, Some(&Along::Names(levels.into())));
    assert!(charts[0].draw().to_svg().contains("unlimited"));
}

#[test]
fn a_map_has_the_computed_limit_between_what_is_stable_and_what_is_not() {
    let (sweep, points) = run("name = 'map'\n[sweep]\nduration = '10s'\nh = '3ms'\n\
         rtt = '7 from 60ms to 120ms'\nkp = '6 from 0.1 to 0.2'\n");
    let borders = borders(&sweep, &points);
    insta::assert_snapshot!(summary(&sweep, &points, &borders));
    let charts = maps(&sweep, &points, &borders);
    let panel = &charts[0].panels[0];
    let map = panel.map.as_ref().expect("a map");
    let (Along::Numbers(rtts), Along::Numbers(kps)) = (&map.x, &map.y) else {
        panic!("two axes of numbers");
    };
    let limit = &panel.series[0].points;
    assert_eq!(limit.len(), kps.len());
    for (row, (limit_ms, kp)) in limit.iter().enumerate() {
        assert_eq!(kp, &kps[row]);
        for (column, rtt_ms) in rtts.iter().enumerate() {
            let is_unstable = map.tiles[row * rtts.len() + column] == Tile::Hatched;
            assert_eq!(is_unstable, rtt_ms > limit_ms, "{rtt_ms} ms, kp = {kp}");
        }
    }
}

#[test]
fn where_nothing_is_varied_there_is_nothing_to_draw() {
    let (sweep, points) = run("name = 'one'\n[sweep]\nduration = '1s'\nrtt = '5ms'\n");
    assert!(maps(&sweep, &points, &[]).is_empty());
    assert!(borders(&sweep, &points).is_empty());
    assert!(summary(&sweep, &points, &[]).contains("1 of 1 points"));
}
