//! `webloop serve agent` as a process: real roles, real signals, over loopback.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use containers::{AgentName, Remote, RemoteRun, RoleState, Token};
use endpoint::{ControllerSettings, Mode};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::json;
use tempfile::TempDir;

/// Generous: for what takes milliseconds on an idle machine.
const SOON: Duration = Duration::from_secs(10);

const TOKEN: &str = "0123456789abcdef-given";

/// An agent in a process of its own.
struct Agent {
    process: Child,
    address: String,
    remote: Remote,
    _scratch: TempDir,
}

fn webloop() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_webloop"));
    command.env_remove("RUST_LOG").env_remove(Token::VARIABLE);
    command.stdin(Stdio::null()).stderr(Stdio::piped());
    command
}

impl Agent {
    fn start(name: AgentName) -> Agent {
        let scratch = tempfile::tempdir().unwrap();
        let mut process = webloop()
            .args([
                "serve",
                "agent",
                &name.to_string(),
                "--listen",
                "localhost:0",
            ])
            .arg("--scratch")
            .arg(scratch.path())
            .env(Token::VARIABLE, TOKEN)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        let stdout = process.stdout.take().unwrap();
        BufReader::new(stdout).read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("ready ").unwrap().to_owned();
        let remote = Remote::open(name, &address, TOKEN.parse().unwrap()).unwrap();
        remote.wait_healthy(SOON).unwrap();
        remote.claim().unwrap();
        Agent {
            process,
            address,
            remote,
            _scratch: scratch,
        }
    }

    /// With a plant as its role; the run, and the plant's process number.
    fn with_a_plant() -> (Agent, RemoteRun, u32) {
        let agent = Agent::start(AgentName::Plant);
        let run = agent.remote.begin("r1").unwrap();
        run.start("plant", "plant", told_plant()).unwrap();
        let [plant] = children(agent.process.id())[..] else {
            panic!("an agent with one role has one child");
        };
        (agent, run, plant)
    }

    fn signal(&self, signal: Signal) {
        let number = i32::try_from(self.process.id()).unwrap();
        kill_process(Pid::from_raw(number).unwrap(), signal).unwrap();
    }

    /// Its end, and what it said on standard error.
    fn end(self) -> Output {
        self.process.wait_with_output().unwrap()
    }
}

/// Processes that were started by `parent` and still are its children.
fn children(parent: u32) -> Vec<u32> {
    let parent_of = |process: u32| -> Option<u32> {
        let stat = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
        // After the program's name, which may have spaces, come its state and its parent.
        stat.rsplit_once(')')?
            .1
            .split_whitespace()
            .nth(1)?
            .parse()
            .ok()
    };
    fs::read_dir("/proc")
        .unwrap()
        .flatten()
        .filter_map(|entry| entry.file_name().to_str()?.parse().ok())
        .filter(|process| parent_of(*process) == Some(parent))
        .collect()
}

fn gone_soon(process: u32) {
    let deadline = Instant::now() + SOON;
    // One that nobody has waited for yet has no command line any more.
    while fs::read(format!("/proc/{process}/cmdline")).is_ok_and(|line| !line.is_empty()) {
        assert!(
            Instant::now() < deadline,
            "process {process} is still there"
        );
        thread::sleep(Duration::from_millis(5));
    }
}

/// What a plant is told.
fn told_plant() -> serde_json::Value {
    json!({
        "listen": "127.0.0.1:0",
        "settings": {"h": "10ms", "late": "apply"},
    })
}

fn rows(file: &Path) -> u64 {
    csv::Reader::from_path(file).unwrap().records().count() as u64
}

fn report(folder: &Path, name: &str) -> serde_json::Value {
    serde_json::from_slice(&fs::read(folder.join(name)).unwrap()).unwrap()
}

#[test]
fn two_agents_close_a_loop_whose_rows_are_all_here() {
    let (plant, controller) = (
        Agent::start(AgentName::Plant),
        Agent::start(AgentName::Controller),
    );
    let here = tempfile::tempdir().unwrap();
    let at_plant = plant.remote.begin("r1").unwrap();
    let at_controller = controller.remote.begin("r1").unwrap();
    let followers = [
        at_plant.follow(
            &["ticks.csv", "arrivals.csv", "plant.json", "plant.log"],
            here.path(),
        ),
        at_controller.follow(
            &["messages.csv", "controller.json", "controller.log"],
            here.path(),
        ),
    ];
    let address = at_plant.start("plant", "plant", told_plant()).unwrap();
    let h = "10ms".parse().unwrap();
    let settings = ControllerSettings {
        r: -0.5,
        ..ControllerSettings::new(Mode::Closed, h)
    };
    let settings = json!({
        "plant": address,
        "settings": settings,
        "duration_ns": 1_500_000_000,
    });
    at_controller
        .start("controller", "controller", settings)
        .unwrap();
    let deadline = Instant::now() + 2 * SOON;
    let fine = RoleState::Ended {
        code: 0,
        words: String::new(),
    };
    while at_controller.state("controller").unwrap() != fine {
        assert!(
            Instant::now() < deadline,
            "{:?}",
            at_controller.state("controller")
        );
        assert_eq!(at_plant.state("plant").unwrap(), RoleState::Running);
        thread::sleep(Duration::from_millis(100));
    }
    assert_eq!(at_plant.stop("plant").unwrap(), fine);
    for follower in followers {
        follower.unwrap().finish().unwrap();
    }
    let (plant_report, report) = (
        report(here.path(), "plant.json"),
        report(here.path(), "controller.json"),
    );
    assert_eq!(rows(&here.path().join("ticks.csv")), plant_report["ticks"]);
    assert_eq!(
        rows(&here.path().join("arrivals.csv")),
        plant_report["arrivals"]
    );
    assert_eq!(
        rows(&here.path().join("messages.csv")),
        report["rows"]["rows"]
    );
    assert!(
        plant_report["arrivals"].as_u64().unwrap() > 100,
        "{plant_report}"
    );
    for (agent, run) in [(plant, at_plant), (controller, at_controller)] {
        run.finish().unwrap();
        agent.remote.end().unwrap();
        let output = agent.end();
        assert_eq!(output.status.code(), Some(0));
        assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    }
}

#[test]
fn a_signal_ends_an_agent_soon_and_its_roles_with_it() {
    serial::timed("a_signal_ends_an_agent_soon_and_its_roles_with_it", || {
        for signal in [Signal::TERM, Signal::INT] {
            let (agent, _run, plant) = Agent::with_a_plant();
            let begun = Instant::now();
            agent.signal(signal);
            let output = agent.end();
            let took = begun.elapsed();
            println!("{signal:?}: ended after {took:?}");
            assert_eq!(
                output.status.code(),
                Some(0),
                "{}",
                String::from_utf8_lossy(&output.stderr)
            );
            // The plant has only to flush its rows: some ms.
            assert!(took < Duration::from_secs(1), "{took:?}");
            gone_soon(plant);
        }
    });
}

#[test]
fn a_killed_agent_leaves_no_role() {
    let (agent, _run, plant) = Agent::with_a_plant();
    // Longer than a pool's thread idles, so that a role started by one would be gone already.
    thread::sleep(Duration::from_secs(12));
    assert_eq!(children(agent.process.id()), [plant]);
    agent.signal(Signal::KILL);
    assert_eq!(agent.end().status.code(), None);
    gone_soon(plant);
}

#[test]
fn a_role_does_not_learn_the_token() {
    let (agent, run, plant) = Agent::with_a_plant();
    let environment = |process: u32| fs::read(format!("/proc/{process}/environ")).unwrap();
    let names = |process: u32| -> BTreeSet<String> {
        let text = String::from_utf8_lossy(&environment(process)).into_owned();
        text.split('\0')
            .filter_map(|pair| Some(pair.split_once('=')?.0.to_owned()))
            .collect()
    };
    assert!(names(agent.process.id()).contains(Token::VARIABLE));
    assert!(!names(plant).contains(Token::VARIABLE));
    assert!(!String::from_utf8_lossy(&environment(plant)).contains(TOKEN));
    run.finish().unwrap();
    agent.remote.end().unwrap();
    agent.end();
}

#[test]
fn health_is_an_exit_code() {
    let agent = Agent::start(AgentName::PlantLink);
    let ask = |address: &str| {
        webloop()
            .args(["serve", "health", "--agent", address])
            .output()
            .unwrap()
    };
    let begun = Instant::now();
    let output = ask(&agent.address);
    println!("a health check takes {:?}", begun.elapsed());
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stdout.is_empty() && output.stderr.is_empty());
    agent.remote.end().unwrap();
    let address = agent.address.clone();
    agent.end();
    let output = ask(&address);
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        said.starts_with(&format!("webloop: agent: does not answer at {address}")),
        "{said}"
    );
    assert_eq!(said.lines().count(), 1, "{said}");
}

#[test]
fn an_address_in_use_and_a_bad_token_are_said_in_one_line() {
    let agent = Agent::start(AgentName::Plant);
    let scratch = tempfile::tempdir().unwrap();
    let again = |listen: &str, token: &str| {
        webloop()
            .args(["serve", "agent", "plant", "--listen", listen, "--scratch"])
            .arg(scratch.path())
            .env(Token::VARIABLE, token)
            .output()
            .unwrap()
    };
    for (output, code, words) in [
        (again(&agent.address, ""), 1, "cannot listen on"),
        (again("localhost:0", "short"), 2, "a token is 16 to 256"),
        (
            again("no-such-host.invalid:7070", ""),
            2,
            "is not an address to listen on",
        ),
    ] {
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{said}");
        assert!(said.contains(words) && said.lines().count() == 1, "{said}");
        assert!(!said.contains("short"), "{said}");
    }
    agent.remote.end().unwrap();
    agent.end();
}
