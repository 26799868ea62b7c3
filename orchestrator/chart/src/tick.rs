//! Round numbers along an axis, and how they are written.

use crate::chart::Scale;
use crate::span::Span;
use crate::text::superscript;

/// Steps shorter or longer than these would not survive arithmetic.
const SHORTEST: f64 = 1e-290;
const LONGEST: f64 = 1e290;

/// This many steps from zero, a number no longer has the digits to tell two steps apart.
const MOST_STEPS: f64 = 1e14;

/// The marks of one axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Ticks {
    /// Numbers with what is written at them.
    pub(crate) labelled: Vec<(f64, String)>,
    /// Numbers that are marked only.
    pub(crate) minor: Vec<f64>,
    /// What every written number is to be multiplied by, or added to; often empty.
    pub(crate) note: String,
}

impl Ticks {
    /// About `count` ticks, or fewer.
    pub(crate) fn of(span: &Span, count: usize) -> Ticks {
        match span.scale {
            Scale::Linear => linear(span, count),
            Scale::Log => log(span, count).unwrap_or_else(|| linear(span, count)),
        }
    }
}

/// A number of steps, and the step as 1, 2 or 5 times a power of ten.
#[derive(Clone, Copy)]
struct Step {
    digit: f64,
    exponent: i32,
}

impl Step {
    fn at_least(length: f64) -> Step {
        let exponent = length.log10().floor() as i32;
        let rest = length / 10_f64.powi(exponent);
        // What is a hair above a round step, by rounding, is that step.
        let rest = rest * (1.0 - 1e-9);
        let (digit, exponent) = match rest {
            _ if rest <= 1.0 => (1.0, exponent),
            _ if rest <= 2.0 => (2.0, exponent),
            _ if rest <= 5.0 => (5.0, exponent),
            _ => (1.0, exponent + 1),
        };
        Step { digit, exponent }
    }

    /// This many steps, rounded once only.
    fn times(self, count: f64) -> f64 {
        if self.exponent < 0 {
            count * self.digit / 10_f64.powi(-self.exponent)
        } else {
            count * self.digit * 10_f64.powi(self.exponent)
        }
    }
}

fn linear(span: &Span, count: usize) -> Ticks {
    let ends = || Ticks {
        labelled: vec![(span.lo, plain(span.lo)), (span.hi, plain(span.hi))],
        ..Ticks::default()
    };
    let wanted = (span.hi / 2.0 - span.lo / 2.0) / count.max(1) as f64 * 2.0;
    if !(SHORTEST..LONGEST).contains(&wanted) {
        return ends();
    }
    let step = Step::at_least(wanted);
    let length = step.times(1.0);
    let first = (span.lo / length - 1e-9).ceil();
    let last = (span.hi / length + 1e-9).floor();
    if first.abs().max(last.abs()) >= MOST_STEPS || last < first {
        return ends();
    }
    let many = first.abs().max(last.abs());
    // Numbers that agree in their first five digits are written from the first of them on.
    let origin = if many >= 1e5 { first } else { 0.0 };
    let largest = step.times((first - origin).abs().max((last - origin).abs()));
    let thousands = if largest > 0.0 && !(1e-2..1e5).contains(&largest) {
        3 * (largest.log10() / 3.0 + 1e-9).floor() as i32
    } else {
        0
    };
    let places = usize::try_from(thousands - step.exponent).unwrap_or(0);
    let unit = Step {
        digit: step.digit,
        exponent: step.exponent - thousands,
    };
    let steps = (last - first) as u32;
    let labelled = (0..=steps)
        .map(|n| {
            let count = first + f64::from(n);
            // Adding zero turns a negative zero into zero.
            let written = format!("{:.places$}", unit.times(count - origin) + 0.0);
            (step.times(count).clamp(span.lo, span.hi), minus(&written))
        })
        .collect();
    let mut note = String::new();
    if thousands != 0 {
        note = format!("×10{}", superscript(thousands));
    }
    if origin != 0.0 {
        note = format!("{note} + {}", plain(step.times(origin)));
    }
    Ticks {
        labelled,
        minor: Vec::new(),
        note: note.trim().to_owned(),
    }
}

/// Powers of ten, or what is between them where there are few; none where the span is so short
/// that evenly spaced numbers are as good.
fn log(span: &Span, count: usize) -> Option<Ticks> {
    let first = (span.lo.log10() - 1e-9).ceil() as i32;
    let last = (span.hi.log10() + 1e-9).floor() as i32;
    let inside = |v: &f64| *v >= span.lo * (1.0 - 1e-9) && *v <= span.hi * (1.0 + 1e-9);
    let between = |digits: &[f64]| -> Vec<(f64, i32)> {
        (first - 1..=last)
            .flat_map(|e| {
                digits.iter().map(move |d| {
                    (
                        Step {
                            digit: *d,
                            exponent: e,
                        }
                        .times(1.0),
                        e,
                    )
                })
            })
            .filter(|(v, _)| inside(v))
            .collect()
    };
    let decades = usize::try_from(last - first + 1).unwrap_or(0);
    let labelled = if decades >= 3 || (decades == 2 && count < 5) {
        let every = decades.div_ceil(count.max(1)).max(1);
        (first..=last)
            .step_by(every)
            .map(|e| {
                (
                    Step {
                        digit: 1.0,
                        exponent: e,
                    }
                    .times(1.0),
                    e,
                )
            })
            .collect()
    } else {
        let some = between(&[1.0, 2.0, 5.0]);
        if some.len() < 3 {
            return None;
        }
        some
    };
    let words = labelled.iter().all(|(_, e)| (-3..=4).contains(e));
    let labelled: Vec<(f64, String)> = labelled
        .into_iter()
        .map(|(v, e)| {
            let digit = (v / 10_f64.powi(e)).round();
            let label = match (words, digit as i32) {
                (true, _) => format!("{:.*}", usize::try_from(-e).unwrap_or(0), v),
                (false, 1) => format!("10{}", superscript(e)),
                (false, d) => format!("{d}×10{}", superscript(e)),
            };
            (v.clamp(span.lo, span.hi), label)
        })
        .collect();
    let minor = if decades <= 8 {
        between(&[2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0])
            .into_iter()
            .map(|(v, _)| v.clamp(span.lo, span.hi))
            .filter(|v| labelled.iter().all(|(l, _)| l != v))
            .collect()
    } else {
        Vec::new()
    };
    Some(Ticks {
        labelled,
        minor,
        note: String::new(),
    })
}

/// A number as it comes, with a power of ten if it is long.
fn plain(value: f64) -> String {
    let (short, long) = (format!("{value}"), format!("{value:e}"));
    minus(if short.len() <= 12 { &short } else { &long })
}

fn minus(number: &str) -> String {
    number.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(lo: f64, hi: f64, scale: Scale) -> (Vec<String>, String) {
        let ticks = Ticks::of(&Span { lo, hi, scale }, 5);
        let labels = ticks.labelled.into_iter().map(|(_, label)| label).collect();
        (labels, ticks.note)
    }

    #[test]
    fn even_steps_are_round_and_equally_written() {
        let (written, note) = labels(-0.21, 0.83, Scale::Linear);
        assert_eq!(written, ["0.0", "0.5"]);
        assert_eq!(note, "");
        assert_eq!(
            labels(0.0, 1.0, Scale::Linear).0,
            ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]
        );
        assert_eq!(
            labels(-3.0, 2.0, Scale::Linear).0,
            ["−3", "−2", "−1", "0", "1", "2"]
        );
    }

    #[test]
    fn small_and_large_numbers_have_a_common_factor() {
        assert_eq!(
            labels(0.0, 4e-9, Scale::Linear),
            (
                ["0", "1", "2", "3", "4"].map(str::to_owned).to_vec(),
                "×10⁻⁹".to_owned()
            )
        );
        assert_eq!(labels(0.0, 4e9, Scale::Linear).1, "×10⁹");
    }

    #[test]
    fn numbers_that_hardly_differ_have_a_common_start() {
        let (written, note) = labels(1e9, 1e9 + 4.0, Scale::Linear);
        assert_eq!(written, ["0", "1", "2", "3", "4"]);
        assert_eq!(note, "+ 1000000000");
    }

    #[test]
    fn powers_of_ten_are_written_as_such_where_they_are_many() {
        assert_eq!(
            labels(0.01, 100.0, Scale::Log).0,
            ["0.01", "0.1", "1", "10", "100"]
        );
        assert_eq!(
            labels(1e-9, 1e-6, Scale::Log).0,
            ["10⁻⁹", "10⁻⁸", "10⁻⁷", "10⁻⁶"]
        );
        assert_eq!(labels(1.0, 20.0, Scale::Log).0, ["1", "2", "5", "10", "20"]);
    }
}
