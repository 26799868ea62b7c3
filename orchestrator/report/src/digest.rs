//! `summary.md`: the report on a screen or two of Markdown, for a CI job's page or a pull request.
//!
//! It has the answer, what differs from the paper, and what is wrong or missing; the rest is in the
//! report. It stays short, however large the campaign.

use std::collections::BTreeMap;

use analysis::{LoopVerdict, Run};

use crate::answer::Answer;
use crate::brief;
use crate::claim::Verdict;
use crate::outcome::{self, CellOutcome, OutcomeKind};
use crate::report::Report;

/// The most lines of one list.
const MOST_LINES: usize = 25;
/// The most characters of a reason.
const MOST_CHARACTERS: usize = 600;

/// The text of `summary.md`.
#[must_use]
pub fn markdown(report: &Report<'_>) -> String {
    let outcomes: Vec<(&Run, CellOutcome)> = report
        .campaign
        .runs
        .iter()
        .map(|run| (run, CellOutcome::of(report.campaign, run)))
        .collect();
    let sections = [
        format!("# webloop: {}\n", text(&report.campaign.plan.experiment)),
        answer(report),
        expectations(report),
        answers(report),
        totals(report, &outcomes),
        claims(report),
        faults(&outcomes),
        missing(report, &outcomes),
        "More is in `report.html` beside this file. `webloop show DIR` prints the table of all \
         cells.\n"
            .to_owned(),
    ];
    let filled = sections.into_iter().filter(|section| !section.is_empty());
    filled.collect::<Vec<_>>().join("\n")
}

/// Whether the loop survives, in a few sentences.
fn answer(report: &Report<'_>) -> String {
    let words = Answer::of(report.campaign).words();
    let sentences: Vec<String> = words.iter().map(|sentence| text(sentence)).collect();
    sentences.join(" ") + "\n"
}

/// The other four questions; the answer to the first stands above.
fn answers(report: &Report<'_>) -> String {
    let others = report.brief.iter();
    let lines = others.filter(|brief| brief.question != brief::HOLDS);
    lines
        .map(|brief| format!("- **{}** {}\n", brief.question, text(&brief.answer)))
        .collect()
}

/// What became of what is expected; empty if nothing is.
fn expectations(report: &Report<'_>) -> String {
    let judgement = &report.expectations;
    if judgement.is_empty() {
        return String::new();
    }
    let answers = judgement.answers.iter().map(|answer| {
        let (group, clause) = (text(&answer.group), text(&answer.clause));
        let outcome = answer.outcome.word().to_owned();
        vec![outcome, group, clause, text(&answer.details())]
    });
    let unasked = judgement.unasked.iter().map(|clause| {
        let why = "no run here has it".to_owned();
        vec![
            "NOT MET".to_owned(),
            String::new(),
            text(&clause.to_string()),
            why,
        ]
    });
    // What fails comes first, since a long table is cut.
    let mut rows: Vec<Vec<String>> = unasked.chain(answers).collect();
    rows.sort_by_key(|row| !row[0].starts_with("NOT"));
    let passing = judgement.passing.iter().map(|known| {
        let cells = text(&known.cells);
        format!("\nThe known failure of {cells} passes: remove it from \\[\\[known\\]\\].\n")
    });
    let head = ["", "runs", "expected", "found"].map(str::to_owned);
    heading("What is expected") + &table(&head, &rows) + &passing.collect::<String>()
}

/// How cells and loops of each topology ended.
fn totals(report: &Report<'_>, outcomes: &[(&Run, CellOutcome)]) -> String {
    let of_topology = |topology: &str| {
        let of_it = || {
            outcomes
                .iter()
                .filter(|(run, _)| run.cell.topology == topology)
        };
        let cells = OutcomeKind::ALL.map(|kind| of_it().filter(|(_, it)| it.kind == kind).count());
        let complete = || of_it().filter(|(_, it)| it.kind == OutcomeKind::Complete);
        let judged =
            |verdict| complete().filter(move |(run, _)| run.summary.loop_verdict == verdict);
        let loops = LoopVerdict::ALL.map(|verdict| judged(Some(verdict)).count());
        let counts = cells.into_iter().chain(loops).map(|n| n.to_string());
        [text(topology)].into_iter().chain(counts).collect()
    };
    let mut head = vec!["topology".to_owned()];
    head.extend(OutcomeKind::ALL.map(|kind| kind.word().to_owned()));
    head.extend(LoopVerdict::ALL.map(|verdict| format!("loop {verdict}")));
    let rows: Vec<Vec<String>> = outcome::topologies(report.campaign)
        .into_iter()
        .map(of_topology)
        .collect();
    heading("Cells and loops") + &table(&head, &rows)
}

/// How many claims agree, and those that do not.
fn claims(report: &Report<'_>) -> String {
    if report.claims.is_empty() {
        return String::new();
    }
    let mut counts: BTreeMap<Verdict, usize> = BTreeMap::new();
    for finding in report.strict() {
        *counts.entry(finding.verdict).or_default() += 1;
    }
    let counts: Vec<String> = counts
        .into_iter()
        .map(|(verdict, n)| format!("{n} {}", outcome::answered(verdict)))
        .collect();
    let head = ["where", "claim", "verdict", "why"].map(str::to_owned);
    let differ = |verdict| verdict != Verdict::Agrees;
    let rows: Vec<Vec<String>> = report
        .strict()
        .filter(|finding| differ(finding.verdict))
        .map(|finding| {
            let verdict = outcome::answered(finding.verdict).to_owned();
            let (place, claim) = (text(finding.place), text(finding.claim));
            vec![place, claim, verdict, text(&finding.reason)]
        })
        .collect();
    let counts = counts.join(", ");
    heading("The paper's claims")
        + &format!("{counts}.\n\n")
        + &table(&head, &rows)
        + &readings(report)
}

/// The verdicts on the readings of claims, in a sentence.
fn readings(report: &Report<'_>) -> String {
    let readings = report.claims.iter().filter_map(|finding| {
        let verdict = outcome::answered(finding.verdict);
        Some(format!("{} {verdict}", finding.reading_of?))
    });
    let readings: Vec<String> = readings.collect();
    if readings.is_empty() {
        String::new()
    } else {
        format!(
            "\nAs the text also allows to read them: {}.\n",
            text(&readings.join(", "))
        )
    }
}

/// The reasons why cells are not complete, each with its cells.
fn faults(outcomes: &[(&Run, CellOutcome)]) -> String {
    let mut faults: BTreeMap<(OutcomeKind, &str), Vec<&str>> = BTreeMap::new();
    for (run, CellOutcome { kind, reason }) in outcomes {
        if !matches!(kind, OutcomeKind::Complete | OutcomeKind::NotRun) {
            let cells = faults.entry((*kind, reason)).or_default();
            cells.push(&run.cell.id);
        }
    }
    if faults.is_empty() {
        return String::new();
    }
    let rows: Vec<Vec<String>> = faults
        .into_iter()
        .map(|((kind, reason), cells)| vec![kind.word().to_owned(), text(reason), some(&cells)])
        .collect();
    let head = ["ended", "why", "cells"].map(str::to_owned);
    heading("Cells that are not complete") + &table(&head, &rows)
}

/// The cells that have not been run, by topology.
fn missing(report: &Report<'_>, outcomes: &[(&Run, CellOutcome)]) -> String {
    let absent = || {
        outcomes
            .iter()
            .filter(|(_, it)| it.kind == OutcomeKind::NotRun)
    };
    let count = absent().count();
    if count == 0 {
        return String::new();
    }
    let rows: Vec<Vec<String>> = outcome::topologies(report.campaign)
        .into_iter()
        .map(|topology| {
            let of_it = absent().filter(|(run, _)| run.cell.topology == topology);
            let cells: Vec<&str> = of_it.map(|(run, _)| run.cell.id.as_str()).collect();
            (topology, cells)
        })
        .filter(|(_, cells)| !cells.is_empty())
        .map(|(topology, cells)| vec![text(topology), some(&cells)])
        .collect();
    let head = ["topology", "cells"].map(str::to_owned);
    let of = outcomes.len();
    let sentence = format!("Of {of} cells {count} have not been run here.\n\n");
    heading("Not run") + &sentence + &table(&head, &rows)
}

/// The first few cells, and how many more there are.
fn some(cells: &[&str]) -> String {
    const FEW: usize = 3;
    let named: Vec<String> = cells.iter().take(FEW).map(|cell| text(cell)).collect();
    match cells.len().saturating_sub(FEW) {
        0 => named.join(", "),
        more => format!("{} and {more} more", named.join(", ")),
    }
}

fn heading(words: &str) -> String {
    format!("## {words}\n\n")
}

/// A table, cut after [`MOST_LINES`]; empty if there are no rows.
fn table(head: &[String], rows: &[Vec<String>]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let line = |entries: &[String]| format!("| {} |\n", entries.join(" | "));
    let rule = vec!["---".to_owned(); head.len()];
    let shown: String = rows.iter().take(MOST_LINES).map(|row| line(row)).collect();
    let more = match rows.len().saturating_sub(MOST_LINES) {
        0 => String::new(),
        more => format!("\n{more} more are in the report.\n"),
    };
    line(head) + &line(&rule) + &shown + &more
}

/// Makes a text safe for a table's cell: on one line, cut to a length, and with the characters
/// escaped that mean something in Markdown or HTML.
fn text(words: &str) -> String {
    let mut words: Vec<char> = words.chars().collect();
    if words.len() > MOST_CHARACTERS {
        words.truncate(MOST_CHARACTERS);
        words.push('…');
    }
    let mut out = String::new();
    for c in words {
        match c {
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '&' => out += "&amp;",
            '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '~' | '#' => out.extend(['\\', c]),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}
