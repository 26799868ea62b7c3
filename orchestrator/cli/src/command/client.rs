//! `webloop serve python|browser`: the clients that are not webloop's own code, by hand or as a
//! run's child.
//!
//! What they do is theirs; here they are started with what the native one is started with.

use std::convert::Infallible;
use std::fs::File;
use std::process::Command;

use anyhow::anyhow;
use endpoint::PageSettings;

use crate::argument::{ServeBrowser, ServeController};
use crate::command::serve::{leave, ns, say_ready, settings, told};
use crate::exit::{Exit, Failure, Outcome};
use crate::source;

/// Becomes the interpreter that runs the controller in Python.
pub(crate) fn python(argument: &ServeController) -> Outcome {
    let system = source::system(&argument.system)?;
    // Checked here, so that mistakes are told in the same words.
    let settings = settings(argument, &system)?;
    let law = told(&system, argument.h)?.map(|law| serde_json::to_string(&law));
    python::run(words(argument, settings.r, law.transpose()?)).map_or_else(
        |problem| match problem {
            python::Error::Unsupported { .. } => Err(Failure::unsupported(problem)),
            other => Err(other.into()),
        },
        |never: Infallible| match never {},
    )
}

/// The options as the controller in Python has them.
fn words(argument: &ServeController, r: f64, law: Option<String>) -> Vec<String> {
    let ServeController {
        plant,
        h,
        mode,
        r: _,
        duration,
        outstanding,
        transport,
        connection,
        schedule,
        integrate,
        late,
        timeout,
        system: _,
        start_ns,
        out,
    } = argument;
    let mut words = vec![
        format!("--plant={plant}"),
        format!("--h={h}"),
        format!("--mode={mode}"),
        format!("--r={r:?}"),
        format!("--duration={}ns", duration.as_nanos()),
        format!("--outstanding={outstanding}"),
        format!("--transport={transport}"),
        format!("--connection={connection}"),
        format!("--schedule={schedule}"),
        format!("--integrate={integrate}"),
        format!("--late={late}"),
        format!("--timeout={}ns", timeout.as_nanos()),
        format!("--out={}", out.display()),
    ];
    words.extend(law.map(|law| format!("--law={law}")));
    words.extend(start_ns.map(|start_ns| format!("--start-ns={start_ns}")));
    words
}

/// Starts a real browser at the plant's page, and watches it to its end.
pub(crate) fn browser(argument: &ServeBrowser) -> Outcome {
    let controller = &argument.controller;
    let system = source::system(&controller.system)?;
    let config = ::browser::Config {
        engine: argument.engine,
        plant: controller.plant,
        settings: settings(controller, &system)?,
        page: PageSettings {
            thread: argument.thread,
            sender: argument.sender,
            timer: argument.timer,
            floor_ns: u64::try_from(argument.timer_floor.as_nanos())
                .map_err(|_| Failure::usage(anyhow!("--timer-floor is below zero")))?,
        },
        start_ns: controller.start_ns,
        duration_ns: ns("duration", controller.duration)?,
        scratch: std::env::temp_dir(),
        leash,
        limits: ::browser::Limits::default(),
    };
    if let Some(problem) = config.page.conflict(&config.settings) {
        return Err(Failure::usage(anyhow!("{problem}")));
    }
    let report =
        ::browser::visit(&config, || say_ready(&config.plant.to_string())).map_err(|problem| {
            match problem {
                ::browser::VisitError::Missing(_) => Failure::unsupported(problem),
                other => anyhow!("{}: {other}", other.name()).into(),
            }
        })?;
    leave(&controller.out, "controller", &report)?;
    Ok(match report.interrupted {
        true => Exit::Interrupted,
        false => Exit::Fine,
    })
}

/// Ends the browser with this process, whatever ends that.
fn leash(command: &mut Command) -> std::io::Result<()> {
    backend::spawn::bind(command, None::<&File>)
}
