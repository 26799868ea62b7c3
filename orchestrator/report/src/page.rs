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
mod prose;
mod ran;
mod scroll;
mod sheet;
mod sweep;
mod trace;

#[cfg(test)]
mod tests;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::answer::Answer;
use crate::figure::LaidOut;
use crate::report::Report;

pub(crate) use sweep::sweep;

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

/// Renders the page of a campaign; `drawn` are the report's figures.
#[must_use]
pub fn render(report: &Report<'_>, drawn: &[LaidOut<'_>]) -> String {
    let plan = &report.campaign.plan;
    let answer = Answer::of(report.campaign);
    let sections = sections(report, drawn);
    let top = html! {
        (matrix::headline(&answer, plan))
        @if let Some(picture) = picture(drawn) { (drawing::top(picture)) }
        (matrix::render(&answer, plan))
        (questions(report))
    };
    let zoom = if report.figures.iter().any(trace::is_zoomable) {
        Zoom::Some
    } else {
        Zoom::None
    };
    frame(&plan.experiment, &top, &sections, zoom)
}

/// The picture under the answer: the step responses, where there are any.
fn picture<'a>(drawn: &'a [LaidOut<'a>]) -> Option<&'a LaidOut<'a>> {
    drawn.iter().find(|drawn| drawn.figure.number == "A")
}

/// Whether a page has figures that are zoomed, and so what does it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Zoom {
    Some,
    None,
}

/// The page around its contents.
fn frame(name: &str, top: &Markup, sections: &[Section], zoom: Zoom) -> String {
    let page = html! {
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
                style { @if zoom == Zoom::Some { (PreEscaped(UPLOT_STYLE)) } (PreEscaped(STYLE)) }
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
                (footer(zoom))
                script { (PreEscaped(SCRIPT)) }
                @if zoom == Zoom::Some {
                    script { (PreEscaped(UPLOT)) }
                    script { (PreEscaped(ZOOM)) }
                }
            }
        }
    }
    .into_string();
    // What names and reasons would do on a terminal, and to a reader's eye.
    text::plain(&page).into_owned()
}

/// The sections, in order, without empty ones.
fn sections(report: &Report<'_>, drawn: &[LaidOut<'_>]) -> Vec<Section> {
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
        section("figures", "Figures", drawing::render(drawn, picture(drawn))),
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

/// The questions with their answers, below the matrix.
fn questions(report: &Report<'_>) -> Markup {
    html! {
        @if !report.brief.is_empty() {
            dl.brief {
                @for brief in &report.brief {
                    div {
                        dt { (brief.question) }
                        dd {
                            (prose::coded(&brief.answer))
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
    // Two sections are always there.
    let mut names = figures.chain(tables).map(String::as_str);
    names.any(|of| of == name) || ["links", "again"].contains(&name)
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

fn footer(zoom: Zoom) -> Markup {
    html! {
        footer {
            p {
                "Made by webloop " (env!("CARGO_PKG_VERSION"))
                " from the raw rows of this folder. It can be deleted and made again; equal folders \
                 give equal pages."
            }
            @if zoom == Zoom::Some {
                details {
                    summary { "Licence of uPlot, which draws the zoomed figures" }
                    pre { (UPLOT_LICENCE) }
                }
            }
        }
    }
}
