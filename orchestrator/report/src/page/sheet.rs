//! The paper's tables.

use analysis::layout::Column;
use maud::{Markup, html};
use text::significant;

use super::prose::kept;
use super::scroll::scroll;
use crate::table::{Entry, Table};

pub(super) fn render(tables: &[Table]) -> Option<Markup> {
    (!tables.is_empty()).then(|| {
        html! { @for table in tables { (sheet(table)) } }
    })
}

fn sheet(table: &Table) -> Markup {
    html! {
        div.sheet id=(table.name) {
            h3 { (table.title) }
            (scroll(&table.title, &grid(table)))
            @for note in &table.notes { p.note { (kept(note)) } }
            p.files {
                "As a file: "
                a href={ "tables/" (table.name) ".csv" } { (table.name) ".csv" } ", "
                a href={ "tables/" (table.name) ".txt" } { (table.name) ".txt" }
            }
        }
    }
}

fn grid(table: &Table) -> Markup {
    let groups: Vec<&[Column]> = table
        .columns
        .chunk_by(|one, other| one.group == other.group)
        .collect();
    let is_grouped = groups
        .iter()
        .any(|group| group.iter().any(|column| !column.group.is_empty()));
    html! {
        table {
            caption.unseen { (table.title) }
            thead {
                @if is_grouped {
                    tr {
                        @for group in &groups {
                            @let name = group.first().map_or("", |column| column.group);
                            @if name.is_empty() {
                                td colspan=(group.len()) {}
                            } @else {
                                th.group scope="colgroup" colspan=(group.len()) { (name) }
                            }
                        }
                    }
                }
                tr {
                    @for (at, column) in table.columns.iter().enumerate() {
                        th.number[table.is_number(at)] scope="col" { (column.name) }
                    }
                }
            }
            tbody {
                @for row in &table.rows {
                    tr { @for (at, entry) in row.iter().enumerate() { (cell(table, at, entry)) } }
                }
            }
        }
    }
}

fn cell(table: &Table, at: usize, entry: &Entry) -> Markup {
    html! {
        @match entry {
            Entry::Text(text) if at == 0 => { th scope="row" { (text) } }
            Entry::Text(text) => { td { (text) } }
            Entry::Number(x, digits) => { td.number { (significant(*x, *digits)) } }
            Entry::None => { td.none.number[table.is_number(at)] { "–" } }
        }
    }
}
