//! `webloop serve plant|controller`: one end, by hand or as a run's child; `play` has the link.
//!
//! A role prints `ready ...` when it can be used, and leaves its report as `<role>.json`.

use std::io::Write;
use std::path::Path;

use ::system::{Design, Loop, System};
use anyhow::anyhow;
use endpoint::{ControllerSettings, PlantSettings, SampleTime, TickNoise};
use jiff::SignedDuration;
use serde::Serialize;

use crate::argument::{ServeController, ServePlant};
use crate::exit::{Exit, Failure, Outcome};
use crate::source;

/// Runs a plant until SIGTERM or SIGINT.
pub(crate) fn plant(argument: &ServePlant) -> Outcome {
    let system = source::system(&argument.system)?;
    let law = told(&system, argument.h)?.map(serde_json::to_value);
    let config = ::plant::Config {
        listen: argument.listen,
        settings: PlantSettings {
            h: argument.h,
            late: argument.late,
            hold: argument.hold,
            tick_noise: argument.tick_noise.map(|law| TickNoise {
                law,
                seed: argument.noise_seed,
            }),
        },
        plant: system.plant().clone(),
        law: law.transpose()?,
        out: argument.out.clone(),
        fifo: true,
    };
    let report = ::plant::serve(&config, |ready| say_ready(&ready.address.to_string()))?;
    leave(&argument.out, "plant", &report)
}

/// Runs a controller for its duration.
pub(crate) fn controller(argument: &ServeController) -> Outcome {
    let system = source::system(&argument.system)?;
    let config = ::controller::Config {
        plant: format!("http://{}", argument.plant),
        settings: settings(argument, &system)?,
        law: at(&system, argument.h)?.law,
        start_ns: argument.start_ns,
        duration_ns: ns("duration", argument.duration)?,
        connections: 1,
        out: argument.out.clone(),
        fifo: true,
    };
    // Its arguments are fine; the plant it waits for by itself.
    say_ready(&config.plant);
    let report = ::controller::drive(&config)?;
    leave(&argument.out, "controller", &report)?;
    Ok(match report.interrupted {
        true => Exit::Interrupted,
        false => Exit::Fine,
    })
}

/// How a client sends, whichever it is.
pub(crate) fn settings(
    argument: &ServeController,
    system: &System,
) -> Result<ControllerSettings, Failure> {
    let settings = ControllerSettings {
        mode: argument.mode,
        h: argument.h,
        r: argument.r.unwrap_or(system.r()),
        outstanding: argument.outstanding,
        transport: argument.transport,
        connection: argument.connection,
        schedule: argument.schedule,
        integrate: argument.integrate,
        late: argument.late,
        timeout_ns: ns("timeout", argument.timeout)?,
    };
    match settings.conflict() {
        Some(why) => Err(Failure::usage(anyhow!(
            "--transport {} with --connection {}: {why}",
            settings.transport,
            settings.connection
        ))),
        None => Ok(settings),
    }
}

/// A system at a sample time.
pub(crate) fn at(system: &System, h: SampleTime) -> Result<Loop, Failure> {
    system.at(h).map_err(Failure::usage)
}

/// The law that a client in another language has to be told: the paper's is what it follows by
/// itself.
pub(crate) fn told(system: &System, h: SampleTime) -> Result<Option<Design>, Failure> {
    let design = at(system, h)?.design;
    Ok((!system.is_paper()).then_some(design))
}

/// For whoever waits: a line that begins with `ready`. That nobody reads it is no error.
pub(crate) fn say_ready(what: &str) {
    let _ = writeln!(std::io::stdout(), "ready {what}");
}

pub(crate) fn leave(folder: &Path, role: &str, report: &impl Serialize) -> Outcome {
    let text = serde_json::to_string_pretty(report)? + "\n";
    backend::write_whole(&folder.join(format!("{role}.json")), text.as_bytes())?;
    Ok(Exit::Fine)
}

pub(crate) fn ns(name: &str, duration: SignedDuration) -> Result<u64, Failure> {
    u64::try_from(duration.as_nanos())
        .ok()
        .filter(|ns| *ns > 0)
        .ok_or_else(|| {
            Failure::usage(anyhow!(
                "--{name} is {duration:#}; give a time above zero, like 5s"
            ))
        })
}
