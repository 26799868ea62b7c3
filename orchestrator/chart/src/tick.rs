//! Round numbers along an axis, or names, and how they are written.

use crate::axis::Scale;
use crate::layout::{self, TICK_SIZE};
use crate::span::Span;
use crate::text::{self, superscript};

/// Steps shorter or longer than these would underflow or overflow.
const SHORTEST: f64 = 1e-290;
const LONGEST: f64 = 1e290;

/// This many steps from zero, a number no longer has the digits to tell two steps apart.
const MOST_STEPS: f64 = 1e14;

/// The ticks of one axis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Ticks {
    /// Numbers with their labels.
    pub(crate) labelled: Vec<(f64, String)>,
    /// Numbers with a tick but no label.
    pub(crate) minor: Vec<f64>,
    /// Common factor and offset of all labels; often empty.
    pub(crate) note: String,
    /// Font size of the labels.
    pub(crate) size: f64,
}

impl Default for Ticks {
    fn default() -> Self {
        Ticks {
            labelled: Vec::new(),
            minor: Vec::new(),
            note: String::new(),
            size: TICK_SIZE,
        }
    }
}

impl Ticks {
    /// About `count` ticks, or fewer.
    pub(crate) fn of(span: &Span, count: usize) -> Ticks {
        match span.scale {
            Scale::Linear => linear(span, count),
            Scale::Log => log(span, count).unwrap_or_else(|| linear(span, count)),
        }
    }

    /// Names at 0, 1, 2 and so on, each with a space of this length and height. Longer names are
    /// smaller or cut short; if there is no room for a line of text, some names are left out.
    pub(crate) fn named(names: &[String], (room, high): (f64, f64)) -> Ticks {
        let every = (TICK_SIZE * 1.1 / high).ceil().max(1.0) as usize;
        let size = names
            .iter()
            .map(|name| layout::fitting(name, TICK_SIZE, room))
            .fold(TICK_SIZE, f64::min);
        let labelled = names
            .iter()
            .enumerate()
            .step_by(every)
            .map(|(at, name)| (at as f64, text::cut(name, size, room)))
            .collect();
        Ticks {
            labelled,
            size,
            ..Ticks::default()
        }
    }
}

/// A step: a digit, most often 1, 2 or 5, times a power of ten.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Step {
    digit: f64,
    exponent: i32,
}

impl Step {
    /// A digit times ten to the power of the exponent.
    pub(crate) fn new(digit: f64, exponent: i32) -> Step {
        Step { digit, exponent }
    }

    /// The shortest step with the digit 1, 2 or 5 that is at least this long.
    pub(crate) fn at_least(length: f64) -> Step {
        let exponent = length.log10().floor() as i32;
        let rest = length / 10_f64.powi(exponent);
        // A length that exceeds a round step only by rounding is that step.
        let rest = rest * (1.0 - 1e-9);
        let (digit, exponent) = match rest {
            _ if rest <= 1.0 => (1.0, exponent),
            _ if rest <= 2.0 => (2.0, exponent),
            _ if rest <= 5.0 => (5.0, exponent),
            _ => (1.0, exponent + 1),
        };
        Step { digit, exponent }
    }

    /// The length of this many steps, rounded only once.
    pub(crate) fn times(self, count: f64) -> f64 {
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
    // Numbers that agree in their first five digits are written as differences from the first of them.
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
        note: note.trim().to_owned(),
        ..Ticks::default()
    }
}

/// Powers of ten, and numbers between them if there are few. `None` if the span is so short that
/// evenly spaced numbers are as good.
fn log(span: &Span, count: usize) -> Option<Ticks> {
    let first = (span.lo.log10() - 1e-9).ceil() as i32;
    let last = (span.hi.log10() + 1e-9).floor() as i32;
    let inside = |v: f64| v >= span.lo * (1.0 - 1e-9) && v <= span.hi * (1.0 + 1e-9);
    let between = |digits: &[f64]| -> Vec<Step> {
        (first - 1..=last)
            .flat_map(|exponent| digits.iter().map(move |digit| Step::new(*digit, exponent)))
            .filter(|step| inside(step.times(1.0)))
            .collect()
    };
    let decades = usize::try_from(last - first + 1).unwrap_or(0);
    let labelled: Vec<Step> = if decades >= 3 || (decades == 2 && count < 5) {
        let every = decades.div_ceil(count.max(1)).max(1);
        (first..=last)
            .step_by(every)
            .map(|exponent| Step::new(1.0, exponent))
            .collect()
    } else {
        let some = between(&[1.0, 2.0, 5.0]);
        if some.len() < 3 {
            return None;
        }
        some
    };
    let labelled: Vec<(f64, String)> = written(&labelled)
        .into_iter()
        .map(|(v, label)| (v.clamp(span.lo, span.hi), label))
        .collect();
    let minor = if decades <= 8 {
        between(&[2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0])
            .into_iter()
            .map(|step| step.times(1.0).clamp(span.lo, span.hi))
            .filter(|v| labelled.iter().all(|(l, _)| l != v))
            .collect()
    } else {
        Vec::new()
    };
    Some(Ticks {
        labelled,
        minor,
        ..Ticks::default()
    })
}

/// Numbers with their labels: plain, unless one of them is very small or large.
pub(crate) fn written(numbers: &[Step]) -> Vec<(f64, String)> {
    let plainly = numbers
        .iter()
        .all(|number| (-3..=4).contains(&number.exponent));
    numbers
        .iter()
        .map(|number| {
            let (digit, exponent) = (number.digit, number.exponent);
            let value = number.times(1.0);
            let places = i32::from(digit.fract() != 0.0) - exponent;
            let label = match plainly {
                true => format!("{value:.*}", usize::try_from(places).unwrap_or(0)),
                false if digit == 1.0 => format!("10{}", superscript(exponent)),
                false => format!("{digit}×10{}", superscript(exponent)),
            };
            (value, label)
        })
        .collect()
}

/// A number with two significant digits and its whole integer part; with a power of ten if it is very
/// small or large.
pub(crate) fn short(value: f64) -> String {
    let exponent = value.abs().log10().floor();
    let written = match exponent {
        _ if value == 0.0 => "0".to_owned(),
        e if (-3.0..5.0).contains(&e) => format!("{value:.*}", (1.0 - e).max(0.0) as usize),
        e => format!("{:.1}×10{}", value / 10_f64.powf(e), superscript(e as i32)),
    };
    minus(&written)
}

/// A number with all its digits; with a power of ten if it is long.
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
