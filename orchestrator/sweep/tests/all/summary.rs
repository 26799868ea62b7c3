//! How a sweep's result is printed and drawn: a table, sentences, figures.

use chart::{Along, Tile};
use plan::ProfileText;
use sim::Timing;
use sweep::{Bench, Cell, Instead, Sweep, borders, findings, maps, summary};

fn profile(name: &str) -> Result<ProfileText, String> {
    let source = link::Profile::builtin(name).ok_or(format!("there is no topology `{name}`"))?;
    Ok(ProfileText {
        source: source.to_owned(),
        ..ProfileText::default()
    })
}

fn run(source: &str) -> (Sweep, Vec<Cell>) {
    let sweep = Sweep::resolve(source, "test.toml", &Instead::default(), profile)
        .unwrap_or_else(|invalid| panic!("{invalid}"));
    let mut bench = Bench::default();
    let rows = (0..sweep.runs()).map(|number| {
        let run = sweep.run(number);
        let point = sweep.grid.point(run.point);
        bench.run(&sweep, run, &point, &Timing::IDEAL)
    });
    let rows: Vec<_> = rows
        .collect::<Result<_, _>>()
        .expect("points that can be run");
    let cells = Cell::all(&sweep, &rows);
    (sweep, cells)
}

const WAITING: &str = "name = 'waiting'\nduration = '30s'\nrepeats = 3\n[axes]\nclient = 'ideal'\n\
    topology = ['arima', 'diego-lan', 'diego-vpn']\nh = '3ms'\n\
    outstanding = ['unlimited', '4', '1']\n";

#[test]
fn waiting_for_each_answer_over_the_vpn_is_found_and_drawn() {
    let (sweep, cells) = run(WAITING);
    let found = findings(&sweep, &cells);
    let first = found.first().expect("a finding");
    assert_eq!(
        (first.level.as_str(), first.at.as_str()),
        ("diego-vpn", "1")
    );
    // Four times becomes far more.
    assert!((3.0..5.0).contains(&first.at_home), "{first}");
    assert!(first.ratio > 5.0 * first.at_home, "{first}");
    insta::assert_snapshot!(summary(&sweep, &cells, &[]));

    let charts = maps(&sweep, &cells, &[]);
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
    let (sweep, cells) = run("name = 'map'\nduration = '10s'\n[axes]\nh = '3ms'\n\
         rtt = { from = '60ms', to = '120ms', steps = 7 }\n\
         kp = { from = 0.1, to = 0.2, steps = 6 }\n");
    let borders = borders(&sweep, &cells);
    insta::assert_snapshot!(summary(&sweep, &cells, &borders));
    let charts = maps(&sweep, &cells, &borders);
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
    let (sweep, cells) = run("name = 'one'\nduration = '1s'\n[axes]\nrtt = '5ms'\n");
    assert!(maps(&sweep, &cells, &[]).is_empty());
    assert!(borders(&sweep, &cells).is_empty());
    assert!(summary(&sweep, &cells, &[]).contains("1 of 1 points"));
}
