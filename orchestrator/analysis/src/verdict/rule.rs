//! The rule itself: for a step or a rest, for a reference that moves, and for an output without one.

use control::step_info::greatest;
use plan::system::Band;

use super::fifth::{GROWTH, PARTS, grows, part, worst_errors};
use super::place::{Outset, Place, gone};
use super::{Course, Finding, LoopVerdict};
use crate::asked::{Asked, Task};
use crate::reason::Reason;
use crate::statistics::mean;

/// An excursion of this part of the step, from an output that had settled, is worth naming.
const EXCURSION: f64 = 0.1;
/// An output that stays this many times the step away from r throughout the last fifth is lost.
const FAR: f64 = 2.0;

/// The verdict on an output that follows a step, or is to stay where it is.
///
/// - *Lost*: a value is not finite or beyond its limits; the greatest error of the last fifth is more than the
///   step and has grown by a tenth over each of three fifths; no sample of the last fifth is nearer than two
///   steps; or the plant, without commands, ends more than a step away and still leaving.
/// - *Silent*: see [`silence`](crate::silence).
/// - *Holds*: y is in its band for the last tenth at least. Where it had been there before, and left it by more
///   than a tenth of the step, it holds badly; so it does where only a short excursion of that size is left at
///   the end.
/// - *Does not settle*: anything else, a lasting oscillation included, and fewer than five samples.
#[must_use]
pub fn judge(course: &Course<'_>, asked: &Asked) -> Finding {
    if let Some(found) = beyond(course, asked) {
        return found;
    }
    let e = course.error;
    let silent = |silence| Finding::of(LoopVerdict::Silent, Reason::Silence(silence));
    if e.len() < PARTS {
        return course.silence.map_or(UNSETTLED, silent);
    }
    let band = asked.band_for(course.step, course.task);
    let scale = course.step.abs().max(band.unwrap_or(0.0));
    if let Some(reason) = growth(course, scale) {
        return Finding::lost(reason, since(course, scale));
    }
    if let Some(silence) = course.silence {
        return silent(silence);
    }
    // Without a scale, what does not grow holds.
    let Some(band) = band else {
        return Finding::HOLDS;
    };
    let outset = if course.step.abs() <= band {
        Outset::Inside
    } else {
        Outset::Outside
    };
    let place = Place::of(e, band, outset);
    let least = course.step.abs() * EXCURSION;
    let left = place
        .left
        .filter(|(_, error)| outset == Outset::Inside || *error > least);
    let left = left.map(|(at, error)| Reason::Left {
        at_s: at as f64 * course.h_s,
        error,
    });
    if place.is_settled {
        return well(course, asked, left);
    }
    let last = part(e, PARTS - 1);
    let worst = greatest(last, f64::abs);
    let is_near = mean(last).abs() <= band && worst <= (EXCURSION * course.step.abs()).max(band);
    match place.left {
        // It had settled, and only a short excursion is left.
        Some((at, error)) if is_near => {
            let at_s = at as f64 * course.h_s;
            Finding::of(LoopVerdict::HoldsBadly, Reason::Left { at_s, error })
        }
        _ => Finding::of(LoopVerdict::Unsettled, Reason::Outside(worst)),
    }
}

/// The verdict on a first output whose reference `r` moves without rest, sample by sample.
///
/// - *Lost*: as by [`judge`], with the range of r in place of the step.
/// - *Holds*: y follows. In the last fifth its error is within the band that is asked; where none is, no error
///   there exceeds half the range of r, which an output that rests in the middle would have, nor by more than a
///   tenth the largest error before.
/// - *Does not settle*: anything else.
///
/// # Panics
/// If there is not one r for each sample.
#[must_use]
pub fn judge_following(course: &Course<'_>, r: &[f64], asked: &Asked) -> Finding {
    assert_eq!(course.error.len(), r.len(), "one r for each sample");
    if let Some(found) = beyond(course, asked) {
        return found;
    }
    let most = |sign: f64| greatest(r, |r| sign * r);
    let span = most(1.0) + most(-1.0);
    let Some(worst) = worst_errors(course.error, 0.0) else {
        return UNSETTLED;
    };
    let last = worst[PARTS - 1];
    if grows(&worst) && last > span {
        return Finding::lost(Reason::Grows, since(course, span));
    }
    if let Some(silence) = course.silence {
        return Finding::of(LoopVerdict::Silent, Reason::Silence(silence));
    }
    let earlier = greatest(&worst[..PARTS - 1], |error| error);
    let follows = match asked
        .band_for(span, Task::Tracking)
        .filter(|_| asked.band.is_some())
    {
        Some(band) => last <= band,
        None => last <= span / 2.0 + asked.noise && last <= GROWTH * earlier + asked.noise,
    };
    if follows {
        well(course, asked, None)
    } else {
        Finding::of(LoopVerdict::Unsettled, Reason::Outside(last))
    }
}

/// The verdict on an output that comes to rest wherever it may: its reference, if it has one, is in the law.
///
/// - *Lost*: a value is not finite or beyond its limits; or its distance from where it ends is largest in the
///   last fifth, after growing over three.
/// - *Holds*: in the last fifth it is within its band about where it ends; where none is asked, within a tenth
///   of its farthest from there.
/// - *Does not settle*: anything else.
#[must_use]
pub fn judge_free(course: &Course<'_>, asked: &Asked) -> Finding {
    if let Some(found) = beyond(course, asked) {
        return found;
    }
    let y = course.y;
    if y.len() < PARTS {
        return UNSETTLED;
    }
    let Some(worst) = worst_errors(y, mean(part(y, PARTS - 1))) else {
        return UNSETTLED;
    };
    let (last, farthest) = (worst[PARTS - 1], greatest(&worst, |error| error));
    if grows(&worst) && last >= farthest && last > 0.0 {
        // What is to be left is where it ends, and that is known only then.
        return Finding::lost(Reason::Grows, None);
    }
    let band = match asked.band {
        Some(Band::Absolute(band)) => band,
        Some(Band::OfStep(part)) => part * farthest,
        None => EXCURSION * farthest,
    };
    if last <= band + asked.noise {
        Finding::HOLDS
    } else {
        Finding::of(LoopVerdict::Unsettled, Reason::Outside(last))
    }
}

const UNSETTLED: Finding = Finding {
    verdict: LoopVerdict::Unsettled,
    reason: None,
    lost_s: None,
};

/// The finding on a loop that holds: well, unless it overshoots, strays or pushes more than is asked.
fn well(course: &Course<'_>, asked: &Asked, left: Option<Reason>) -> Finding {
    let overshoot = course
        .overshoot_pct
        .filter(|pct| *pct > asked.overshoot_pct);
    let effort = (course.effort > asked.effort).then_some(Reason::Effort(course.effort));
    let bad = overshoot.map(Reason::Overshoot).or(left).or(effort);
    bad.map_or(Finding::HOLDS, |reason| {
        Finding::of(LoopVerdict::HoldsBadly, reason)
    })
}

/// The first value that is not finite, or beyond the limits.
fn beyond(course: &Course<'_>, asked: &Asked) -> Option<Finding> {
    let (least, greatest) = asked.limits;
    // Without a way out of the loop it is several times as fast, and nearly always there is no such value.
    let is_within = |y: &f64| y.is_finite() & (*y >= least) & (*y <= greatest);
    if course.y.iter().fold(true, |all, y| all & is_within(y)) {
        return None;
    }
    let at = course.y.iter().position(|y| !is_within(y))?;
    let at_s = at as f64 * course.h_s;
    let y = course.y[at];
    let reason = if y.is_finite() {
        Reason::Limits { at_s, y }
    } else {
        Reason::NotFinite(at_s)
    };
    Some(Finding::lost(reason, Some(at_s)))
}

/// Since when the errors of a lost course are gone, s: beyond twice the scale, or beyond it where they never are
/// twice as large. Without a scale, beyond what the first two fifths had, since the last three grew.
fn since(course: &Course<'_>, scale: f64) -> Option<f64> {
    let worst = worst_errors(course.error, 0.0)?;
    let reach = match scale > 0.0 {
        true if worst[PARTS - 1] > FAR * scale => FAR * scale,
        true => scale,
        false => greatest(&worst[..PARTS - 3], |error| error),
    };
    gone(course.error, reach).map(|at| at as f64 * course.h_s)
}

/// Why the errors of a course say that it is lost; `None` if they do not. `scale` is the error that a lost loop
/// has at least.
fn growth(course: &Course<'_>, scale: f64) -> Option<Reason> {
    let e = course.error;
    let worst = worst_errors(e, 0.0)?;
    let last = worst[PARTS - 1];
    let earlier = greatest(&worst[..PARTS - 1], |error| error);
    // Without a scale, growth has to exceed all that was before.
    let is_large = if scale > 0.0 {
        last > scale
    } else {
        last > earlier
    };
    if grows(&worst) && is_large {
        return Some(Reason::Grows);
    }
    let nearest = -greatest(part(e, PARTS - 1), |e| -e.abs());
    if scale > 0.0 && nearest > FAR * scale {
        return Some(Reason::Away(nearest));
    }
    // Alone at the end: a plant that leaves has not been gone for three fifths yet.
    let alone = &e[e.len() - course.open.min(e.len())..];
    let thirds = |i: usize| {
        greatest(
            &alone[alone.len() * i / 3..alone.len() * (i + 1) / 3],
            f64::abs,
        )
    };
    let leaves = alone.len() >= PARTS && (1..3).all(|i| thirds(i) > GROWTH * thirds(i - 1));
    let end = alone.last().map_or(0.0, |e| e.abs());
    (leaves && scale > 0.0 && end > scale).then_some(Reason::Grows)
}
