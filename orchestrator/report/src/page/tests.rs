use std::path::PathBuf;

use analysis::expect::Judgement;
use analysis::layout::number as column;
use analysis::{Campaign, LoopVerdict};
use chart::{Axis, Chart, Guide, GuideAt, Mark, Panel, Scale, Series, Tone};
use record::Damage;

use crate::claim::{Finding, Part, Verdict};
use crate::figure::Figure;
use crate::group::Estimate;
use crate::report::Report;
use crate::sample::{Outcome, campaign};
use crate::table::{Entry, Table};

const CELLS: &str = "
[[cells]]
topology = [\"arima\", \"couva\"]
client = [\"native\", \"firefox\"]
mode = \"closed\"
h = [\"3ms\"]
duration = \"4s\"
repeats = 3
";

fn render(report: &Report<'_>) -> String {
    super::render(report, &report.draw())
}

/// A campaign with every outcome, and a topology whose name would be markup.
fn sample() -> Campaign {
    let mut campaign = campaign(CELLS, |cell| match cell.repeat {
        1 => Outcome::Stable(320.0),
        2 if cell.topology == "couva" => Outcome::Lost(LoopVerdict::Lost),
        2 => Outcome::Failed("it was <i>interrupted</i>"),
        _ => Outcome::Absent,
    });
    for run in &mut campaign.runs {
        if run.cell.topology == "couva" {
            run.cell.topology = "<b>&\"bold\"</b>".to_owned();
        }
    }
    campaign
}

fn report(campaign: &Campaign) -> Report<'_> {
    let ids: Vec<String> = campaign
        .runs
        .iter()
        .map(|run| run.cell.id.clone())
        .collect();
    let ours = Estimate {
        value: 9.8,
        low: 9.4,
        high: f64::INFINITY,
        n: 7,
    };
    let finding = |id, verdict| Finding {
        id,
        place: "Fig 6a",
        claim: "It settles <later>.",
        check: "8 to 12 times".to_owned(),
        reading_of: None,
        verdict,
        reason: "It takes 3.31 s.".to_owned(),
        parts: vec![
            Part::judged(
                "settling",
                "",
                Some(11.0 / 12.0),
                Some(ours),
                (8.0, f64::INFINITY),
            ),
            Part::judged("rise", "ms", None, None, (f64::NEG_INFINITY, 1.0)),
        ],
        runs: ids.clone(),
    };
    Report {
        campaign,
        brief: Vec::new(),
        claims: vec![
            finding("one", Verdict::Agrees),
            finding("two", Verdict::Differs),
            finding("three", Verdict::CannotBeTold),
            finding("four", Verdict::NotRun),
        ],
        tables: vec![table()],
        figures: vec![figure(ids)],
        expectations: Judgement::default(),
        damage: vec![Damage {
            path: PathBuf::from("somewhere/cells/a/ticks.csv"),
            problem: "it is gone".to_owned(),
        }],
    }
}

fn table() -> Table {
    Table {
        name: "table-2".to_owned(),
        title: "Table 2: round trips".to_owned(),
        notes: vec!["A note.".to_owned()],
        columns: vec![column("", "where"), column("the paper", "avg/ms")],
        rows: vec![
            vec![Entry::Text("arima".to_owned()), Entry::Number(104.188, 4)],
            vec![Entry::Text("couva".to_owned()), Entry::None],
        ],
    }
}

fn figure(runs: Vec<String>) -> Figure {
    let axis = |label: &str| Axis {
        label: label.to_owned(),
        scale: Scale::Linear,
        range: None,
        names: Vec::new(),
    };
    Figure {
        number: "3",
        caption: "A caption.".to_owned(),
        paper: Some("A line."),
        chart: Chart {
            tones: &[],
            name: "fig-3".to_owned(),
            title: "A figure".to_owned(),
            about: "It rises.".to_owned(),
            source: "1 run".to_owned(),
            columns: 1,
            panels: vec![Panel {
                letter: "a".to_owned(),
                title: "arima".to_owned(),
                x: axis("time/s"),
                y: axis("y"),
                map: None,
                series: vec![Series {
                    name: "</script>".to_owned(),
                    mark: Mark::Line,
                    tone: Tone::nth(0),
                    points: vec![(0.0, 0.0), (1.0, 1.0)],
                    band: Vec::new(),
                }],
                guides: vec![Guide {
                    name: "the reference".to_owned(),
                    at: GuideAt::Y(1.0),
                }],
                empty: String::new(),
            }],
        },
        runs,
    }
}

#[test]
fn everything_that_there_is_to_say_is_in_the_page() {
    let campaign = sample();
    let page = render(&report(&campaign));
    let cells = campaign.runs.iter().map(|run| run.cell.id.as_str());
    let parts = [
        "claim-one",
        "claim-two",
        "claim-three",
        "claim-four",
        "table-2",
        "fig-3",
    ];
    for name in cells.chain(parts) {
        assert!(page.contains(name), "{name}");
    }
    for words in [
        "cells/a/ticks.csv",
        "it is gone",
        "104.2",
        "9.40 to ∞",
        "at most 1",
    ] {
        assert!(page.contains(words), "{words}");
    }
    let anchors: Vec<&str> = page
        .split("href=\"#")
        .skip(1)
        .filter_map(|rest| rest.split('"').next())
        .collect();
    assert!(anchors.len() > campaign.runs.len());
    for anchor in anchors {
        assert!(
            page.contains(&format!("id=\"{anchor}\"")),
            "#{anchor} leads nowhere"
        );
    }
}

#[test]
fn nothing_in_the_page_is_fetched_from_anywhere() {
    let campaign = sample();
    let page = render(&report(&campaign)).to_lowercase();
    for start in [
        "src=",
        "href=",
        "url(",
        "@import",
        "action=",
        "srcset=",
        "xlink:href=",
    ] {
        for (at, _) in page.match_indices(start) {
            let value = page[at + start.len()..].trim_start_matches(['"', '\'', ' ']);
            let is_far = ["http:", "https:", "//"]
                .iter()
                .any(|far| value.starts_with(far));
            assert!(
                !is_far,
                "{start}{}",
                value.chars().take(60).collect::<String>()
            );
        }
    }
    assert!(page.contains("default-src 'none'"));
}

#[test]
fn text_stays_text() {
    let campaign = sample();
    let page = render(&report(&campaign));
    assert!(page.contains("&lt;b&gt;&amp;&quot;bold&quot;&lt;/b&gt;"));
    assert!(!page.contains("<b>&"));
    assert!(page.contains("it was &lt;i&gt;interrupted&lt;/i&gt;"));
    assert!(page.contains("It settles &lt;later&gt;."));
    assert!(page.contains("\\u003c/script>"), "in the figure's points");
}

#[test]
fn the_page_is_the_same_wherever_the_folder_is_and_whenever_it_is_made() {
    let here = sample();
    let mut there = sample();
    there.folder = PathBuf::from("elsewhere/entirely");
    for run in &mut there.runs {
        run.folder = there.folder.join(run.cell.folder());
    }
    let mut report_there = report(&there);
    report_there.damage[0].path = there.folder.join("cells/a/ticks.csv");
    assert!(render(&report(&here)) == render(&report(&here)));
    assert!(render(&report(&here)) == render(&report_there));
}

#[test]
fn a_campaign_without_anything_has_a_page_all_the_same() {
    let campaign = campaign(CELLS, |_| Outcome::Absent);
    let report = Report {
        campaign: &campaign,
        brief: Vec::new(),
        claims: Vec::new(),
        tables: Vec::new(),
        figures: Vec::new(),
        damage: Vec::new(),
        expectations: Judgement::default(),
    };
    let page = render(&report);
    balanced(&page);
    assert!(page.contains("12 cells that were <span class=\"over\">not run</span>"));
    // Of a page that is served while runs go on, the style sheet shows the other words.
    assert!(page.contains("<span class=\"coming\">still to come</span>"));
    assert!(!page.contains(super::UPLOT), "nothing to zoom into");
}

#[test]
fn elements_end_in_the_order_in_which_they_began_and_ids_are_unique() {
    let campaign = sample();
    let page = render(&report(&campaign));
    balanced(&page);
    let mut ids: Vec<&str> = page
        .split(" id=\"")
        .skip(1)
        .filter_map(|rest| rest.split('"').next())
        .collect();
    let all = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), all, "an id came twice");
}

#[test]
fn headings_descend_by_one_level_at_a_time() {
    let campaign = sample();
    let page = render(&report(&campaign));
    let levels: Vec<u32> = page
        .match_indices("<h")
        .filter_map(|(at, _)| page[at + 2..].chars().next()?.to_digit(10))
        .collect();
    assert_eq!(levels.iter().filter(|level| **level == 1).count(), 1);
    assert_eq!(levels.first(), Some(&1));
    for pair in levels.windows(2) {
        assert!(pair[1] <= pair[0] + 1, "h{} after h{}", pair[1], pair[0]);
    }
}

/// Checks that tags balance. A browser would guess where they do not.
fn balanced(page: &str) {
    const VOID: [&str; 5] = ["meta", "link", "br", "hr", "img"];
    /// Elements whose content is not markup.
    const RAW: [&str; 2] = ["script", "style"];
    let mut open: Vec<String> = Vec::new();
    let mut rest = page;
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        if rest.starts_with('!') {
            continue;
        }
        let end = rest.find('>').expect("a tag ends");
        let tag = &rest[..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(name.trim()));
            continue;
        }
        let name = tag
            .split(|letter: char| letter.is_whitespace() || letter == '/')
            .next()
            .unwrap_or_default()
            .to_owned();
        if tag.ends_with('/') || VOID.contains(&name.as_str()) {
            continue;
        }
        if RAW.contains(&name.as_str()) {
            let end = format!("</{name}>");
            rest = &rest[rest.find(&end).expect("it ends") + end.len()..];
            continue;
        }
        open.push(name);
    }
    assert!(open.is_empty(), "{open:?} never ended");
}
