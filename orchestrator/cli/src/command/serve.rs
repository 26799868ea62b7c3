//! `webloop serve plant|controller`: runs one end, by hand or as a run's child; `play` has the link.
//!
//! A role prints `ready ...` when it can be used, and writes its report to `<role>.json`.

use std::io::{IsTerminal, Read, Write};
use std::path::{Path, absolute};

use anyhow::{Context, anyhow};
use backend::{ControllerRole, PlantRole, start_plant};
use control::Law;
use endpoint::{ControllerSettings, Lease, PageSettings, SampleTime, Surrounded, report};
use plan::Client;
use plan::system::{Design, Loop, System};
use record::file;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::argument::{ServeController, ServePlant};
use crate::exit::{Exit, Failure, Outcome};
use crate::source;

/// Runs a plant until SIGTERM or SIGINT.
pub(crate) fn plant(argument: &ServePlant) -> Outcome {
    let role = plant_role(argument)?;
    let system = system(role.system.as_deref())?;
    let h = role.settings.h;
    let law = told_law(&system, h)?.map(serde_json::to_value);
    let config = ::plant::Config {
        listen: role.listen,
        hosts: role.hosts.clone(),
        settings: role.settings,
        law: law.transpose()?,
        reference: role.reference.clone(),
        out: argument.out.clone(),
        again: role.again,
    };
    let ready = |ready: ::plant::Ready| {
        say_ready(&ready.address.to_string());
        if std::io::stdout().is_terminal() {
            say!(
                "open http://{}/ to see it and to be its controller",
                ready.address
            );
        }
    };
    let around = system.surroundings().unwrap_or_default();
    match &role.program {
        None => {
            let model = at(&system, h)?.plant.stepper_from(system.x0());
            let model = Surrounded::new(model, around, role.seed, role.start_ns);
            let report = ::plant::serve(&config, model, ready)?;
            leave(&argument.out, "plant", &report)
        }
        Some(program) => {
            let program = source::with_command(program, "WEBLOOP_PLANT_RUN")?;
            let hidden = backend::hidden(&absolute(&argument.out)?, None);
            let own = start_plant(&program, system.inputs(), h, role.seed, hidden)
                .map_err(|problem| anyhow!(problem))?;
            let model = Surrounded::new(own.clone(), around, role.seed, role.start_ns);
            let served = ::plant::serve(&config, model, ready);
            if let Some(problem) = own.problem() {
                return Err(anyhow!(problem).into());
            }
            let steps = own.report();
            let report = report::Plant {
                program: Some(steps.clone()),
                ..served?
            };
            leave(&argument.out, "plant", &report)?;
            kept_up(&steps, h)
        }
    }
}

/// Whether a program that is the plant stepped in time, by and large: what is late now and then, the ticks
/// tell.
fn kept_up(steps: &report::PlantProgram, h: SampleTime) -> Outcome {
    if steps.slow * 2 <= steps.steps {
        return Ok(Exit::Fine);
    }
    Err(anyhow!(
        "the plant's program `{}` needed longer than h = {h} for {} of {} steps, and {:.1} ms at the most; make \
         it faster, or h longer",
        steps.run.join(" "),
        steps.slow,
        steps.steps,
        steps.slowest_ns as f64 * 1e-6
    )
    .into())
}

/// Runs a controller for its duration.
pub(crate) fn controller(argument: &ServeController) -> Outcome {
    let (role, system) = controller_role(argument, None)?;
    let config = ::controller::Config {
        plant: format!("http://{}", role.plant),
        settings: role.settings,
        claim: role.claim,
        check: role.check,
        law: law_at(&system, role.settings.h)?.0,
        reference: role.reference,
        start_ns: role.start_ns,
        again: role.again,
        duration_ns: role.duration_ns,
        connections: 1,
        out: argument.out.clone(),
        scheduling: role.scheduling,
    };
    // Its settings are valid. It waits for the plant by itself.
    say_ready(&config.plant);
    let report = ::controller::drive(&config)?;
    leave(&argument.out, "controller", &report)?;
    Ok(if report.interrupted {
        Exit::Interrupted
    } else {
        Exit::Fine
    })
}

/// The plant's settings, from a file or from the options.
fn plant_role(argument: &ServePlant) -> Result<PlantRole, Failure> {
    if let Some(file) = &argument.told.file {
        return read(file);
    }
    let system = source::system(&argument.system)?;
    let settings = argument.settings.at(argument.h).map_err(Failure::usage)?;
    Ok(PlantRole {
        listen: argument.listen,
        hosts: argument.hosts.clone(),
        settings: settings.drawn_by(argument.noise_seed),
        program: source::plant_program(&argument.system, &system),
        seed: argument.noise_seed,
        start_ns: None,
        again: false,
        system: own_text(&system),
        reference: None,
    })
}

/// A controller's settings, from a file or from the options, and its system. For a browser, `page`
/// adds the settings of its page.
pub(crate) fn controller_role(
    argument: &ServeController,
    page: Option<(Client, PageSettings)>,
) -> Result<(ControllerRole, System), Failure> {
    let role = match &argument.told.file {
        Some(file) => read(file)?,
        None => by_options(argument, page)?,
    };
    if role.again && role.start_ns.is_none() {
        return Err(Failure::usage(anyhow!(
            "the settings have `again` without `start_ns`; give the first deadline of the life that was killed"
        )));
    }
    let system = system(role.system.as_deref())?;
    let page = role.page.map_or(Ok(()), |page| page.check(&role.settings));
    let lease = if role.claim {
        Lease::Token
    } else {
        Lease::None
    };
    let checksum = if role.check {
        role.settings.check_checksum()
    } else {
        Ok(())
    };
    role.client
        .check(&role.settings, lease)
        .and(checksum)
        .and(page)
        .and(system.check(&role.settings))
        .map_err(Failure::usage)?;
    Ok((role, system))
}

fn by_options(
    argument: &ServeController,
    page: Option<(Client, PageSettings)>,
) -> Result<ControllerRole, Failure> {
    let system = source::system(&argument.system)?;
    let duration_ns = argument.duration_ns;
    let (r, reference) = match argument.r {
        Some(r) => (r, None),
        None => system
            .reference_over(argument.h, duration_ns)
            .map_err(Failure::usage)?,
    };
    let settings = argument.settings.at(argument.h).map_err(Failure::usage)?;
    Ok(ControllerRole {
        client: page.map(|(client, _)| client).unwrap_or_default(),
        plant: argument.plant,
        settings: ControllerSettings {
            mode: argument.mode,
            r,
            ..settings
        },
        claim: argument.claim,
        check: argument.check,
        scheduling: argument.scheduling,
        page: page.map(|(_, page)| page),
        system: own_text(&system),
        program: None,
        start_ns: argument.start_ns,
        again: false,
        duration_ns,
        reference,
    })
}

/// Maximum bytes of a role's settings: a profile with its traces is the largest of them.
const SETTINGS_BYTES: u64 = 192 << 20;

/// Reads a role's settings from a file, or from standard input for `-`.
pub(crate) fn read<T: DeserializeOwned>(file: &Path) -> Result<T, Failure> {
    let text = if file.as_os_str() == "-" {
        let mut text = String::new();
        let mut input = std::io::stdin().take(SETTINGS_BYTES);
        input.read_to_string(&mut text).map(|_| text)
    } else {
        file::given_text(file, SETTINGS_BYTES)
    };
    let name = file.display();
    let text = text
        .with_context(|| format!("cannot read the settings in {name}"))
        .map_err(Failure::usage)?;
    serde_json::from_str(&text)
        .map_err(|problem| Failure::usage(anyhow!("cannot use the settings in {name}: {problem}")))
}

/// The system of this text, or the paper's if there is none.
fn system(text: Option<&str>) -> Result<System, Failure> {
    let Some(text) = text else {
        return Ok(System::paper());
    };
    System::read(text)
        .map_err(|fault| Failure::usage(anyhow!("the settings' `system`, {}", fault.inside())))
}

fn own_text(system: &System) -> Option<String> {
    system.own_text().map(str::to_owned)
}

/// The loop of a system at a sample time.
pub(crate) fn at(system: &System, h: SampleTime) -> Result<Loop, Failure> {
    system.at(h).map_err(Failure::usage)
}

/// A system's law at a sample time, whatever its plant is.
fn law_at(system: &System, h: SampleTime) -> Result<(Law, Design), Failure> {
    system.law_at(h).map_err(Failure::usage)
}

/// What a controller is told that is not webloop's own code, as one JSON.
pub(crate) fn told(
    role: &ControllerRole,
    system: &System,
    start_ns: Option<u64>,
) -> Result<serde_json::Value, Failure> {
    Ok(serde_json::json!({
        "plant": role.plant,
        "claim": role.claim,
        "settings": role.settings,
        "law": told_law(system, role.settings.h)?,
        "start_ns": start_ns,
        "duration_ns": role.duration_ns,
        "reference": role.reference,
    }))
}

/// The law that a client in another language needs to get; `None` for the paper's, which it has
/// built in.
fn told_law(system: &System, h: SampleTime) -> Result<Option<Design>, Failure> {
    let (_, design) = law_at(system, h)?;
    Ok((!system.is_paper()).then_some(design))
}

/// Prints a line that begins with `ready`, for whoever waits. It is no error if nobody reads it.
pub(crate) fn say_ready(what: &str) {
    let _ = writeln!(crate::console::out(), "ready {what}");
}

pub(crate) fn leave(folder: &Path, role: &str, report: &impl Serialize) -> Outcome {
    let text = serde_json::to_string_pretty(report)? + "\n";
    record::folder::write_whole(&folder.join(format!("{role}.json")), text.as_bytes())?;
    Ok(Exit::Fine)
}
