//! `junit.xml`: the cells and the claims as test cases, for the test views of CI systems.
//!
//! A suite is a topology, and a case is a cell; the claims of the paper are a suite of their own, and so
//! is what the experiment expects. Whether a cell's case passes is about the testbed: whether a loop was
//! stable is a property of its case, and a failure only where it was expected. There are no timestamps, since some readers take them
//! for the time at which the program was tested.

use std::collections::BTreeMap;
use std::time::Duration;

use analysis::Run;
use analysis::expect::{ClauseOutcome, Judgement};
use quick_junit::{NonSuccessKind, TestCase, TestCaseStatus, TestSuite};

use crate::claim::{Finding, Part, Verdict};
use crate::outcome::{self, CellOutcome, OutcomeKind};
use crate::report::Report;

/// Name of the suite of what is expected.
const EXPECT: &str = "expect";
/// Name of the suite of claims.
const CLAIMS: &str = "paper";

/// The text of `junit.xml`.
#[must_use]
pub fn xml(report: &Report<'_>) -> String {
    let name = format!("webloop {}", report.campaign.plan.experiment);
    let mut junit = quick_junit::Report::new(name);
    let runs = || report.campaign.runs.iter();
    for topology in outcome::topologies(report.campaign) {
        let of_it: Vec<&Run> = runs().filter(|run| run.cell.topology == topology).collect();
        junit.add_test_suite(cells(report, topology, &of_it));
    }
    if !report.claims.is_empty() {
        let mut suite = TestSuite::new(CLAIMS);
        suite.add_test_cases(report.claims.iter().map(claim));
        suite.set_time(Duration::ZERO);
        junit.add_test_suite(suite);
    }
    if !report.expectations.is_empty() {
        junit.add_test_suite(expectations(&report.expectations));
    }
    junit.set_time(runs().map(wall).sum());
    // This cannot fail: it writes to memory, and the library removes characters that XML does not
    // allow.
    junit.to_string().unwrap_or_default()
}

/// The suite of a topology.
fn cells(report: &Report<'_>, topology: &str, runs: &[&Run]) -> TestSuite {
    let mut suite = TestSuite::new(topology);
    let mut named: BTreeMap<String, usize> = BTreeMap::new();
    for run in runs {
        *named.entry(outcome::words(run)).or_default() += 1;
    }
    for run in runs {
        let words = outcome::words(run);
        // The words leave out a cell's duration, among others, but a name has to be unique.
        let name = match named.get(&words) {
            Some(1) => words,
            _ => format!("{words} ({})", run.cell.id),
        };
        let mut case = TestCase::new(name, status(report, run));
        case.set_classname(topology).set_time(wall(run));
        for (name, value) in properties(run) {
            case.add_property((name.as_str(), value.as_str()));
        }
        suite.add_test_case(case);
    }
    suite.set_time(runs.iter().map(|run| wall(run)).sum());
    suite
}

/// The status of a cell: the testbed's own faults are errors, a link that did not hold or a
/// disturbance is a failure, and a cell that was not run or is unsupported is skipped.
fn status(report: &Report<'_>, run: &Run) -> TestCaseStatus {
    let CellOutcome { kind, reason } = CellOutcome::of(report.campaign, run);
    let mut status = match kind {
        OutcomeKind::Complete => return TestCaseStatus::success(),
        OutcomeKind::Disturbed | OutcomeKind::Invalid => {
            TestCaseStatus::non_success(NonSuccessKind::Failure)
        }
        OutcomeKind::Failed | OutcomeKind::Damaged => {
            TestCaseStatus::non_success(NonSuccessKind::Error)
        }
        OutcomeKind::Unsupported | OutcomeKind::NotRun => TestCaseStatus::skipped(),
    };
    status.set_type(kind.word()).set_message(reason);
    status
}

/// The suite of what is expected: a case for each clause and group. Known failures are skipped.
fn expectations(judgement: &Judgement) -> TestSuite {
    let mut suite = TestSuite::new(EXPECT);
    for answer in &judgement.answers {
        let mut status = match answer.outcome {
            ClauseOutcome::Met => TestCaseStatus::success(),
            ClauseOutcome::NotMet | ClauseOutcome::NotTold { .. } => {
                TestCaseStatus::non_success(NonSuccessKind::Failure)
            }
            ClauseOutcome::Known | ClauseOutcome::Unsupported => TestCaseStatus::skipped(),
        };
        if answer.outcome != ClauseOutcome::Met {
            status.set_type(answer.outcome.word().to_lowercase());
            status.set_message(answer.to_string());
        }
        suite.add_test_case(expectation(
            format!("{}: {}", answer.group, answer.clause),
            status,
        ));
    }
    for clause in &judgement.unasked {
        let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
        status.set_message("no run here has it");
        suite.add_test_case(expectation(clause.to_string(), status));
    }
    suite.set_time(Duration::ZERO);
    suite
}

fn expectation(name: String, status: TestCaseStatus) -> TestCase {
    let mut case = TestCase::new(name, status);
    case.set_classname(EXPECT).set_time(Duration::ZERO);
    case
}

/// The cell's row of `summary.csv`, without empty fields.
fn properties(run: &Run) -> Vec<(String, String)> {
    let text = analysis::Summary::to_csv(std::slice::from_ref(&run.summary));
    let mut rows = csv::ReaderBuilder::new()
        .has_headers(false)
        .from_reader(text.as_bytes());
    let mut rows = rows.records().map_while(Result::ok);
    let (names, values) = (rows.next(), rows.next());
    let pairs = names.iter().flatten().zip(values.iter().flatten());
    pairs
        .filter(|(_, value)| !value.is_empty())
        .map(|(name, value)| (name.to_owned(), value.to_owned()))
        .collect()
}

/// How long a cell took; zero if it was not run.
fn wall(run: &Run) -> Duration {
    let wall_s = run.manifest.as_ref().map(|manifest| manifest.wall_s);
    wall_s
        .and_then(|wall_s| Duration::try_from_secs_f64(wall_s).ok())
        .unwrap_or_default()
}

/// A claim as a test case.
fn claim(finding: &Finding) -> TestCase {
    let mut status = match finding.verdict {
        Verdict::Agrees => TestCaseStatus::success(),
        Verdict::Differs => TestCaseStatus::non_success(NonSuccessKind::Failure),
        Verdict::NotRun | Verdict::CannotBeTold => TestCaseStatus::skipped(),
    };
    if finding.verdict != Verdict::Agrees {
        let parts: Vec<String> = finding.parts.iter().map(part).collect();
        status
            .set_type(outcome::answered(finding.verdict))
            .set_message(finding.reason.as_str())
            .set_description(parts.join("\n"));
    }
    let mut case = TestCase::new(finding.id, status);
    case.set_classname(CLAIMS);
    case.set_time(Duration::ZERO);
    case.add_properties([
        ("place", finding.place),
        ("claim", finding.claim),
        ("check", finding.check.as_str()),
        ("reason", finding.reason.as_str()),
    ]);
    case
}

/// A number of a claim with what is accepted:
/// `settling on arima: 0.31 s (0.29 to 0.33, n 20), accepted 0.2 to 0.4: agrees`.
fn part(part: &Part) -> String {
    let with_unit = |x: f64| match part.unit {
        "" => format!("{x}"),
        unit => format!("{x} {unit}"),
    };
    let ours = part.ours.map_or("not run".to_owned(), |ours| {
        let interval = if ours.has_interval() {
            format!("{} to {}", ours.low, ours.high)
        } else {
            "no interval".to_owned()
        };
        format!("{} ({interval}, n {})", with_unit(ours.value), ours.n)
    });
    let paper = part.paper.map_or(String::new(), |paper| {
        format!(", the paper {}", with_unit(paper))
    });
    let accepted = part.accepted.map_or(String::new(), |(low, high)| {
        format!(", accepted {low} to {high}")
    });
    let verdict = outcome::answered(part.verdict);
    format!("{}: {ours}{paper}{accepted}: {verdict}", part.of)
}
