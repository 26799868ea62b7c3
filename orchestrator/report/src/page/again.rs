//! How to make the runs and the report again, and how to read the raw rows.

use analysis::Campaign;
use endpoint::{ArrivalRow, MessageRow, SecondRow, TickRow};
use maud::{Markup, html};
use plan::{ProbeRow, file_name};

use super::scroll::scroll;

/// A cell's files of rows: name, what a row is, and its columns.
const ROWS: [(&str, &str, &[&str]); 5] = [
    (
        file_name::TICKS,
        "a tick of the plant, every h",
        TickRow::COLUMNS,
    ),
    (
        file_name::SECOND,
        "the second input and output at a tick, of a plant that has one of them",
        SecondRow::COLUMNS,
    ),
    (
        file_name::ARRIVALS,
        "a command that reached the plant",
        ArrivalRow::COLUMNS,
    ),
    (
        file_name::MESSAGES,
        "a deadline of the controller, and its message",
        MessageRow::COLUMNS,
    ),
    (
        file_name::PROBES,
        "an echo through the link",
        ProbeRow::COLUMNS,
    ),
];

pub(super) fn render(campaign: &Campaign) -> Markup {
    let plan = &campaign.plan;
    // Without it the runs would be real ones.
    let backend = match campaign.is_simulated() {
        true => " --backend sim",
        false => "",
    };
    html! {
        p { "The plan has every setting, profile and seed. In the results folder, one above this report’s, or wherever " code { "plan.json" } " was taken to:" }
        (commands(&[
            &format!("webloop run plan.json{backend} --out again"),
            "webloop report again",
        ]))
        p { "One run, by its id:" }
        (commands(&[&format!("webloop run plan.json --only ID{backend} --out again")]))
        p { "Equal seeds give equal links; what the machine adds is its own. By name, with " code { "--full" } " if it was run so:" }
        (commands(&[&format!("webloop run {} --seed {}{backend} --out again", plan.experiment, plan.seed)]))
        p { "The runs that are not complete once more, and this report again:" }
        (commands(&[&format!("webloop run plan.json{backend} --out . --failed"), "webloop report ."]))
        h3 { "The raw rows" }
        p {
            "Each cell has a folder in " code { "cells/" } " with its rows as CSV: a header, a row a \
             line, times in whole nanoseconds on the run’s monotonic clock, an empty field where \
             there was nothing to record. " code { "summary.csv" } " of " code { "webloop show . --format csv" }
            " has a row for each run."
        }
        (commands(&[
            "import pandas",
            "ticks = pandas.read_csv(\"cells/CELL/ticks.csv\")",
            "ticks.plot(x=\"t_tick_ns\", y=\"y\")",
        ]))
        (scroll("Files of rows", &files()))
    }
}

fn files() -> Markup {
    html! {
        table {
            caption.unseen { "Files of rows" }
            thead {
                tr { th scope="col" { "file" } th scope="col" { "a row is" } th scope="col" { "columns" } }
            }
            tbody {
                @for (name, row, columns) in ROWS {
                    tr {
                        th scope="row" { code { (name) } }
                        td { (row) }
                        td { code { (columns.join(", ")) } }
                    }
                }
            }
        }
    }
}

fn commands(lines: &[&str]) -> Markup {
    html! { pre.commands { (lines.join("\n")) } }
}
