//! Laws of times: rejects parameters that a law cannot have.

use toml::Spanned;

use crate::file::LawFile;
use crate::finding::Findings;
use crate::law::Form;

/// Shapes of a gamma law. Above them it is practically a constant, below them nearly all its draws are zero.
const GAMMA_SHAPES: std::ops::RangeInclusive<f64> = 1e-2..=1e6;
/// The same for the two shapes of a beta law.
const BETA_SHAPES: std::ops::RangeInclusive<f64> = 1e-2..=1e6;

/// A law's form; `None` after an error, which is recorded.
pub(super) fn form(file: &Spanned<LawFile>, findings: &mut Findings<'_>) -> Option<Form> {
    match file.get_ref() {
        LawFile::Constant { value } => {
            let value_ns = findings.duration_ns(value)?;
            Some(Form::Constant { value_ns })
        }
        LawFile::Uniform { min, max } => {
            let min_ns = findings.duration_ns(min);
            let max_ns = findings.duration_ns(max);
            let (min_ns, max_ns) = (min_ns?, max_ns?);
            ordered(min_ns, max, max_ns, findings)?;
            Some(Form::Uniform { min_ns, max_ns })
        }
        LawFile::Normal { mean, sd } => {
            let mean_ns = findings.duration_ns(mean);
            let sd_ns = findings.positive_ns(sd);
            Some(Form::Normal {
                mean_ns: mean_ns?,
                sd_ns: sd_ns?,
            })
        }
        LawFile::Exponential { mean } => {
            let mean_ns = findings.positive_ns(mean)?;
            Some(Form::Exponential { mean_ns })
        }
        LawFile::Gamma { mean, sd } => gamma(mean, sd, findings),
        LawFile::Beta { min, max, mean, sd } => beta([min, max, mean, sd], findings),
        LawFile::Pareto { scale, shape } => pareto(scale, shape, findings),
        LawFile::Table(points) => table(points, file, findings),
    }
}

fn gamma(
    mean: &Spanned<String>,
    sd: &Spanned<String>,
    findings: &mut Findings<'_>,
) -> Option<Form> {
    let mean_ns = findings.positive_ns(mean);
    let sd_ns = findings.positive_ns(sd);
    let (mean_ns, sd_ns) = (mean_ns?, sd_ns?);
    let shape = (mean_ns / sd_ns) * (mean_ns / sd_ns);
    if !GAMMA_SHAPES.contains(&shape) {
        let message = format!("the gamma law's shape (mean/sd)^2 is {shape:.3e}");
        let remedy = "keep sd between a thousandth of the mean and ten times it";
        findings.error(sd.span(), message, remedy);
        return None;
    }
    Some(Form::Gamma { mean_ns, sd_ns })
}

fn beta([min, max, mean, sd]: [&Spanned<String>; 4], findings: &mut Findings<'_>) -> Option<Form> {
    let min_ns = findings.duration_ns(min);
    let max_ns = findings.duration_ns(max);
    let mean_ns = findings.duration_ns(mean);
    let sd_ns = findings.positive_ns(sd);
    let (min_ns, max_ns, mean_ns, sd_ns) = (min_ns?, max_ns?, mean_ns?, sd_ns?);
    ordered(min_ns, max, max_ns, findings)?;
    if mean_ns <= min_ns || mean_ns >= max_ns {
        let message = "the mean is not between min and max";
        let remedy = "correct mean, min or max";
        findings.error(mean.span(), message, remedy);
        return None;
    }
    let most_ns = ((mean_ns - min_ns) * (max_ns - mean_ns)).sqrt();
    let total = most_ns * most_ns / (sd_ns * sd_ns) - 1.0;
    let share = (mean_ns - min_ns) / (max_ns - min_ns);
    let shapes = [share * total, (1.0 - share) * total];
    if !shapes.iter().all(|shape| BETA_SHAPES.contains(shape)) {
        let message = format!(
            "a beta law with this min, max and mean needs an sd below {:.3} ms",
            most_ns / 1e6
        );
        let remedy = "write a smaller sd, though not a thousandth of the range";
        findings.error(sd.span(), message, remedy);
        return None;
    }
    Some(Form::Beta {
        min_ns,
        max_ns,
        mean_ns,
        sd_ns,
    })
}

fn pareto(
    scale: &Spanned<String>,
    shape: &Spanned<f64>,
    findings: &mut Findings<'_>,
) -> Option<Form> {
    let scale_ns = findings.positive_ns(scale);
    let exponent = *shape.get_ref();
    // Not "<= 0", since NaN must be rejected too.
    if !(exponent > 0.0 && exponent.is_finite()) {
        let message = format!("the Pareto law's shape is {exponent}");
        let remedy = "write more than zero";
        findings.error(shape.span(), message, remedy);
        return None;
    }
    Some(Form::Pareto {
        scale_ns: scale_ns?,
        shape: exponent,
    })
}

fn table(
    points: &[(Spanned<String>, Spanned<String>)],
    file: &Spanned<LawFile>,
    findings: &mut Findings<'_>,
) -> Option<Form> {
    let mut resolved: Vec<(f64, f64)> = Vec::with_capacity(points.len());
    for (share, value) in points {
        let p = findings.share(share);
        let value_ns = findings.duration_ns(value);
        let (p, value_ns) = (p?, value_ns?);
        if let Some(&(last_p, last_ns)) = resolved.last() {
            if p <= last_p {
                let message = "the table's shares do not rise";
                findings.error(share.span(), message, "sort the points by share");
                return None;
            }
            if value_ns < last_ns {
                let message = "the table's times fall";
                let remedy = "a quantile function never falls: correct the times";
                findings.error(value.span(), message, remedy);
                return None;
            }
        }
        resolved.push((p, value_ns));
    }
    let ends = (resolved.first(), resolved.last());
    if !matches!(ends, (Some(&(0.0, _)), Some(&(1.0, _)))) {
        let message = "the table does not go from 0% to 100%";
        let remedy = "begin with [\"0%\", least time] and end with [\"100%\", greatest time]";
        findings.error(file.span(), message, remedy);
        return None;
    }
    Some(Form::Table { points: resolved })
}

fn ordered(
    min_ns: f64,
    max: &Spanned<String>,
    max_ns: f64,
    findings: &mut Findings<'_>,
) -> Option<()> {
    if min_ns < max_ns {
        return Some(());
    }
    findings.error(max.span(), "max is not above min", "write a greater max");
    None
}
