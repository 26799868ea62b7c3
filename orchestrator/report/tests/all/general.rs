//! What a report shows is chosen by what varies in the experiment; nothing in it is empty.

use report::figure::Figure;
use report::{Exhibits, Report};

use crate::lab::{Lab, Rows};

/// Two clients and two systems, two repeats of which the second settles later.
fn own() -> Lab {
    let lab = Lab::new(
        "name = \"own\"\n[[cells]]\ntopology = [\"arima\", \"couva\"]\nclient = [\"native\", \"python\"]\n\
         preset = \"paper-python\"\nsystem = [\"motor\", \"lag\"]\nmode = \"closed\"\nh = [\"10ms\"]\n\
         duration = \"3s\"\nrepeats = 2\n",
    );
    for cell in &lab.plan.cells {
        let settling_ms = 300.0 + 100.0 * f64::from(cell.repeat);
        lab.run(cell, &Rows::step(cell, settling_ms));
    }
    lab
}

/// What a figure shows, without its points.
fn outline(figure: &Figure) -> String {
    let chart = &figure.chart;
    let mut out = format!("{} {}\n{}\n", chart.name, chart.title, chart.about);
    for panel in &chart.panels {
        let series = panel.series.iter().map(|series| series.name.as_str());
        let series: Vec<&str> = series.collect();
        out += &format!("  {} [{}]\n", panel.title, series.join(", "));
    }
    out
}

#[test]
fn the_figures_show_this() {
    let lab = own();
    let campaign = lab.campaign();
    let report = Report::of(&campaign, Exhibits::default()).expect("readable");
    let outlines: Vec<String> = report.figures.iter().map(outline).collect();
    insta::assert_snapshot!(outlines.join("\n"));
}

#[test]
fn the_tables_read_like_this() {
    let lab = own();
    let campaign = lab.campaign();
    let report = Report::of(&campaign, Exhibits::default()).expect("readable");
    let tables: Vec<String> = report
        .tables
        .iter()
        .map(report::table::Table::to_text)
        .collect();
    insta::assert_snapshot!(tables.join("\n"));
}

#[test]
fn the_questions_are_answered_from_the_runs() {
    let lab = own();
    let campaign = lab.campaign();
    let report = Report::of(&campaign, Exhibits::default()).expect("readable");
    let brief = report.brief.iter();
    let brief: Vec<String> = brief
        .map(|one| format!("{}\n  {}", one.question, one.answer))
        .collect();
    insta::assert_snapshot!(brief.join("\n"));
}

#[test]
fn no_panel_is_empty_whatever_was_run() {
    let of_nothing = Lab::new(
        "name = \"own\"\n[[cells]]\ntopology = [\"couva\"]\nclient = [\"native\"]\nmode = \"open\"\n\
         h = [\"10ms\"]\nduration = \"3s\"\n",
    );
    for lab in [own(), of_nothing] {
        let campaign = lab.campaign();
        let report = Report::of(&campaign, Exhibits::default()).expect("readable");
        for figure in &report.figures {
            assert!(!figure.chart.panels.is_empty(), "{}", figure.chart.title);
            for panel in &figure.chart.panels {
                let drawn = panel.series.iter().any(|series| !series.points.is_empty());
                assert!(drawn, "{}: {}", figure.chart.title, panel.title);
            }
        }
        for table in &report.tables {
            assert!(!table.rows.is_empty(), "{}", table.title);
        }
    }
}
