//! Where errors lie about their band: whether they settled in it, and when they left it, once or for good.

use control::step_info::greatest;

/// An output has to stay in its band for this part of the response to have settled.
const DWELL: f64 = 0.1;

/// Where an output begins.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Outset {
    /// In its band, where it is to stay.
    Inside,
    /// Outside of its band, which it is to come into.
    Outside,
}

/// Where errors lie about their band.
pub(super) struct Place {
    /// Whether they are within it at the end, for long enough.
    pub(super) is_settled: bool,
    /// When they left it last after having been settled, and the greatest error from then on.
    pub(super) left: Option<(usize, f64)>,
}

impl Place {
    /// That of an output with these errors.
    pub(super) fn of(e: &[f64], band: f64, outset: Outset) -> Place {
        let dwell = dwell(e.len());
        let is_out = |e: &f64| e.abs() > band;
        // Where it begins in its band, it is as if it had been there.
        let run = match outset {
            Outset::Inside => dwell,
            Outset::Outside => 0,
        };
        let inside = e.iter().rposition(is_out).map_or(0, |last| last + 1);
        Place {
            is_settled: e.len() - inside >= dwell,
            left: left(e, band, dwell, run),
        }
    }
}

/// For how many of `all` samples an output has to stay to have settled.
fn dwell(all: usize) -> usize {
    ((all as f64 * DWELL) as usize).max(1)
}

/// The sample from which errors are gone beyond `reach`: the first beyond it after they were last within it for long
/// enough to have settled. What swings ever farther is within it at moments all the same. `None` if all are within.
pub(super) fn gone(e: &[f64], reach: f64) -> Option<usize> {
    let dwell = dwell(e.len());
    let (mut gone, mut run) = (None, 0);
    for (at, e) in e.iter().enumerate() {
        if e.abs() <= reach {
            run += 1;
            continue;
        }
        if gone.is_none() || run >= dwell {
            gone = Some(at);
        }
        run = 0;
    }
    gone
}

/// When errors first left their band after having been in it for `dwell` samples, and the greatest from then on.
/// Before the first they had been in it for `run`.
fn left(e: &[f64], band: f64, dwell: usize, mut run: usize) -> Option<(usize, f64)> {
    let at = e.iter().position(|e| {
        let is_in = e.abs() <= band;
        let was = run;
        run = if is_in { run + 1 } else { 0 };
        !is_in && was >= dwell
    })?;
    Some((at, greatest(&e[at..], f64::abs)))
}

#[cfg(test)]
mod tests {
    use super::gone;

    #[test]
    fn errors_are_gone_from_when_they_no_longer_settle() {
        // A spike at the start, from which they came back, and a swing that grows through 0 again and again.
        let swing = |k: usize| 0.2 * (0.03 * k as f64).exp() * (0.5 * k as f64).sin();
        let mut e = vec![0.0; 100];
        e[3] = 9.0;
        e.extend((0..100).map(swing));
        let first = e
            .iter()
            .skip(4)
            .position(|e| e.abs() > 1.0)
            .map(|at| at + 4);
        assert_eq!(gone(&e, 1.0), first);
        assert_eq!(gone(&e[..100], 1.0), Some(3));
        assert_eq!(gone(&e, 99.0), None);
        assert_eq!(gone(&[f64::NAN], 1.0), Some(0));
        assert_eq!(gone(&[], 1.0), None);
    }
}
