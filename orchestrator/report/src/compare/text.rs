//! A comparison as text for people, and as CSV for programs.

use analysis::LoopVerdict;
use analysis::layout::{Column, align, digits, number, text};
use endpoint::Mode;
use plan::{Client, Setup};
use serde::Serialize;

use super::{
    Answer, Compared, Comparison, Conclusion, GroupKey, LEVEL, Measure, PairedMeasures, Side,
};

/// The columns after those of the group's name.
const COLUMNS: [Column; 9] = [
    number("", "pairs"),
    text("measure"),
    number("median", "A"),
    number("median", "B"),
    number("change", "%"),
    number("chance", "sign"),
    number("chance", "ranks"),
    number("chance", "Holm"),
    text("B is"),
];

const OPEN_LEGEND: &str = "\
cannot tell: so many pairs would, if they go like these.
";

/// A row of the CSV.
#[derive(Serialize)]
struct Row<'a> {
    topology: &'a str,
    client: Client,
    setup: &'a Setup,
    mode: Mode,
    rate: &'a str,
    h_ns: u64,
    measure: Measure,
    unit: &'static str,
    pairs: usize,
    planned: usize,
    a: Option<f64>,
    b: Option<f64>,
    change: Option<f64>,
    p_sign: f64,
    p_rank: f64,
    p_holm: Option<f64>,
    outcome: Conclusion,
    at_worst: Option<f64>,
    would_tell: Option<usize>,
}

impl Comparison {
    /// The comparison as text; `a` and `b` are the names of the campaigns.
    #[must_use]
    pub fn to_text(&self, a: &str, b: &str) -> String {
        let mut out = format!("A: {}\nB: {}\n", self.a.words(a), self.b.words(b));
        let rows: Vec<Vec<String>> = {
            let lines = |group| lines(group, self.least_change);
            self.groups.iter().flat_map(lines).collect()
        };
        if !rows.is_empty() {
            out += &format!(
                "\n{}\n{}",
                align(&[&GroupKey::COLUMNS[..], &COLUMNS].concat(), &rows),
                legend(self.least_change)
            );
            if self.open().next().is_some() {
                out += OPEN_LEGEND;
            }
        }
        if !self.changed.is_empty() {
            out += "\nLoops whose verdict changed:\n";
        }
        for one in &self.changed {
            let repeats: Vec<String> = one.repeats.iter().map(u32::to_string).collect();
            let (from, to, repeats) = (one.from, one.to, repeats.join(", "));
            out += &format!("  {}: {from} in A, {to} in B, repeat {repeats}\n", one.kind);
        }
        if !self.lone.is_empty() {
            out += "\nNot compared:\n";
        }
        for one in &self.lone {
            out += &format!("  {}: {}\n", one.kind, one.reason);
        }
        format!("{out}\n{}\n", self.answer())
    }

    /// The comparison as CSV, with a row for each measure of each group: `a` and `b` in its unit, the
    /// change as a share.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let finite = |value: f64| Some(value).filter(|value| value.is_finite());
        let rows = self.groups.iter().flat_map(|group| {
            let kind = &group.kind;
            group.measures.iter().map(move |of| Row {
                topology: &kind.topology,
                client: kind.client,
                setup: &kind.setup,
                mode: kind.mode,
                rate: &kind.rate,
                h_ns: kind.h_ns,
                measure: of.measure,
                unit: of.measure.unit(),
                pairs: of.pairs,
                planned: group.planned,
                a: finite(of.a),
                b: finite(of.b),
                change: of.change.and_then(finite),
                p_sign: of.p_sign,
                p_rank: of.p_rank,
                p_holm: of.p_holm,
                outcome: of.outcome,
                at_worst: finite(of.at_worst),
                would_tell: of.would_tell,
            })
        });
        analysis::csv(rows)
    }

    /// The answer in a sentence or two, which begins with it.
    fn answer(&self) -> String {
        let all: usize = self.groups.iter().map(|group| group.measures.len()).sum();
        if all == 0 {
            return "There is nothing to compare.".to_owned();
        }
        let [worse, better] = [Conclusion::Worse, Conclusion::Better].map(|of| self.count(of));
        let open = self.open().count();
        let answer = match self.answer {
            Answer::Worse => "B is worse",
            Answer::NotWorse => "B is not worse",
            Answer::CannotTell => "Whether B is worse cannot be told",
        };
        let counts =
            format!("{answer}: {worse} worse, {better} better and {open} open of {all} measures.");
        [counts, self.more_pairs(), self.lost_loops()].concat()
    }

    /// How many pairs would tell; empty if the answer does not need them.
    fn more_pairs(&self) -> String {
        if self.answer != Answer::CannotTell {
            return String::new();
        }
        let needs = || self.open().map(|of| of.would_tell);
        let most = needs().flatten().max();
        let never = needs().filter(Option::is_none).count();
        let pairs = most.map_or(String::new(), |most| {
            format!(" {most} pairs of each would tell, if they go like these.")
        });
        match never {
            0 => pairs,
            1 => pairs + " For one of them no number of pairs would.",
            n => pairs + &format!(" For {n} of them no number of pairs would."),
        }
    }

    /// How many loops are lost in B.
    fn lost_loops(&self) -> String {
        let unstable = self
            .changed
            .iter()
            .filter(|one| one.to == LoopVerdict::Lost);
        match unstable.map(|one| one.repeats.len()).sum() {
            0 => String::new(),
            1 => " One loop is lost in B.".to_owned(),
            n => format!(" {n} loops are lost in B."),
        }
    }
}

impl Side {
    fn words(&self, name: &str) -> String {
        format!(
            "{name}, {} of seed {}, {}{} of {} cells complete",
            self.experiment,
            self.seed,
            if self.simulated { "simulated, " } else { "" },
            self.complete,
            self.cells
        )
    }
}

fn lines(group: &PairedMeasures, least_change: f64) -> Vec<Vec<String>> {
    let line = |of: &Compared| {
        let mut line = group.kind.entries().to_vec();
        line.extend([
            format!("{}/{}", of.pairs, group.planned),
            format!("{}, {}", of.measure.name(), of.measure.unit()),
            value(of.measure, of.a),
            value(of.measure, of.b),
            of.change.map_or("?".to_owned(), percent),
            chance(of.p_sign),
            chance(of.p_rank),
            of.p_holm.map_or("-".to_owned(), chance),
            words(of, least_change),
        ]);
        line
    };
    group.measures.iter().map(line).collect()
}

fn value(measure: Measure, value: f64) -> String {
    match (measure, value.is_finite()) {
        (_, true) => digits(Some(value)),
        (Measure::Settling | Measure::Rtt, false) => "never".to_owned(),
        (_, false) => "-".to_owned(),
    }
}

fn percent(change: f64) -> String {
    match change {
        // A loop that no longer settles has an infinite change; one that settles now has -100 %.
        change if change == f64::INFINITY => "+inf".to_owned(),
        change if (change * 1e3).round() == 0.0 => "0".to_owned(),
        change => format!("{:+.1}", change * 1e2),
    }
}

fn chance(p: f64) -> String {
    if p < 0.001 {
        "<0.001".to_owned()
    } else {
        format!("{p:.3}")
    }
}

fn words(of: &Compared, least_change: f64) -> String {
    let fixed = match of.outcome {
        Conclusion::Worse => "WORSE",
        Conclusion::Better => "better",
        Conclusion::Alike => "alike",
        Conclusion::Unclear | Conclusion::TooFew if !of.is_open(least_change) => "not worse",
        Conclusion::Unclear | Conclusion::TooFew => {
            let pairs = of.would_tell.map(|pairs| format!(": {pairs} pairs would"));
            return format!("cannot tell{}", pairs.unwrap_or_default());
        }
    };
    fixed.to_owned()
}

fn legend(least_change: f64) -> String {
    format!(
        "\
Pairs met the same second of the same link. RTT: a message's median, closed loop and open.
change: the median over the pairs of B against A, as a share of the reference for overshoot, of the
schedule for slope and sent, and of A's value for the others. Below {:.1} % it does not matter.
chance: the probability of such a difference in its direction by chance: sign test, signed-rank test,
and the latter corrected for all groups (Holm). From {LEVEL} on a difference may be chance.
",
        least_change * 1e2
    )
}
