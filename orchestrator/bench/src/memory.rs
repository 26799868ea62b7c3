//! Memory: what is resident at rest, and what a message under way takes at both ends.
//!
//! The plant stands still for some seconds, stopped by a signal, so the controller waits as it does for a link that
//! stands still: each message opens a connection of its own, which the plant takes in once it goes on. What both
//! processes had resident at the most, less what they had before, is what these messages took.

use std::process::Command;
use std::thread;
use std::time::Duration;

use endpoint::MessageRow;
use record::rows;
use shaper::{CONTROLLER_INTERFACE, Namespace, PLANT_INTERFACE, join};

use crate::comparison::{Bound, Table, goal};
use crate::contender::{Contender, Lack, Measured};
use crate::context::Context;
use crate::role::{Process, Role};

pub(crate) const TABLE: Table = Table {
    about: "memory at rest, and of a message under way",
    base: None,
    processors: None,
    contenders: &[
        Contender::webloop("plant and controller", ends),
        Contender::webloop("link", link),
    ],
    goals: &[
        goal(
            "plant and controller",
            "message_kb",
            None,
            Bound::AtMost(15.0),
        ),
        goal("link", "idle_mb", None, Bound::AtMost(10.0)),
    ],
};

/// How long a role is given to come to rest, or to take in what waits.
const REST: Duration = Duration::from_millis(1000);

fn ends(context: &Context<'_>) -> Result<Measured, Lack> {
    /// At 1 kHz fewer messages than the plant accepts connections at once, all before they are given up.
    const STILL: Duration = Duration::from_secs(3);
    let plant = Role::plant(context, "1ms", &context.folder.join("plant"))?;
    let folder = context.folder.join("controller");
    let mut command = Command::new(&context.programs.webloop);
    command
        .args(["serve", "controller", "--h", "1ms", "--duration", "30s"])
        .args(["--plant", &plant.address.to_string(), "--out"])
        .arg(&folder);
    let controller = Process::start(&mut command, None)?;
    thread::sleep(REST);
    let rest_kb = plant.process.resident_kb()? + controller.resident_kb()?;
    let still_ns = {
        let _still = plant.process.stop()?;
        thread::sleep(STILL);
        clock::now::now_ns()
    };
    thread::sleep(REST);
    let most_kb = plant.process.most_kb()? + controller.most_kb()?;
    controller.end()?;
    plant.end()?;
    let mut count = 0;
    let is_under_way = |row: &MessageRow| {
        let is_sent = row.t_send_ns.is_some_and(|t_ns| t_ns <= still_ns);
        is_sent && row.t_receive_ns.is_none_or(|t_ns| t_ns > still_ns)
    };
    rows::read(&folder.join(MessageRow::FILE), |row: &MessageRow| {
        count += u32::from(is_under_way(row));
    })?;
    if count == 0 {
        return Err(Lack("no message was under way".to_owned()));
    }
    Ok(vec![
        ("idle_mb", rest_kb * 1e-3),
        ("message_kb", (most_kb - rest_kb) / f64::from(count)),
    ])
}

fn link(context: &Context<'_>) -> Result<Measured, Lack> {
    let [controller, plant, middle] = [Namespace::new()?, Namespace::new()?, Namespace::new()?];
    join(&controller, &plant, &middle, false)?;
    let mut command = Command::new(&context.programs.webloop);
    command
        .args(["serve", "link", "--profile", "couva"])
        .args(["--controller", CONTROLLER_INTERFACE])
        .args(["--plant", PLANT_INTERFACE, "--out"])
        .arg(context.folder.join("link"));
    let link = Process::start(&mut command, Some(&middle))?;
    thread::sleep(REST);
    let idle_kb = link.resident_kb()?;
    link.end()?;
    Ok(vec![("idle_mb", idle_kb * 1e-3)])
}
