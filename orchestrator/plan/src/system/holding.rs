//! What of a plant's outputs counts as holding: the band about the reference, limits whose crossing loses the
//! loop, and how much overshoot and effort is asked for at the most.
//!
//! It is what the system's text says; what follows for a run is judged elsewhere.

use text::Diagnostic;
use toml::Spanned;

use crate::system::fault::Source;
use crate::system::file::{BandFile, BandsFile, PlantFile, Rows};
use crate::system::plant::PlantModel;

/// What is asked of a loop with this plant. By default nothing is said, and the verdict's own rule decides.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Holding {
    /// The band of each output, from the first on; those beyond its end have none.
    pub band: Vec<Band>,
    /// The least and the greatest value of each output, from the first on; beyond them the loop is lost.
    pub limits: Vec<(f64, f64)>,
    /// The greatest overshoot, % of the step.
    pub overshoot_pct: Option<f64>,
    /// The greatest magnitude of the first input, in units of u.
    pub effort: Option<f64>,
}

/// How far from its reference an output may be and count as there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Band {
    /// So far, in units of y.
    Absolute(f64),
    /// This part of the step, from 0 to 1.
    OfStep(f64),
}

impl Holding {
    /// The band of an output, 0 the first; `None` if the text gives none.
    #[must_use]
    pub fn band_of(&self, output: usize) -> Option<Band> {
        self.band.get(output).copied()
    }

    /// The limits of an output, 0 the first; `None` if the text gives none.
    #[must_use]
    pub fn limits_of(&self, output: usize) -> Option<(f64, f64)> {
        self.limits.get(output).copied()
    }

    /// What a reader of the system should know before a run: a band that noise crosses, a step that is small
    /// beside the limits, an output that begins beyond them. `r` and `y0` are the first output's, `noise` the
    /// sensor's standard deviation. Sentences; empty if there is nothing to say.
    #[must_use]
    pub fn warnings(&self, r: f64, y0: f64, noise: f64) -> Vec<String> {
        let step = (r - y0).abs();
        let mut found = Vec::new();
        let band = match self.band_of(0) {
            Some(Band::Absolute(band)) => band,
            Some(Band::OfStep(part)) => part * step,
            None => 0.02 * step,
        };
        if noise > 0.0 && band < noise {
            found.push(format!(
                "the band of {band} is narrower than the sensor's noise of {noise}, which then decides how \
                 wide it is; give a wider `band`"
            ));
        }
        if let Some((least, greatest)) = self.limits_of(0) {
            if step > 0.0 && step < (greatest - least) / 100.0 && self.band_of(0).is_none() {
                found.push(format!(
                    "the step of {step} is less than a hundredth of the limits from {least} to {greatest}, so \
                     a band of 2 % of it asks for very much; give a `band` in units of y"
                ));
            }
            if !(least..=greatest).contains(&y0) {
                found.push(format!(
                    "y is {y0} at the start, beyond the limits from {least} to {greatest}: the loop is lost \
                     before it begins"
                ));
            }
            if !(least..=greatest).contains(&r) {
                found.push(format!(
                    "r is {r}, beyond the limits from {least} to {greatest}: a loop that follows it is lost"
                ));
            }
        }
        if step == 0.0 && self.band_of(0).is_none() {
            found.push(
                "y begins at r, so there is no step to measure a band by: any error that does not grow counts \
                 as holding; give a `band` in units of y"
                    .to_owned(),
            );
        }
        found
    }
}

/// Reads band, limits, overshoot and effort of a plant.
pub(crate) fn read(
    source: Source,
    asked: &Spanned<PlantFile>,
    plant: &PlantModel,
) -> Result<Holding, Diagnostic> {
    let file = asked.get_ref();
    // The outputs of a program are not known here.
    let most = plant
        .linear()
        .map_or(control::Signals::MOST, |plant| plant.model.outputs());
    Ok(Holding {
        band: match &file.band {
            Some(asked) => bands(source, asked, most)?,
            None => Vec::new(),
        },
        limits: match &file.limits {
            Some(asked) => limits(source, asked, most)?,
            None => Vec::new(),
        },
        overshoot_pct: match &file.overshoot {
            Some(asked) => Some(100.0 * part(source, asked)?),
            None => None,
        },
        effort: match &file.effort {
            Some(asked) => Some(source.positive("effort", asked)?),
            None => None,
        },
    })
}

fn bands(source: Source, asked: &Spanned<BandsFile>, most: usize) -> Result<Vec<Band>, Diagnostic> {
    let given = match asked.get_ref() {
        BandsFile::One(one) => std::slice::from_ref(one),
        BandsFile::List(list) => list,
    };
    counted(source, asked, "band", given.len(), most)?;
    given.iter().map(|one| band(source, asked, one)).collect()
}

fn band(source: Source, at: &Spanned<BandsFile>, given: &BandFile) -> Result<Band, Diagnostic> {
    let wrong = |shown: String| {
        source.fault(
            at,
            format!("band is {shown}"),
            "give a number above zero in units of y, such as 0.01, or a share of the step, such as \"2%\"",
        )
    };
    match given {
        BandFile::Absolute(band) if band.is_finite() && *band > 0.0 => Ok(Band::Absolute(*band)),
        BandFile::Absolute(band) => Err(wrong(band.to_string())),
        BandFile::Share(text) => share(text)
            .map(Band::OfStep)
            .ok_or_else(|| wrong(format!("`{text}`"))),
    }
}

/// A share above zero with its sign, such as `50%`, as a part of 1.
fn part(source: Source, asked: &Spanned<String>) -> Result<f64, Diagnostic> {
    share(asked.get_ref()).ok_or_else(|| {
        let problem = format!("overshoot is `{}`", asked.get_ref());
        source.fault(asked, problem, "give a share of the step, such as \"50%\"")
    })
}

fn share(text: &str) -> Option<f64> {
    let percent: f64 = text.trim().strip_suffix('%')?.trim().parse().ok()?;
    (percent.is_finite() && percent > 0.0).then_some(percent / 100.0)
}

fn limits(
    source: Source,
    asked: &Spanned<Rows>,
    most: usize,
) -> Result<Vec<(f64, f64)>, Diagnostic> {
    const REMEDY: &str = "give the least and the greatest y, such as limits = [-0.3, 0.3], or a list of such \
                          pairs, one for each output; -inf and inf are no limit";
    let pairs: Vec<&[f64]> = match asked.get_ref() {
        Rows::List(pair) => vec![pair],
        Rows::Rows(pairs) => pairs.iter().map(Vec::as_slice).collect(),
    };
    counted(source, asked, "limits", pairs.len(), most)?;
    let pair = |pair: &[f64]| match pair {
        [least, greatest] if least < greatest => Ok((*least, *greatest)),
        [least, greatest] => {
            let problem = format!("the limits from {least} to {greatest} are empty");
            Err(source.fault(asked, problem, REMEDY))
        }
        others => {
            let problem = format!("limits has {} numbers", others.len());
            Err(source.fault(asked, problem, REMEDY))
        }
    };
    pairs.into_iter().map(pair).collect()
}

fn counted<T>(
    source: Source,
    at: &Spanned<T>,
    field: &str,
    given: usize,
    most: usize,
) -> Result<(), Diagnostic> {
    if (1..=most).contains(&given) {
        return Ok(());
    }
    let problem = format!(
        "{field} is for {}, and the plant has {}",
        outputs(given),
        outputs(most)
    );
    Err(source.fault(
        at,
        problem,
        "give one for each output, or for the first alone",
    ))
}

fn outputs(count: usize) -> &'static str {
    match count {
        0 => "no output",
        1 => "one output",
        _ => "two outputs",
    }
}

#[cfg(test)]
mod tests {
    use crate::system::System;

    use super::*;

    fn holding(lines: &str) -> Result<Holding, String> {
        let text = format!(
            "name = \"mine\"\n[plant]\nnum = [1.0]\nden = [1.0, 1.0]\n{lines}\n[controller]\nlaw = \"pid\"\nkp = 1.0\n"
        );
        let read = System::read(&text).map_err(|fault| fault.to_string());
        read.map(|system| system.holding().clone())
    }

    #[test]
    fn band_limits_overshoot_and_effort_are_read_and_absent_by_default() {
        assert_eq!(holding(""), Ok(Holding::default()));
        let all = holding("band = \"5%\"\nlimits = [-0.3, inf]\novershoot = \"50%\"\neffort = 2.0");
        let expected = Holding {
            band: vec![Band::OfStep(0.05)],
            limits: vec![(-0.3, f64::INFINITY)],
            overshoot_pct: Some(50.0),
            effort: Some(2.0),
        };
        assert_eq!(all, Ok(expected));
        assert_eq!(
            holding("band = 0.01").map(|of| of.band_of(0)),
            Ok(Some(Band::Absolute(0.01)))
        );
    }

    #[test]
    fn what_is_no_band_and_no_limit_is_refused_with_its_remedy() {
        for (line, says) in [
            ("band = 0", "band is 0; give a number above zero"),
            ("band = \"2\"", "band is `2`; give a number above zero"),
            (
                "band = [0.1, 0.1]",
                "band is for two outputs, and the plant has one output",
            ),
            ("limits = [1.0, -1.0]", "the limits from 1 to -1 are empty"),
            ("limits = [1.0]", "limits has 1 numbers"),
            ("limits = [nan, 1.0]", "are empty"),
            (
                "overshoot = \"half\"",
                "overshoot is `half`; give a share of the step",
            ),
            ("effort = -1.0", "effort is -1; give a number above zero"),
        ] {
            let error = holding(line).expect_err(line);
            assert!(error.contains(says), "{line}: {error}");
        }
    }

    #[test]
    fn a_band_below_the_noise_and_a_step_below_the_limits_are_warned_of() {
        let warned = |of: &Holding, r, y0, noise| of.warnings(r, y0, noise).join(" ");
        let plain = Holding::default();
        assert_eq!(warned(&plain, 1.0, 0.0, 0.001), "");
        assert!(warned(&plain, 0.0, 0.05, 0.002).contains("narrower than the sensor's noise"));
        assert!(warned(&plain, 0.0, 0.0, 0.0).contains("no step"));
        let limited = Holding {
            limits: vec![(-1.0, 1.0)],
            ..Holding::default()
        };
        assert!(warned(&limited, 0.0, 0.009, 0.0).contains("less than a hundredth"));
        assert!(warned(&limited, 0.0, 1.5, 0.0).contains("lost before it begins"));
        assert!(warned(&limited, 2.0, 0.0, 0.0).contains("a loop that follows it is lost"));
        let banded = Holding {
            band: vec![Band::Absolute(0.01)],
            ..limited
        };
        assert_eq!(warned(&banded, 0.0, 0.009, 0.0), "");
    }
}
