//! The actuator's limits, and a law's behaviour at them.

use control::{AntiWindup, Saturation};
use text::Diagnostic;
use toml::Spanned;

use crate::system::fault::Source;
use crate::system::file::LimitsFile;

/// Reads the limits for the law of this name: anti-windup is only for laws with an integral.
pub(crate) fn read(
    source: Source,
    asked: &Spanned<LimitsFile>,
    law: &str,
) -> Result<Saturation, Diagnostic> {
    let file = asked.get_ref();
    let has_integral = matches!(law, "pid" | "smith");
    let anti_windup = match (&file.anti_windup, &file.gain) {
        (Some(word), _) if !has_integral => {
            let problem = format!("law `{law}` has no integrator, so no anti-windup");
            return Err(source.fault(word, problem, "leave anti_windup out"));
        }
        (None, None) if has_integral => AntiWindup::Conditional,
        (None, None) => AntiWindup::Off,
        (Some(word), gain) => match (word.get_ref().as_str(), gain) {
            ("off", None) => AntiWindup::Off,
            ("conditional", None) => AntiWindup::Conditional,
            ("back-calculation", Some(gain)) => AntiWindup::BackCalculation {
                gain_per_s: source.positive("gain", gain)?,
            },
            ("back-calculation", None) => {
                let remedy = "give the tracking gain in 1/s, such as gain = 10.0";
                return Err(source.fault(word, "back-calculation has no gain", remedy));
            }
            _ => {
                let problem = format!("anti_windup is `{}`", word.get_ref());
                let remedy = "choose off, conditional, or back-calculation with a gain";
                return Err(source.fault(word, problem, remedy));
            }
        },
        (None, Some(gain)) => {
            let remedy = "write anti_windup = \"back-calculation\", or leave gain out";
            return Err(source.fault(gain, "`gain` needs anti_windup back-calculation", remedy));
        }
    };
    let limits = Saturation {
        min: match &file.min {
            Some(min) => source.finite("min", min)?,
            None => f64::NEG_INFINITY,
        },
        max: match &file.max {
            Some(max) => source.finite("max", max)?,
            None => f64::INFINITY,
        },
        anti_windup,
    };
    if limits.min < limits.max {
        Ok(limits)
    } else {
        Err(source.fault(
            asked,
            format!("the limits from {} to {} are empty", limits.min, limits.max),
            "give a min below max",
        ))
    }
}
