//! What surrounds a plant's model, in a system's text.

use endpoint::{Disturbance, Surroundings};
use text::Diagnostic;
use toml::Spanned;

use crate::system::fault::Source;
use crate::system::file::PlantFile;

/// Reads actuator, disturbance and sensor; `None` if the plant has none of them.
pub(crate) fn read(
    source: Source,
    asked: &Spanned<PlantFile>,
) -> Result<Option<Surroundings>, Diagnostic> {
    let file = asked.get_ref();
    let is_bare = file.actuator.is_none() && file.disturbance.is_none() && file.sensor.is_none();
    // A program may begin anywhere too: what falls by itself would have fallen before the loop.
    let stands_still = file.x0.is_some() || file.run.is_some() || file.image.is_some();
    if is_bare && !stands_still {
        return Ok(None);
    }
    let mut surroundings = Surroundings {
        stands_still,
        ..Surroundings::default()
    };
    if let Some(asked) = &file.actuator {
        let (least, greatest) = &mut surroundings.limits;
        if let Some(min) = &asked.get_ref().min {
            *least = source.finite("min", min)?;
        }
        if let Some(max) = &asked.get_ref().max {
            *greatest = source.finite("max", max)?;
        }
        if *least >= *greatest {
            let problem = format!("the actuator's limits from {least} to {greatest} are empty");
            return Err(source.fault(asked, problem, "give a min below max"));
        }
        if let Some(rate) = &asked.get_ref().rate {
            surroundings.rate_per_s = source.positive("rate", rate)?;
        }
    }
    if let Some(asked) = &file.disturbance {
        let asked = asked.get_ref();
        surroundings.disturbance = Some(Disturbance {
            size: source.finite("size", &asked.size)?,
            from_ns: match &asked.from {
                Some(text) => source.span_ns(text)?,
                None => 0,
            },
        });
    }
    if let Some(asked) = &file.sensor {
        let asked = asked.get_ref();
        if let Some(noise) = &asked.noise {
            surroundings.noise = source.positive("noise", noise)?;
        }
        if let Some(resolution) = &asked.resolution {
            surroundings.resolution = source.positive("resolution", resolution)?;
        }
    }
    Ok(Some(surroundings))
}
