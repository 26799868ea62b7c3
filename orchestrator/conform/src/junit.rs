//! The outcomes as a `junit.xml`, for the test views of CI systems: a case for each trial.

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

use crate::outcome::{TrialResult, Verdict};

/// Name of the suite.
const SUITE: &str = "conform";

/// The text of a `junit.xml`.
#[must_use]
pub fn junit(outcomes: &[TrialResult]) -> String {
    let mut suite = TestSuite::new(SUITE);
    suite.add_test_cases(outcomes.iter().map(case));
    suite.set_time(outcomes.iter().map(|one| one.wall).sum());
    let mut report = Report::new("webloop conform");
    report.set_time(outcomes.iter().map(|one| one.wall).sum());
    report.add_test_suite(suite);
    // This cannot fail: it writes to memory, and the library removes characters that XML does not
    // allow.
    report.to_string().unwrap_or_default()
}

fn case(outcome: &TrialResult) -> TestCase {
    let words = outcome.words.join("\n");
    let mut status = match outcome.verdict {
        Verdict::Passed => TestCaseStatus::success(),
        Verdict::Unsupported => TestCaseStatus::skipped(),
        Verdict::Failed => TestCaseStatus::non_success(NonSuccessKind::Failure),
    };
    if outcome.verdict != Verdict::Passed {
        status
            .set_type(outcome.verdict.to_string())
            .set_message(words.as_str());
    }
    let mut case = TestCase::new(outcome.trial, status);
    case.set_classname(SUITE).set_time(outcome.wall);
    case.add_properties([("asks", outcome.asks), ("found", words.as_str())]);
    case
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_case_passes_fails_or_is_skipped_as_its_trial() {
        let outcome = |trial, verdict| TrialResult {
            trial,
            asks: "Anything.",
            verdict,
            words: vec!["a <word>".to_owned()],
            wall: Duration::from_secs(1),
        };
        let xml = junit(&[
            outcome("steady", Verdict::Passed),
            outcome("stop", Verdict::Failed),
            outcome("open", Verdict::Unsupported),
        ]);
        assert!(
            xml.contains(r#"tests="3" skipped="1" failures="1" errors="0""#),
            "{xml}"
        );
        assert!(xml.contains("a &lt;word&gt;"), "{xml}");
        assert!(xml.contains(r#"time="3.000""#), "{xml}");
    }
}
