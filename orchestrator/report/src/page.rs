//! `report.html`: the whole report as one file that needs no network and no other file.
//!
//! Each section is a module that turns values into markup and computes no results: these are in
//! [`answer`](crate::answer), [`claim`](crate::claim), [`table`](crate::table) and
//! [`figure`](crate::figure). Everything can be read without the script, which filters the claims,
//! zooms into figures and switches the colours.

mod again;
mod badge;
mod board;
mod detail;
mod drawing;
mod expected;
mod gap;
mod leaf;
mod machine;
mod matrix;
mod place;
mod profile;
mod ran;
mod scroll;
mod sheet;
mod sweep;
mod trace;

#[cfg(test)]
mod tests;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::answer::Answer;
use crate::report::Report;

pub use sweep::Sweep;

const STYLE: &str = include_str!("page/style.css");
const SCRIPT: &str = include_str!("page/script.js");
const ZOOM: &str = include_str!("page/zoom.js");
/// uPlot 1.6.32, minified, as it is published.
const UPLOT: &str = include_str!("page/uplot/uPlot.iife.min.js");
const UPLOT_STYLE: &str = include_str!("page/uplot/uPlot.min.css");
const UPLOT_LICENCE: &str = include_str!("page/uplot/LICENSE");

/// What the page may load: nothing but what is inside it.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; \
                      img-src data:; base-uri 'none'; form-action 'none'";

/// A section of the page, listed in its contents.
struct Section {
    id: &'static str,
    title: String,
    body: Markup,
}

/// Renders the page of a campaign.
#[must_use]
pub fn render(report: &Report<'_>) -> String {
    let plan = &report.campaign.plan;
    let answer = Answer::of(report.campaign);
    let sections = sections(report);
    let top = html! {
        (matrix::render(&answer, plan))
        (five(report))
    };
    let zooms = report.figures.iter().any(trace::is_zoomable);
    frame(&plan.experiment, &top, &sections, zooms)
}

/// The page around its contents.
fn frame(name: &str, top: &Markup, sections: &[Section], zooms: bool) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (name) ": webloop report" }
                link rel="icon" href="data:,";
                // Ours comes last, since it overrides some of theirs.
                style { @if zooms { (PreEscaped(UPLOT_STYLE)) } (PreEscaped(STYLE)) }
            }
            body {
                a.skip href="#main" { "Skip to the answer" }
                (contents(sections))
                main #main tabindex="-1" {
                    (top)
                    @for section in sections {
                        section id=(section.id) aria-labelledby={ (section.id) "-title" } {
                            h2 id={ (section.id) "-title" } { (section.title) }
                            (section.body)
                        }
                    }
                }
                (footer(zooms))
                script { (PreEscaped(SCRIPT)) }
                @if zooms {
                    script { (PreEscaped(UPLOT)) }
                    script { (PreEscaped(ZOOM)) }
                }
            }
        }
    }
    .into_string()
}

/// The sections, in order, without empty ones.
fn sections(report: &Report<'_>) -> Vec<Section> {
    let simulated = if report.campaign.is_simulated() {
        ", simulated"
    } else {
        ""
    };
    let section = |id, title: &str, body: Option<Markup>| {
        body.map(|body| {
            let title = match id {
                "claims" | "links" | "runs" => format!("{title}{simulated}"),
                // Each table and figure says so itself, and the other sections have no numbers.
                _ => title.to_owned(),
            };
            Section { id, title, body }
        })
    };
    [
        section("expected", "What is expected", expected::render(report)),
        section("gaps", "What is missing", gap::render(report)),
        section("claims", "The paper’s claims", board::render(report)),
        section("tables", "Tables", sheet::render(&report.tables)),
        section("figures", "Figures", drawing::render(&report.figures)),
        section("links", "Links", profile::render(report.campaign)),
        section("runs", "Runs", ran::render(report.campaign)),
        section("machines", "Machines", machine::render(report.campaign)),
        section(
            "again",
            "Run it again",
            Some(again::render(report.campaign)),
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// The five questions with their answers, below the matrix.
fn five(report: &Report<'_>) -> Markup {
    html! {
        @if !report.brief.is_empty() {
            dl.brief {
                @for brief in &report.brief {
                    div {
                        dt { (brief.question) }
                        dd {
                            (brief.answer)
                            @if has(report, brief.shown_in) { " " a href={ "#" (brief.shown_in) } { "See it" } }
                        }
                    }
                }
            }
        }
    }
}

/// Whether the report has a figure or a table of this name.
fn has(report: &Report<'_>, name: &str) -> bool {
    let figures = report.figures.iter().map(|figure| &figure.chart.name);
    let tables = report.tables.iter().map(|table| &table.name);
    figures.chain(tables).any(|of| of == name)
}

fn contents(sections: &[Section]) -> Markup {
    html! {
        nav.contents aria-label="Contents" {
            a.brand href="#main" { "webloop" }
            ul {
                li { a href="#main" { "Answer" } }
                @for section in sections {
                    li { a href={ "#" (section.id) } { (section.title) } }
                }
            }
            button #theme.needs-script type="button" aria-pressed="false" { "Dark colours" }
        }
    }
}

fn footer(zooms: bool) -> Markup {
    html! {
        footer {
            p {
                "Made by webloop " (env!("CARGO_PKG_VERSION"))
                " from the raw rows of this folder. It can be deleted and made again; equal folders \
                 give equal pages."
            }
            @if zooms {
                details {
                    summary { "Licence of uPlot, which draws the zoomed figures" }
                    pre { (UPLOT_LICENCE) }
                }
            }
        }
    }
}
