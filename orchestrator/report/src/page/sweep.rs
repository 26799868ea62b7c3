//! The page of a sweep: its findings, and its maps, in the frame of a campaign's report.

use chart::Chart;
use maud::{Markup, PreEscaped, html};
use plan::sweep::Sweep;

use super::drawing::{inline, width};
use super::{Section, Zoom, frame};

/// Renders the page of a sweep, of which each map comes with its SVG. The summary has tables, if they are not too long, and after an empty line a sentence on
/// each line.
pub(crate) fn sweep(sweep: &Sweep, summary: &str, maps: &[(&Chart, String)]) -> String {
    // Tables come first, and the sentences after the last empty line.
    let summary = summary.trim_end();
    let (tables, sentences) = summary.rsplit_once("\n\n").unwrap_or(("", summary));
    let mut sentences = sentences.lines();
    let top = html! {
        header.answer.quiet {
            p.origin { "webloop run " b { (sweep.name) } " · seed " (sweep.seed) " · in virtual time" }
            h1 { (sentences.next().unwrap_or("")) }
            @for sentence in sentences { p.lead { (sentence) } }
            p.about { "The sweep: " (sweep.about) }
        }
    };
    let drawn = html! { @for (map, svg) in maps { (drawing(map, svg)) } };
    let files = html! {
        p {
            code { "points.csv" } " has a row for each run, " code { "findings.txt" } " the words above; where the \
            sweep varies the delay, " code { "margins.csv" } " has the longest stable round trips, beside what \
            analysis says."
        }
    };
    let section = |id, title: &str, body: Markup| Section {
        id,
        title: title.to_owned(),
        body,
    };
    let mut sections = Vec::new();
    if !maps.is_empty() {
        sections.push(section("maps", "Maps", drawn));
    }
    if !tables.is_empty() {
        sections.push(section("findings", "Findings", html! { pre { (tables) } }));
    }
    sections.push(section("files", "Files", files));
    frame(&sweep.name, &top, &sections, Zoom::None)
}

fn drawing(map: &Chart, svg: &str) -> Markup {
    html! {
        figure.drawing id=(map.name) aria-label=(map.title) {
            div.scroll.paper role="region" tabindex="0" aria-label=(map.title) style=[width(svg)] {
                (PreEscaped(inline(svg)))
            }
            figcaption {
                details { summary { "In words" } p { (map.about) } }
                p.files {
                    "As files: "
                    @for (at, ending) in ["svg", "pdf", "csv"].into_iter().enumerate() {
                        @if at > 0 { ", " }
                        a href={ "maps/" (map.name) "." (ending) } { (map.name) "." (ending) }
                    }
                }
            }
        }
    }
}
