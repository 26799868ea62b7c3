//! `netem/kernel/run`: a command in a kernel that has netem behaves as it does here, and leaves
//! nothing. Skipped where that kernel is not prepared: `netem/kernel/run -- true` does it.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Two namespaces, 20 ms between them one way, and three pings. Beside the delay, what the
/// guest itself takes: some tenths of a millisecond, or many on a busy machine.
const DELAYED_PING: &str = "set -e
ip netns add far
ip link add near type veth peer name there netns far
ip address add 10.9.0.1/24 dev near
ip -n far address add 10.9.0.2/24 dev there
ip link set near up
ip -n far link set there up
tc qdisc add dev near root netem delay 20ms
ping -c 3 -i 0.2 10.9.0.2
tc qdisc show dev near >&2
exit 7";

fn run() -> Command {
    let mut command = Command::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../kernel/run"));
    command.arg("--no-install").stdin(Stdio::null());
    command
}

/// Whether there is such a kernel here; says why not.
fn is_prepared() -> bool {
    let output = run().args(["--", "true"]).output().unwrap();
    if !output.status.success() {
        // Past the harness, which keeps to itself what a passed test printed.
        let _ = writeln!(std::io::stderr(), "SKIPPED: {}", text(&output.stderr));
    }
    output.status.success()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).trim().to_owned()
}

#[test]
fn a_command_has_netem_its_own_output_and_its_own_exit_code() {
    if !is_prepared() {
        return;
    }
    let Output {
        status,
        stdout,
        stderr,
    } = run()
        .args(["--timeout", "120", "--", "sh", "-c", DELAYED_PING])
        .output()
        .unwrap();
    let (stdout, stderr) = (text(&stdout), text(&stderr));
    println!("{stdout}\n{stderr}");
    assert_eq!(status.code(), Some(7));
    assert!(stderr.contains("netem"), "what is said on standard error");
    assert!(stderr.contains("delay 20ms"), "what the kernel accepted");
    let summary = stdout.lines().last().unwrap();
    // rtt min/avg/max/mdev = 20.187/21.946/25.432/2.464 ms
    let shortest_ms: f64 = summary.split([' ', '/']).nth(6).unwrap().parse().unwrap();
    assert!((20.0..40.0).contains(&shortest_ms), "{summary}");
}

#[test]
fn a_killed_run_leaves_no_process() {
    if !is_prepared() {
        return;
    }
    // A number that nobody else's command line has.
    let mark = format!("WEBLOOP_MARK_{}", std::process::id());
    let mut child = run()
        .args(["--", "sh", "-c", "echo up; sleep 1000"])
        .env("XDG_CACHE_HOME", cache_of(&mark))
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap())
        .read_line(&mut line)
        .unwrap();
    assert_eq!(line, "up\n");
    assert!(processes_with(&mark) >= 2, "the kernel and what is in it");
    child.kill().unwrap();
    child.wait().unwrap();
    let killed = Instant::now();
    while processes_with(&mark) > 0 {
        assert!(killed.elapsed() < Duration::from_secs(5), "still there");
        std::thread::sleep(Duration::from_millis(20));
    }
    fs::remove_dir_all(cache_of(&mark)).unwrap();
}

/// The kernel that is prepared, under a path of our own, by which its processes can be found.
fn cache_of(mark: &str) -> std::path::PathBuf {
    let home = std::env::var("HOME").unwrap_or_else(|_| "/root".to_owned());
    let real = std::env::var("XDG_CACHE_HOME").unwrap_or_else(|_| format!("{home}/.cache"));
    let own = std::env::temp_dir().join(mark);
    if !own.exists() {
        fs::create_dir_all(own.join("webloop/netem")).unwrap();
        // Of both machines; one of them is prepared here.
        for kernel in ["webloop/netem/kernel", "webloop/netem/kernel-qemu"] {
            std::os::unix::fs::symlink(format!("{real}/{kernel}"), own.join(kernel)).unwrap();
        }
    }
    own
}

fn processes_with(mark: &str) -> usize {
    fs::read_dir("/proc")
        .unwrap()
        .flatten()
        .filter(|entry| {
            fs::read(entry.path().join("cmdline"))
                .is_ok_and(|line| String::from_utf8_lossy(&line).contains(mark))
        })
        .count()
}

#[test]
fn a_wrong_command_line_is_answered_at_once() {
    for (arguments, answer) in [
        (&["true"][..], "`true` is not an option"),
        (&["--"][..], "no command"),
        (&["--mem", "2", "--", "true"][..], "--mem 2 is no size"),
        (
            &["--timeout", "soon", "--", "true"][..],
            "number of seconds",
        ),
        (
            &["--docker", "nowhere.tar", "--", "true"][..],
            "docker save",
        ),
    ] {
        let output = run().args(arguments).output().unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(answer), "{said}");
    }
}
