//! A verdict as a sign and a word: never by colour alone.

use maud::{Markup, html};

use crate::claim;
use crate::outcome::{OutcomeKind, answered};
use analysis::LoopVerdict;

/// How good the news is, which decides the colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tone {
    Good,
    Mixed,
    Bad,
    Quiet,
}

impl Tone {
    /// Its class in the style sheet.
    pub(super) fn class(self) -> &'static str {
        match self {
            Tone::Good => "good",
            Tone::Mixed => "mixed",
            Tone::Bad => "bad",
            Tone::Quiet => "quiet",
        }
    }

    fn sign(self) -> &'static str {
        match self {
            Tone::Good => "✓",
            Tone::Mixed => "◐",
            Tone::Bad => "✗",
            Tone::Quiet => "○",
        }
    }
}

/// A sign, and the word for it.
pub(super) fn badge(tone: Tone, word: &str) -> Markup {
    signed(tone, &html! { (word) })
}

/// The same with words that are markup.
pub(super) fn signed(tone: Tone, words: &Markup) -> Markup {
    html! {
        span.badge.(tone.class()) { span aria-hidden="true" { (tone.sign()) } " " (words) }
    }
}

/// How a run ended, in a word. What was not run is still to come, where the page is served while runs go on.
pub(super) fn ended(kind: OutcomeKind) -> Markup {
    html! {
        @if kind == OutcomeKind::NotRun {
            span.over { (kind.word()) } span.coming { "still to come" }
        } @else {
            (kind.word())
        }
    }
}

/// The verdict on a claim.
pub(super) fn of_claim(verdict: claim::Verdict) -> Markup {
    let tone = match verdict {
        claim::Verdict::Agrees => Tone::Good,
        claim::Verdict::Differs => Tone::Bad,
        claim::Verdict::CannotBeTold => Tone::Mixed,
        claim::Verdict::NotRun => Tone::Quiet,
    };
    badge(tone, answered(verdict))
}

/// The verdict on a run; `None` if it was not run.
pub(super) fn of_run(verdict: Option<plan::Verdict>) -> Markup {
    let tone = match verdict {
        Some(plan::Verdict::Complete) => Tone::Good,
        Some(plan::Verdict::Unsupported | plan::Verdict::Disturbed) => Tone::Mixed,
        Some(plan::Verdict::Invalid | plan::Verdict::Failed) => Tone::Bad,
        None => Tone::Quiet,
    };
    match verdict {
        Some(verdict) => badge(tone, &verdict.to_string()),
        None => signed(tone, &ended(OutcomeKind::NotRun)),
    }
}

/// The verdict on a loop.
pub(super) fn of_loop(verdict: LoopVerdict) -> Markup {
    let tone = match verdict {
        LoopVerdict::Holds => Tone::Good,
        LoopVerdict::HoldsBadly => Tone::Mixed,
        LoopVerdict::Unsettled | LoopVerdict::Silent | LoopVerdict::Lost => Tone::Bad,
    };
    badge(tone, &verdict.to_string())
}
