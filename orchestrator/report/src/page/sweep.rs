//! The page of a sweep: its findings, and its maps, in the frame of a campaign's report.

use chart::Chart;
use maud::{Markup, PreEscaped, html};

use super::drawing::{inline, width};
use super::{Section, Zoom, frame};

/// What the page of a sweep shows.
#[derive(Debug, Clone, Copy)]
pub struct Sweep<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its question.
    pub about: &'a str,
    /// Its seed.
    pub seed: u64,
    /// The findings: tables, if they are not too long, and after an empty line a sentence on each line.
    pub summary: &'a str,
    /// The maps.
    pub maps: &'a [Chart],
}

impl Sweep<'_> {
    /// Renders the page.
    #[must_use]
    pub fn render(&self) -> String {
        // Tables come first, and the sentences after the last empty line.
        let summary = self.summary.trim_end();
        let (tables, sentences) = summary.rsplit_once("\n\n").unwrap_or(("", summary));
        let mut sentences = sentences.lines();
        let top = html! {
            header.answer.quiet {
                p.origin { "webloop sweep " b { (self.name) } " · seed " (self.seed) " · in virtual time" }
                h1 { (sentences.next().unwrap_or("")) }
                @for sentence in sentences { p.lead { (sentence) } }
                p.about { "The sweep: " (self.about) }
            }
        };
        let maps = html! { @for map in self.maps { (drawing(map)) } };
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
        if !self.maps.is_empty() {
            sections.push(section("maps", "Maps", maps));
        }
        if !tables.is_empty() {
            sections.push(section("findings", "Findings", html! { pre { (tables) } }));
        }
        sections.push(section("files", "Files", files));
        frame(self.name, &top, &sections, Zoom::None)
    }
}

fn drawing(map: &Chart) -> Markup {
    let svg = map.draw().to_svg();
    html! {
        figure.drawing id=(map.name) aria-label=(map.title) {
            div.scroll.paper role="region" tabindex="0" aria-label=(map.title) style=[width(&svg)] {
                (PreEscaped(inline(&svg)))
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
