//! Containers that cannot do what was requested: a line that says what to do, an exit code, nothing
//! left.

use std::fs;
use std::process::{Command, Output};

use rustix::process::geteuid;

use crate::docker::{Held, TOP};
use crate::testbed::Testbed;
use crate::webloop::{Experiment, code, command, said};

/// A user who may not write into folders that belong to root.
const SOMEBODY: &str = "1234:1234";

pub(crate) fn what_up_cannot_do_it_says_in_a_line_and_ends() -> Result<(), String> {
    let one = || Testbed::new("diego-vpn", "500ms");

    let mut testbed = one();
    testbed.set("TOPOLOGY", "atlantis");
    refuses(&testbed, &["no topology `atlantis`", "use one of"]);

    let mut testbed = one();
    testbed.set("CLIENT", "netscape");
    // Each client has its own kind of container, so the engine reports this.
    refuses(&testbed, &["webloop-netscape"]);

    let mut testbed = one();
    testbed.set("RESULTS", "/nowhere/at/all");
    refuses(
        &testbed,
        &["bind source path does not exist: /nowhere/at/all"],
    );

    if geteuid().is_root() {
        let mut testbed = one();
        testbed.set("OWNER", SOMEBODY);
        refuses(&testbed, &["cannot write the results folder", "OWNER"]);
    }

    let mut testbed = one();
    testbed.lay_over(
        "services: { plant-link: { cap_add: !reset [] }, controller-link: { cap_add: !reset [] } }\n",
    );
    refuses(&testbed, &["unsupported", "--cap-add NET_RAW"]);

    let mut testbed = one();
    testbed.lay_over(
        "services: { plant-link: { cap_add: !override [NET_RAW] }, \
         controller-link: { cap_add: !override [NET_RAW] } }\n",
    );
    testbed.set("PLAYER", "user");
    refuses(&testbed, &["unsupported", "--cap-add NET_ADMIN"]);

    let mut testbed = one();
    testbed.lay_over(
        "services: { plant-link: { devices: !reset [] }, controller-link: { devices: !reset [] } }\n",
    );
    testbed.set("PLAYER", "user");
    refuses(&testbed, &["unsupported", "--device /dev/net/tun"]);

    let mut testbed = one();
    testbed.set("DOCKER_HOST", "unix:///nonexistent");
    let output = testbed.up().output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(
        said(&output).contains("Is the docker daemon running?"),
        "{}",
        said(&output)
    );
    Ok(())
}

/// Brings it up, which must fail with all these words in one line.
fn refuses(testbed: &Testbed, words: &[&str]) {
    let output = testbed.up().output().unwrap();
    assert_eq!(code(&output), Some(1), "{}", said(&output));
    says(&output, words);
    testbed.await_silence();
}

/// Checks that one line has all the words.
fn says(output: &Output, words: &[&str]) {
    let said = said(output);
    let line = said
        .lines()
        .find(|line| words.iter().all(|word| line.contains(word)));
    assert!(line.is_some(), "no line with {words:?} in:\n{said}");
    println!("  {}", line.unwrap_or_default().trim());
}

pub(crate) fn what_run_cannot_do_in_containers_it_says_with_its_code() -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    let experiment = Experiment::new(folder.path(), &["diego-vpn"], "3ms", "500ms");
    let run = |experiment: &Experiment| {
        let mut command = experiment.run(command());
        command.args(["--backend", "compose", "--no-build"]);
        command.current_dir(TOP);
        command
    };
    refuses_to(
        run(&experiment).args(["--topology", "atlantis"]),
        2,
        &["no topology `atlantis`"],
    );
    refuses_to(
        run(&experiment).args(["--client", "netscape"]),
        2,
        &["client `netscape`", "native"],
    );
    refuses_to(
        run(&experiment).env("DOCKER_HOST", "unix:///nonexistent"),
        3,
        &["the container engine does not answer", "start it"],
    );
    refuses_to(
        run(&experiment).current_dir("/"),
        2,
        &["no docker-compose.yml of webloop", "go into"],
    );
    refuses_to(
        run(&experiment).env("PATH", folder.path()),
        3,
        &["no command docker", "install Docker Engine"],
    );

    // A checkout whose sidecars lack something: an older or a changed compose file.
    let text = fs::read_to_string(format!("{TOP}/docker-compose.yml")).unwrap();
    for (was, is, player, code, words) in [
        (
            "cap_add: [NET_ADMIN, NET_RAW]",
            "cap_add: [NET_RAW]",
            "user",
            3,
            "--cap-add NET_ADMIN",
        ),
        (
            "devices: [/dev/net/tun]",
            "devices: []",
            "user",
            3,
            "--device /dev/net/tun",
        ),
        (
            "image: webloop-link",
            "image: webloop-none",
            "user",
            2,
            "docker compose build",
        ),
    ] {
        assert!(text.contains(was), "{was}");
        let checkout = tempfile::tempdir().unwrap();
        for folder in ["netem/profiles", "orchestrator/experiments"] {
            fs::create_dir_all(checkout.path().join(folder)).unwrap();
        }
        let file = checkout.path().join("docker-compose.yml");
        fs::write(file, text.replace(was, is)).unwrap();
        let experiment = Experiment::new(checkout.path(), &["diego-vpn"], "3ms", "500ms");
        let mut command = run(&experiment);
        command.current_dir(&checkout).args(["--player", player]);
        refuses_to(&mut command, code, &[words]);
    }
    Ok(())
}

/// Runs the command, which must end with this code and all these words in one line, and leave nothing.
fn refuses_to(command: &mut Command, exit: i32, words: &[&str]) {
    let before = Held::now();
    let run = command.spawn().unwrap();
    let pid = run.id();
    let output = run.wait_with_output().unwrap();
    assert_eq!(code(&output), Some(exit), "{}", said(&output));
    says(&output, words);
    assert_eq!(Held::now().new_since(&before, pid), [""; 0]);
}
