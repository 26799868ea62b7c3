//! `webloop serve python|browser`: starts the clients that are not webloop's own code, by hand or
//! as a run's child.
//!
//! They close the loop themselves; here they get the same settings as the native client.

use std::convert::Infallible;
use std::fs::File;
use std::process::Command;

use anyhow::anyhow;
use backend::ControllerRole;
use browser::Engine;
use plan::Client;

use crate::argument::{ServeBrowser, ServeController};
use crate::command::serve::{controller_role, leave, say_ready, told};
use crate::exit::{Exit, Failure, Outcome};

/// Replaces this process by the interpreter that runs the controller in Python.
pub(crate) fn python(argument: &ServeController) -> Outcome {
    // Checked here, so that mistakes give the same error texts as with other clients.
    let (role, system) = controller_role(argument, None)?;
    let mut settings = told(&role, &system, role.start_ns)?;
    if role.again {
        settings["again"] = true.into();
    }
    let words = [
        "--settings".as_ref(),
        "-".as_ref(),
        "--out".as_ref(),
        argument.out.as_os_str(),
    ];
    python::run(words, &settings.to_string()).map_or_else(
        |problem| match problem {
            python::Error::Unsupported { .. } => Err(Failure::unsupported(problem)),
            other => Err(other.into()),
        },
        |never: Infallible| match never {},
    )
}

/// Starts a real browser at the plant's page, and watches it until it ends.
pub(crate) fn browser(argument: &ServeBrowser) -> Outcome {
    let is_asked = |client: &Client| client.spec().engine == Some(argument.engine);
    let client = Client::ALL.into_iter().find(is_asked);
    let page = argument
        .page
        .at(argument.controller.h)
        .map_err(Failure::usage)?;
    let page = client.map(|client| (client, page));
    let (role, _) = controller_role(&argument.controller, page)?;
    let (engine, page) = of_page(&role)?;
    let config = ::browser::Config {
        engine,
        plant: role.plant,
        settings: role.settings,
        page,
        start_ns: role.start_ns,
        duration_ns: role.duration_ns,
        scratch: std::env::temp_dir(),
        leash,
        limits: ::browser::Limits::default(),
    };
    let report =
        ::browser::visit(&config, || say_ready(&config.plant.to_string())).map_err(|problem| {
            match problem {
                ::browser::VisitError::Missing(_) => Failure::unsupported(problem),
                other => anyhow!("{}: {other}", other.name()).into(),
            }
        })?;
    leave(&argument.controller.out, "controller", &report)?;
    Ok(if report.interrupted {
        Exit::Interrupted
    } else {
        Exit::Fine
    })
}

/// The browser, and the settings of its page.
fn of_page(role: &ControllerRole) -> Result<(Engine, endpoint::PageSettings), Failure> {
    role.client.spec().engine.zip(role.page).ok_or_else(|| {
        Failure::usage(anyhow!(
            "the settings are not a browser's; give `client` chromium or firefox, and `page`"
        ))
    })
}

/// Makes the browser end when this process does, whatever ends it.
fn leash(command: &mut Command) -> std::io::Result<()> {
    backend::spawn::bind(command, None::<&File>)
}
