//! The reference in a system's text: a number for each output, or one that moves.

use endpoint::{Reference, Shape};
use text::Diagnostic;
use toml::Spanned;

use crate::system::fault::Source;
use crate::system::file::{Each, ReferenceFile};
use crate::system::plant::PlantModel;

/// The references of the outputs, the first one first: 1, if none is given.
pub(crate) fn each(
    source: Source,
    asked: Option<&Spanned<Each>>,
    plant: &PlantModel,
) -> Result<Vec<f64>, Diagnostic> {
    let Some(asked) = asked else {
        return Ok(vec![1.0]);
    };
    let given = asked.get_ref().numbers();
    if let Some(r) = given.iter().find(|r| !r.is_finite()) {
        return Err(source.fault(asked, format!("r is {r}"), "give a finite number"));
    }
    // The outputs of a program are not known here.
    let outputs = plant.linear().map_or(1, |plant| plant.model.outputs());
    if !(1..=outputs).contains(&given.len()) {
        let problem = format!(
            "r has {} numbers, and the plant {}",
            given.len(),
            if outputs == 1 {
                "one output"
            } else {
                "two outputs"
            }
        );
        return Err(source.fault(
            asked,
            problem,
            "give a number for each output, or for the first alone",
        ));
    }
    Ok(given.to_vec())
}

/// Reads a reference. Each shape takes its own keys, and no other.
pub(crate) fn read(source: Source, asked: &Spanned<ReferenceFile>) -> Result<Shape, Diagnostic> {
    let file = asked.get_ref();
    let keys = [
        ("from", file.from.is_some()),
        ("to", file.to.is_some()),
        ("at", file.at.is_some()),
        ("low", file.low.is_some()),
        ("high", file.high.is_some()),
        ("period", file.period.is_some()),
        ("t_s", file.t_s.is_some()),
        ("r", file.r.is_some()),
    ];
    let shape = file.shape.get_ref().as_str();
    let takes: &[&str] = match shape {
        "step" => &["from", "to", "at"],
        "square" | "sine" => &["low", "high", "period"],
        "points" => &["t_s", "r"],
        _ => {
            let problem = format!("the reference's shape is `{shape}`");
            return Err(source.fault(&file.shape, problem, "choose step, square, sine or points"));
        }
    };
    if let Some((key, _)) = keys
        .iter()
        .find(|(key, given)| *given && !takes.contains(key))
    {
        let problem = format!("a reference of shape `{shape}` has no `{key}`");
        return Err(source.fault(asked, problem, format!("it takes {}", takes.join(", "))));
    }
    let lacks = |key: &str| {
        let problem = format!("a reference of shape `{shape}` needs `{key}`");
        source.fault(asked, problem, format!("it takes {}", takes.join(", ")))
    };
    let number = |key, value: &Option<Spanned<f64>>, usual: Option<f64>| match value {
        Some(value) => source.finite(key, value),
        None => usual.ok_or_else(|| lacks(key)),
    };
    let span = |key, value: &Option<Spanned<String>>| {
        let value = value.as_ref().ok_or_else(|| lacks(key))?;
        source.span_ns(value)
    };
    let period_ns = || match (span("period", &file.period)?, &file.period) {
        (0 | 1, Some(period)) => Err(source.fault(
            period,
            "the reference's period is 0",
            "give a time such as \"4s\"",
        )),
        (period_ns, _) => Ok(period_ns),
    };
    Ok(match shape {
        "step" => Shape::Step {
            from: number("from", &file.from, Some(0.0))?,
            to: number("to", &file.to, None)?,
            at_ns: span("at", &file.at)?,
        },
        "square" => Shape::Square {
            low: number("low", &file.low, Some(0.0))?,
            high: number("high", &file.high, None)?,
            period_ns: period_ns()?,
        },
        "sine" => Shape::Sine {
            low: number("low", &file.low, Some(0.0))?,
            high: number("high", &file.high, None)?,
            period_ns: period_ns()?,
        },
        _ => Shape::Points {
            changes: points(source, file, &lacks)?,
        },
    })
}

fn points(
    source: Source,
    file: &ReferenceFile,
    lacks: &dyn Fn(&str) -> Diagnostic,
) -> Result<Reference, Diagnostic> {
    const NS_PER_S: f64 = 1e9;
    let t_s = file.t_s.as_ref().ok_or_else(|| lacks("t_s"))?;
    let r = file.r.as_ref().ok_or_else(|| lacks("r"))?;
    let (times, values) = (t_s.get_ref().len(), r.get_ref().len());
    if times != values {
        let problem =
            format!("the reference has {times} times in `t_s` and {values} values in `r`");
        return Err(source.fault(r, problem, "give a value for each time"));
    }
    if let Some(bad) = t_s
        .get_ref()
        .iter()
        .find(|t_s| !(**t_s >= 0.0 && **t_s <= 1e6))
    {
        let problem = format!("t_s has {bad}");
        return Err(source.fault(t_s, problem, "give times in s, from 0 to 1000000"));
    }
    let at_ns = |t_s: &f64| (t_s * NS_PER_S).round() as u64;
    let changes = t_s
        .get_ref()
        .iter()
        .map(at_ns)
        .zip(r.get_ref().iter().copied());
    Reference::try_from(changes.collect::<Vec<_>>())
        .map_err(|problem| source.fault(t_s, problem.to_string(), ""))
}
