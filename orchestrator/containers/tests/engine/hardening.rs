//! webloop's own docker-compose.yml, as Compose understands it.

use std::path::Path;
use std::process::Command;

use containers::compose::ComposeFile;
use serde_json::{Value, json};

fn file() -> ComposeFile {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    ComposeFile::find(Some(&top)).unwrap()
}

/// What `docker compose config` makes of it, with only these variables set.
fn config(variables: &[(&str, &str)]) -> Value {
    let output = Command::new("docker")
        .args(["compose", "--file"])
        .arg(file().path())
        .args(["config", "--format", "json"])
        .env_remove("OWNER")
        .envs(variables.iter().copied())
        .output()
        .unwrap();
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{complaint}");
    assert_eq!(complaint, "", "a warning is a surprise");
    serde_json::from_slice(&output.stdout).unwrap()
}

pub(crate) fn no_service_is_given_more_than_it_needs() {
    let config = config(&[("WEBLOOP_RUN", "r"), ("WEBLOOP_OWNER", "a:1:2")]);
    let services = config["services"].as_object().unwrap();
    assert_eq!(services.len(), 6, "{:?}", services.keys());
    for (name, service) in services {
        let powers = match name.as_str() {
            "plant-link" | "controller-link" => json!(["NET_ADMIN", "NET_RAW"]),
            "orchestrator" => json!(["SETUID", "SETGID"]),
            _ => Value::Null,
        };
        assert_eq!(service["cap_add"], powers, "{name}");
        assert_eq!(service["cap_drop"], json!(["ALL"]), "{name}");
        assert_eq!(service["read_only"], json!(true), "{name}");
        assert_eq!(
            service["security_opt"],
            json!(["no-new-privileges:true"]),
            "{name}"
        );
        assert_eq!(service["pull_policy"], "never", "{name}");
        assert!(!service["pids_limit"].is_null(), "{name}");
        assert!(!service["mem_limit"].is_null(), "{name}");
        for absent in ["privileged", "ports", "expose", "pid", "ipc"] {
            assert!(service[absent].is_null(), "{name} has {absent}");
        }
        assert!(!service.to_string().contains("docker.sock"), "{name}");
        assert_eq!(service["labels"]["webloop.owner"], "a:1:2", "{name}");
        assert_eq!(service["labels"]["webloop.run"], "r", "{name}");
    }
    for end in ["plant", "controller"] {
        assert_eq!(services[end]["user"], "1000:1000");
    }
    for (name, network) in config["networks"].as_object().unwrap() {
        assert_eq!(network["internal"], json!(true), "{name}");
        assert_eq!(network["labels"]["webloop.owner"], "a:1:2", "{name}");
    }
}

pub(crate) fn settings_come_from_the_environment() {
    let command = |variables: &[(&str, &str)]| {
        let config = config(variables);
        let words: Vec<String> =
            serde_json::from_value(config["services"]["orchestrator"]["command"].clone()).unwrap();
        words.join(" ")
    };
    assert_eq!(
        command(&[("TOPOLOGY", ""), ("SEED", "")]),
        "run smoke --topology couva --client native --seed 1 --player auto --backend attach --progress plain"
    );
    let settings = [
        ("TOPOLOGY", "netem/profiles/mine.toml"),
        ("EXPERIMENT", "paper"),
        ("CLIENT", "python"),
        ("SEED", "7"),
        ("PLAYER", "tc"),
    ];
    assert!(command(&settings).starts_with(
        "run paper --topology netem/profiles/mine.toml --client python --seed 7 --player tc "
    ));
    let config = config(&[("OWNER", "1001:1002")]);
    assert_eq!(config["services"]["orchestrator"]["user"], "1001:1002");
}

pub(crate) fn an_old_compose_is_told_what_it_takes() {
    let Ok(version) = Command::new("docker-compose")
        .args(["version", "--short"])
        .output()
    else {
        println!("  SKIPPED: there is no docker-compose, the old one, to try it with");
        return;
    };
    let version = String::from_utf8_lossy(&version.stdout).trim().to_owned();
    if !version.starts_with("1.") {
        println!("  SKIPPED: docker-compose is {version}, not the old one");
        return;
    }
    let output = Command::new("docker-compose")
        .arg("--file")
        .arg(file().path())
        .arg("up")
        .output()
        .unwrap();
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success());
    assert!(
        complaint.contains("webloop-needs-Docker-Compose-2.20-or-later"),
        "{complaint}"
    );
}
