//! A client that is stopped in its container: its agent sees that, and the run reports it.

use std::fs;
use std::thread::sleep;
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};

use crate::docker::{docker, inspect};
use crate::testbed::Testbed;
use crate::webloop::{manifest, too_busy};

/// Length of the one stop in the middle of the run: too long to be explained by a slow machine.
const STOPPED_FOR: Duration = Duration::from_millis(300);

pub(crate) fn a_client_that_is_stopped_in_its_container_is_told_by_that_name() -> Result<(), String>
{
    docker(&["image", "inspect", "webloop-python"])
        .map_err(|lack| format!("{lack}; build it: CLIENT=python docker compose build"))?;
    for _ in serial::tries() {
        let told = run_and_stop_it();
        println!("  {told}");
        if !told.contains("too busy") {
            assert!(told.contains("the controller was stopped"), "{told}");
            return Ok(());
        }
    }
    Err(too_busy("a run"))
}

/// What a run reports if its client is stopped in the middle: of itself, and of its first try.
fn run_and_stop_it() -> String {
    let mut testbed = Testbed::new("buccoo", "6s");
    testbed.set("CLIENT", "python");
    let mut up = testbed.up().spawn().unwrap();
    testbed.await_rows(&mut up);
    let state = &inspect(&testbed.container("controller"))["State"];
    let agent = u32::try_from(state["Pid"].as_u64().unwrap()).unwrap();
    let is_python = |pid: &u32| {
        let name = fs::read_to_string(format!("/proc/{pid}/comm"));
        name.is_ok_and(|name| name.starts_with("python"))
    };
    let python = beneath(agent).into_iter().find(is_python);
    let python = python.expect("the client runs beneath its agent");
    let python = Pid::from_raw(python.cast_signed()).unwrap();
    kill_process(python, Signal::STOP).unwrap();
    sleep(STOPPED_FOR);
    kill_process(python, Signal::CONT).unwrap();
    up.wait_with_output().unwrap();
    let manifest = manifest(&testbed.cells()[0]);
    [manifest.reasons, manifest.earlier].concat().join("\n")
}

/// The descendants of a process.
fn beneath(pid: u32) -> Vec<u32> {
    let tasks = fs::read_dir(format!("/proc/{pid}/task"))
        .into_iter()
        .flatten();
    let lists = tasks.flatten().filter_map(|task| {
        let children = fs::read_to_string(task.path().join("children"));
        children.ok()
    });
    let children: Vec<u32> = lists
        .flat_map(|list| {
            let numbers = list.split_whitespace().map(str::parse).collect::<Vec<_>>();
            numbers.into_iter().flatten()
        })
        .collect();
    let below = children.iter().flat_map(|child| beneath(*child));
    let below: Vec<u32> = below.collect();
    [children, below].concat()
}
