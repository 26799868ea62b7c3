//! Blame in words: when, how old, of what, and what to do about it.

use std::fmt;

use super::{Blame, Cause, End, Stamps};

/// A part below this share of the age is not named.
const NAMED: u64 = 20;

impl Cause {
    /// What a part of an age was spent with, behind its length: `412 ms were the link’s delay`.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Cause::Link => "on the link",
            Cause::Loss => "for packets that the link lost",
            Cause::Connection => "opening a connection",
            Cause::Queue => "waiting for the answer to an earlier message",
            Cause::Controller => "while the controller stood still",
            Cause::Plant => "while the plant stood still",
            Cause::Sampling => "waiting for the next message, deadline or tick",
            Cause::Ends => "in the programs and kernels of the ends",
            Cause::Untold => "before the command was sent, which cannot be told apart",
        }
    }

    /// What to do about it, as a sentence.
    #[must_use]
    pub fn remedy(self) -> &'static str {
        match self {
            Cause::Link => {
                "Try a link with less delay there, or a law and a sample time that bear it: webloop margin says how much."
            }
            Cause::Loss => {
                "TCP sends a lost packet again after 200 ms and more: keep several messages under way, each on a connection of its own, so that the next one does not wait for it."
            }
            Cause::Connection => {
                "Keep connections open, and open as many before the start as messages may be under way."
            }
            Cause::Queue => {
                "Let more messages be under way at once (outstanding), or send less often."
            }
            Cause::Controller => {
                "Give the controller real-time scheduling and a processor of its own, and keep collection of garbage, logging and disks out of its loop."
            }
            Cause::Plant => {
                "Make the plant’s step shorter than h, or h longer, and give it real-time scheduling."
            }
            Cause::Sampling => "Nothing held it up: only a shorter h makes it younger.",
            Cause::Ends => {
                "Look for other work on the machine, and for what the controller and the plant do between receiving and sending."
            }
            Cause::Untold => {
                "Send seq and t_send_ns with each message, and it can be told whether the controller, its connections or its kernel took that time."
            }
        }
    }
}

impl Blame {
    /// The parts that matter, that of the cause first: `398 ms on the link (390 up, 8 down), 9 ms waiting for …`.
    #[must_use]
    pub fn parts(&self) -> String {
        let mut parts: Vec<(u64, Cause)> = Cause::ALL
            .into_iter()
            .map(|cause| (self.part_ns(cause), cause))
            .filter(|(ns, cause)| *ns * NAMED > self.age_ns() || *cause == self.cause())
            .collect();
        parts.sort_by_key(|(ns, cause)| (*cause != self.cause(), std::cmp::Reverse(*ns)));
        let words = parts.into_iter().map(|(ns, cause)| {
            let ways = match cause {
                Cause::Link => {
                    let down_ns = ns.saturating_sub(self.up_ns);
                    format!(" ({} up, {} down)", ms(self.up_ns), ms(down_ns))
                }
                _ => String::new(),
            };
            format!("{} {}{ways}", ms(ns), cause.words())
        });
        words.collect::<Vec<_>>().join(", ")
    }

    /// When, in seconds from the first deadline: `3.21`.
    #[must_use]
    pub fn at_s(&self) -> f64 {
        self.to_ns as f64 / 1e9
    }
}

impl fmt::Display for Blame {
    /// `at 3.62 s the plant was steered by a y that was 412 ms old, where 9.0 ms are usual: 398 ms on the link
    /// (390 ms up, 8.0 ms down)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (at_s, age) = (self.at_s(), ms(self.age_ns()));
        let (from_s, usual) = (self.from_ns as f64 / 1e9, ms(self.usual_ns));
        match (self.stands_out(), self.end, self.from_ns) {
            (false, ..) => write!(
                f,
                "at its oldest, y was {age} old when the plant was steered by it"
            )?,
            (_, End::Over, _) => write!(
                f,
                "no newer y steered the plant from {from_s:.2} s to the end at {at_s:.2} s"
            )?,
            (_, End::Lost, _) => write!(
                f,
                "no newer y steered the plant from {from_s:.2} s until the loop was lost at {at_s:.2} s"
            )?,
            (_, _, 0) => write!(
                f,
                "no y newer than the start’s steered the plant before {at_s:.2} s"
            )?,
            _ => write!(
                f,
                "at {at_s:.2} s the plant was steered by a y that was {age} old"
            )?,
        }
        if self.end == End::Newer || !self.stands_out() {
            write!(f, ", where {usual} are usual")?;
        }
        write!(f, ": {}", self.parts())?;
        match self.stamps {
            Stamps::All => Ok(()),
            Stamps::Sent => write!(
                f,
                " (its answers are taken to come as soon as the link allows: it says when it sends, not when it receives)"
            ),
            Stamps::None => write!(
                f,
                " (as far as can be told of a controller that does not say when it sends)"
            ),
        }
    }
}

/// Milliseconds to three digits or so, with the unit beside them: `412 ms`, `9.0 ms`, `0.35 ms`.
fn ms(ns: u64) -> String {
    let ms = ns as f64 / 1e6;
    match ms {
        ms if ms >= 9_999.5 => format!("{:.1} s", ms / 1e3),
        ms if ms >= 9.95 => format!("{ms:.0} ms"),
        ms if ms >= 0.95 => format!("{ms:.1} ms"),
        _ => format!("{ms:.2} ms"),
    }
}
