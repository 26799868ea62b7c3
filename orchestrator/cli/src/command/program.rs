//! `webloop serve program`: runs a controller of one's own by the contract of docs/contract.md, by hand or as
//! a run's child. `serve first` is the first process of its PID namespace.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, absolute};
use std::process::ExitCode;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use anyhow::{Context, anyhow};
use backend::ControllerRole;
use clock::now::now_ns;
use endpoint::report::Own;
use plan::system::System;
use process::program::{Ended, OWN, Supervised, supervise};

use crate::argument::{ServeFirst, ServeProgram};
use crate::command::serve::{controller_role, leave, say_ready, told};
use crate::exit::{Exit, Failure, Outcome};
use crate::{source, stop};

/// The start of a program that is started by hand is after this time.
const START_AHEAD_NS: u64 = 1_000_000_000;

/// Exit code of a program that does not support what it was told.
const UNSUPPORTED: i32 = 127;

/// Most bytes of answers that a program may leave unread: some fifty answers that arrive at once, behind a
/// stall of the link, are below.
const UNREAD_BYTES: u64 = 65_536;

/// How much earlier than its time a program may end, beside two h: its last message may come before.
const EARLY_SHARE: f64 = 0.05;

/// Runs a program, and says how it kept the contract.
pub(crate) fn program(argument: &ServeProgram) -> Outcome {
    let stop = stop::told_to_end()?;
    let (role, system) = controller_role(&argument.controller, None)?;
    let run = match &role.program {
        Some(program) => &source::with_command(program, "WEBLOOP_CONTROLLER_RUN")?.run,
        None => &argument.run,
    };
    if run.is_empty() {
        return Err(Failure::usage(anyhow!(
            "there is no program to run; give it behind --, like `webloop serve program -- ./mine`"
        )));
    }
    let start_ns = role.start_ns.unwrap_or_else(|| now_ns() + START_AHEAD_NS);
    let stop_ns = start_ns.saturating_add(role.duration_ns);
    let out = absolute(&argument.controller.out)?;
    let supervised = Supervised {
        run,
        environment: environment(&role, &system, start_ns, &out)?,
        plant_port: role.plant.port(),
        start_ns,
        stop_ns,
        hidden: backend::hidden(&out, Some(&out.join(OWN))),
    };
    let ready = || say_ready(&format!("http://{}", role.plant));
    let ended = supervise(&supervised, ready, &stop).map_err(|problem| {
        let is_forbidden = problem.kind() == io::ErrorKind::PermissionDenied;
        let error = anyhow!(problem).context(format!("`{}` cannot be run", run.join(" ")));
        if is_forbidden {
            Failure::unsupported(error)
        } else {
            error.into()
        }
    })?;
    let is_early = ended.t_ns < stop_ns;
    let report = Own {
        client: role.client.to_string(),
        run: run.clone(),
        start_ns,
        stop_ns,
        end_ns: ended.t_ns,
        code: ended.code,
        interrupted: is_early && ended.is_told,
        killed: ended.is_killed,
        unread_bytes: ended.unread_bytes,
    };
    leave(&argument.controller.out, "controller", &report)?;
    if report.interrupted {
        return Ok(Exit::Interrupted);
    }
    kept(&ended, &role, stop_ns)
}

/// Whether it kept the contract, as far as its process shows.
fn kept(ended: &Ended, role: &ControllerRole, stop_ns: u64) -> Outcome {
    let early_ns = stop_ns.saturating_sub(ended.t_ns);
    let allowed_ns = 2 * role.settings.h.ns() + (EARLY_SHARE * role.duration_ns as f64) as u64;
    let problem = match ended.code {
        UNSUPPORTED => {
            return Err(Failure::unsupported(anyhow!(
                "the program does not support what it was told (exit code 127)"
            )));
        }
        _ if ended.is_killed => {
            "the program did not end within 1 s of SIGTERM, and was killed".to_owned()
        }
        code if code != 0 && !ended.is_told => match code - 128 {
            signal @ 1.. => format!("the program was ended by signal {signal}"),
            _ => format!("the program ended with exit code {code}"),
        },
        _ if early_ns > allowed_ns => format!(
            "the program ended {:.1} s before its time",
            early_ns as f64 * 1e-9
        ),
        _ if ended.unread_bytes > UNREAD_BYTES => format!(
            "the program left {} bytes of answers unread",
            ended.unread_bytes
        ),
        _ => return Ok(Exit::Fine),
    };
    Err(anyhow!(problem).into())
}

/// What the program is told, beside what is in this process's own environment.
fn environment(
    role: &ControllerRole,
    system: &System,
    start_ns: u64,
    out: &Path,
) -> Result<Vec<(&'static str, OsString)>, Failure> {
    let settings = &role.settings;
    let own = out.join(OWN);
    fs::create_dir_all(&own).with_context(|| format!("cannot make {}", own.display()))?;
    let told = told(role, system, Some(start_ns))?;
    let file = own.join("settings.json");
    record::folder::write_whole(&file, format!("{told:#}\n").as_bytes())?;
    let seconds = |ns: u64| Duration::from_nanos(ns).as_secs_f64();
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH)?.as_secs_f64();
    let ahead_s = seconds(start_ns.saturating_sub(now_ns()));
    Ok(vec![
        ("WEBLOOP_PLANT", format!("http://{}", role.plant).into()),
        ("WEBLOOP_MODE", settings.mode.to_string().into()),
        (
            "WEBLOOP_H_S",
            format!("{:?}", seconds(settings.h.ns())).into(),
        ),
        ("WEBLOOP_R", format!("{:?}", settings.r).into()),
        (
            "WEBLOOP_START",
            format!("{:.6}", since_1970 + ahead_s).into(),
        ),
        ("WEBLOOP_START_NS", start_ns.to_string().into()),
        (
            "WEBLOOP_DURATION_S",
            format!("{:?}", seconds(role.duration_ns)).into(),
        ),
        ("WEBLOOP_OUT", own.into_os_string()),
        ("WEBLOOP_SETTINGS", file.into_os_string()),
    ])
}

/// Runs the first process beside a program.
pub(crate) fn first(argument: &ServeFirst) -> ExitCode {
    match process::first::run(&argument.run, argument.not_before_ns) {
        Ok(code) => ExitCode::from(code),
        Err(problem) => {
            say!("webloop: cannot wait for the program: {problem}");
            ExitCode::FAILURE
        }
    }
}
