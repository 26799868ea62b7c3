//! Tables and figures of a small results folder whose every row is known.

use std::path::Path;

use analysis::Campaign;
use endpoint::report::{Browser, Confinement, Engine, Sandbox, Version, Visit, Written};
use endpoint::{ArrivalOutcome, ArrivalRow, MessageOutcome, MessageRow, Mode, TickRow};
use plan::{Cell, Client, Phase, ProbeRow, Verdict};
use record::{ControllerReport, Manifest, PlantReport};
use report::{Report, figure, table};

use crate::lab::{Lab, Rows, START_NS, plant, python};

/// A part of the paper's matrix: something of each kind of figure.
const EXPERIMENT: &str = r#"
name = "paper"
about = "A part of the paper's matrix"

[[cells]]
topology = ["arima", "buccoo"]
client = ["python"]
preset = "paper-python"
mode = "open"
h = ["100ms", "10ms"]
duration = "8s"

[[cells]]
topology = ["arima"]
client = ["firefox"]
preset = "paper-2011"
mode = "open"
h = ["10ms"]
duration = "8s"

[[cells]]
topology = ["arima", "diego-vpn"]
client = ["python"]
preset = "paper-python"
mode = "closed"
h = ["3ms"]
duration = "3s"
repeats = 3
"#;

/// A folder in which every cell is complete.
fn complete() -> Lab {
    let lab = Lab::new(EXPERIMENT);
    for cell in &lab.plan.cells {
        write(&lab, cell, Verdict::Complete);
    }
    lab
}

/// How long one interval of this client is at the plant: Firefox of 2011 takes a tenth longer, but
/// never less than 10 ms.
fn period_ns(cell: &Cell) -> u64 {
    let h_ns = cell.settings.h.ns();
    match cell.client {
        Client::Firefox => (h_ns + h_ns / 10).max(10_000_000),
        _ => h_ns,
    }
}

/// A cell as if it had run: messages at their client's period, every hundredth 20 ms late and with
/// the next; a plant that is 5 us late at every other tick; a first-order rise to the reference,
/// four times as slow over the VPN and 10 % slower with each repeat.
fn write(lab: &Lab, cell: &Cell, verdict: Verdict) {
    let (h_ns, closed) = (cell.settings.h.ns(), cell.settings.mode == Mode::Closed);
    let period_ns = period_ns(cell);
    let sent = cell.duration_ns / period_ns;

    let slower = match cell.topology.as_str() {
        "diego-vpn" => 4.0,
        _ => 1.0,
    };
    let tau_s = 0.08 * slower * (1.0 + 0.1 * f64::from(cell.repeat - 1));
    let ticks = (0..cell.duration_ns / h_ns).map(|k| {
        let t_ns = k * h_ns;
        let t_due_ns = START_NS + t_ns;
        TickRow {
            k,
            t_due_ns,
            t_tick_ns: t_due_ns + 5_000 * (k % 2),
            u: 1.0,
            y: 1.0 - (-(t_ns as f64) / 1e9 / tau_s).exp(),
            seq: closed.then_some(k),
            u_applied: None,
        }
    });

    let t_arrive_ns = |k: u64| match k % 100 {
        50 => (k + 1) * period_ns + 1_000_000_000,
        _ => k * period_ns + 1_000_000_000,
    };
    let arrivals = (0..sent).map(|k| ArrivalRow {
        n: k,
        seq: k,
        t_send_ns: Some(k * period_ns),
        t_arrive_ns: t_arrive_ns(k),
        tick: t_arrive_ns(k) / h_ns,
        u: 1.0,
        outcome: if closed {
            ArrivalOutcome::Applied
        } else {
            ArrivalOutcome::Acknowledged
        },
    });

    let messages = (0..sent).map(|k| MessageRow {
        seq: k,
        t_due_ns: k * period_ns,
        t_send_ns: Some(k * period_ns),
        t_receive_ns: Some(k * period_ns + 2_000_000),
        t_arrive_ns: Some(t_arrive_ns(k)),
        r: 1.0,
        y: None,
        e: None,
        u: None,
        tick: None,
        outcome: MessageOutcome::Answered,
        y_seq: None,
    });

    // Round trips of 3.1, 3.3, 3.2 ms and so on where the link had 3, 3.2, 3.1; one of fifty lost.
    let linked = cell.topology != "arima";
    let probes = (0..100).map(|seq| {
        let due_ns = u64::from(linked) * (1_500_000 + 50_000 * u64::from(seq % 3));
        let t_send_ns = u64::from(seq) * 10_000_000;
        ProbeRow {
            phase: Phase::During,
            seq,
            t_send_ns,
            t_reach_ns: None,
            t_back_ns: (seq % 50 != 0).then_some(t_send_ns + 2 * due_ns + 100_000),
            due_up_ns: due_ns,
            due_down_ns: due_ns,
            due_lost: linked && seq % 50 == 0,
        }
    });

    let rows = Rows {
        ticks: ticks.collect(),
        arrivals: arrivals.collect(),
        messages: messages.collect(),
        probes: probes.collect(),
    };
    lab.end_as(cell, &rows, verdict, |manifest| say(manifest, cell, &rows));
}

/// What Table 1 shows of programs, machine and scheduling.
fn say(manifest: &mut Manifest, cell: &Cell, rows: &Rows) {
    manifest.controller = Some(match cell.client {
        Client::Firefox => ControllerReport::Visit(Box::new(visit())),
        _ => ControllerReport::Python(Box::new(python(rows))),
    });
    manifest.plant = Some(PlantReport::Real(Box::new(plant(rows))));
    if cell.topology == "arima" {
        manifest.player = "none".to_owned();
    }
    manifest.machine.processor = "Four, \"quoted\"".to_owned();
    manifest.machine.cores = 4;
    manifest.machine.memory_mib = 8192;
}

fn visit() -> Visit {
    Visit {
        client: Engine::Firefox,
        start_ns: None,
        stop_ns: None,
        interrupted: false,
        rows: Written::default(),
        session: None,
        browser: Browser {
            version: Version {
                name: "Firefox".to_owned(),
                number: "153.7.0esr".to_owned(),
            },
            program: "firefox".into(),
            arguments: Vec::new(),
            sandbox: Sandbox {
                kind: Confinement::Namespace,
                user: 0,
                reason: None,
            },
            opened_ms: None,
        },
    }
}

/// What a figure shows, without its points.
fn outline(figure: &figure::Figure) -> String {
    let chart = &figure.chart;
    let mut out = format!(
        "{} {}\n{}\n{}\n",
        chart.name, chart.title, chart.about, chart.source
    );
    for panel in &chart.panels {
        out += &format!("({}) {}\n", panel.letter, panel.title);
        for series in &panel.series {
            let last = series.points.last().copied().unwrap_or_default();
            out += &format!(
                "    {}: {} points to {:.3}, {:.3}\n",
                series.name,
                series.points.len(),
                last.0,
                last.1
            );
        }
        for guide in &panel.guides {
            out += &format!("    - {}\n", guide.name);
        }
    }
    out
}

#[test]
fn the_tables_read_like_this() {
    let lab = complete();
    let campaign = lab.campaign();
    let tables = paper::table::all(&campaign);
    let texts: Vec<String> = tables.iter().map(table::Table::to_text).collect();
    insta::assert_snapshot!(texts.join("\n"));
}

#[test]
fn the_tables_are_csv_with_a_field_for_each_column() {
    let lab = complete();
    let campaign = lab.campaign();
    for table in paper::table::all(&campaign) {
        let text = table.to_csv();
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        assert_eq!(
            reader.headers().expect("a header").len(),
            table.columns.len()
        );
        let records: Vec<csv::StringRecord> = reader
            .records()
            .collect::<Result<_, _>>()
            .expect("as many fields as the header");
        assert_eq!(records.len(), table.rows.len());
        for (record, row) in records.iter().zip(&table.rows) {
            for (field, entry) in record.iter().zip(row) {
                match entry {
                    table::Entry::Text(words) => assert_eq!(field, words),
                    table::Entry::Number(number, _) => assert_eq!(field.parse(), Ok(*number)),
                    table::Entry::None => assert_eq!(field, ""),
                }
            }
        }
    }
}

#[test]
fn the_figures_show_this() {
    let lab = complete();
    let campaign = lab.campaign();
    let figures = paper::figure::all(&campaign).expect("readable");
    let outlines: Vec<String> = figures.iter().map(outline).collect();
    insta::assert_snapshot!(outlines.join("\n"));
}

#[test]
fn of_what_has_not_been_run_every_panel_says_so() {
    let lab = Lab::new(EXPERIMENT);
    let nothing = lab.campaign();
    let figures = paper::figure::all(&nothing).expect("there is nothing to read");
    let numbers: Vec<&str> = figures.iter().map(|figure| figure.number).collect();
    assert_eq!(numbers, ["2", "3", "4", "5", "6", "7", "8", "9", "T"]);
    for figure in &figures {
        assert!(!figure.chart.panels.is_empty() && figure.runs.is_empty());
        for panel in &figure.chart.panels {
            assert!(
                panel.series.is_empty() && panel.guides.is_empty(),
                "{panel:?}"
            );
            assert_eq!(panel.empty, "not run");
        }
    }
}

#[test]
fn what_is_not_complete_is_not_drawn_and_is_told() {
    let lab = Lab::new(EXPERIMENT);
    for cell in &lab.plan.cells {
        write(&lab, cell, Verdict::Invalid);
    }
    let figures = paper::figure::all(&lab.campaign()).expect("readable");
    for figure in &figures {
        let series = figure.chart.panels.iter().flat_map(|panel| &panel.series);
        assert_eq!(series.count(), 0, "{}", figure.chart.name);
    }
    let source = |figures: &[figure::Figure], name: &str| {
        let figure = figures.iter().find(|figure| figure.chart.name == name);
        figure.expect("one of all").chart.source.clone()
    };
    assert!(source(&figures, "fig-2").starts_with("0 of 1 planned runs;"));

    // Of a step's six repeats one is left out; of Figure 7 one run is enough.
    let closed = |cell: &&Cell| cell.settings.mode == Mode::Closed;
    for cell in lab.plan.cells.iter().filter(closed).skip(1) {
        write(&lab, cell, Verdict::Complete);
    }
    let figures = paper::figure::all(&lab.campaign()).expect("readable");
    assert!(source(&figures, "fig-5").starts_with("5 of 6 planned runs;"));
    assert!(source(&figures, "fig-7").starts_with("1 run;"));
}

#[test]
fn the_same_folder_gives_the_same_bytes_under_the_same_names() {
    let lab = complete();
    let files = |campaign: &Campaign| {
        let report =
            Report::of(campaign, paper::exhibits(campaign).expect("rows")).expect("readable");
        let mut files = report.files(&report.draw());
        files.retain(|(path, _)| path.starts_with("tables") || path.starts_with("figures"));
        files
    };
    let (one, other) = (files(&lab.campaign()), files(&lab.campaign()));
    assert_eq!(one, other);
    // Three tables in two forms, nine figures in three.
    assert_eq!(one.len(), 3 * 2 + 9 * 3);
    for name in ["tables/table-2.txt", "figures/fig-9.svg"] {
        assert!(
            one.iter().any(|(path, _)| path == Path::new(name)),
            "{name}"
        );
    }
}

#[test]
fn a_figure_names_the_runs_that_it_is_of_and_no_other() {
    let lab = complete();
    let campaign = lab.campaign();
    for figure in paper::figure::all(&campaign).expect("readable") {
        for id in &figure.runs {
            assert!(campaign.runs.iter().any(|run| run.cell.id == *id));
        }
        let drawn = figure
            .chart
            .panels
            .iter()
            .any(|panel| !panel.series.is_empty());
        assert_eq!(drawn, !figure.runs.is_empty(), "{}", figure.chart.name);
    }
}
