//! A verdict as a sign and a word: never by colour alone.

use maud::{Markup, html};

use crate::answer::Survival;
use crate::claim;
use crate::outcome::answered;
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
    html! {
        span.badge.(tone.class()) { span aria-hidden="true" { (tone.sign()) } " " (word) }
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
    let word = verdict.map_or_else(|| "not run".to_owned(), |verdict| verdict.to_string());
    badge(tone, &word)
}

/// The verdict on a loop.
pub(super) fn of_loop(verdict: LoopVerdict) -> Markup {
    let tone = match verdict {
        LoopVerdict::Stable => Tone::Good,
        LoopVerdict::NotSettled => Tone::Mixed,
        LoopVerdict::Unstable => Tone::Bad,
    };
    badge(tone, &verdict.to_string())
}

/// The tone of a loop's survival.
pub(super) fn tone_of(survival: Survival) -> Tone {
    match survival {
        Survival::Always => Tone::Good,
        Survival::Sometimes => Tone::Mixed,
        Survival::Never => Tone::Bad,
        Survival::Unknown => Tone::Quiet,
    }
}
