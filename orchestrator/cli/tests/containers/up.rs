//! `docker compose up` from start to end: what it leaves, and what its containers may do.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use serde_json::json;

use crate::docker::{inspect, processes};
use crate::testbed::{SERVICES, Testbed};
use crate::webloop::{code, command, said, too_busy};

/// A user who owns nothing else.
const SOMEBODY: u32 = 1234;

/// The user of the plant and the controller.
const NOBODY: u32 = 1000;

/// `NET_ADMIN` and `NET_RAW`, as bits of a capability set.
const SHAPING: u64 = 1 << 12 | 1 << 13;

pub(crate) fn up_ends_by_itself_with_results_of_their_folders_owner() -> Result<(), String> {
    for _ in serial::tries() {
        let testbed = Testbed::new("diego-vpn", "2s");
        let owner = testbed.give_results_to(SOMEBODY);
        let mut up = testbed.up().spawn().unwrap();
        testbed.await_rows(&mut up);
        for service in SERVICES {
            no_more_than_it_needs(&testbed.container(service), service, owner);
        }
        println!(
            "row 21: {} services: all capabilities dropped, read-only root, no-new-privileges, limits of memory and processes, no space of the host, no engine's socket; CapEff 0 in each process but the link sidecars'",
            SERVICES.len()
        );
        let up = up.wait_with_output().unwrap();
        if ["  invalid", "  disturbed: "]
            .iter()
            .any(|busy| said(&up).contains(busy))
        {
            println!("  too busy: {}", said(&up));
            continue;
        }
        assert_eq!(code(&up), Some(0), "{}", said(&up));
        for (service, code) in testbed.exit_codes() {
            assert_eq!(code, 0, "{service}");
        }
        let campaign = testbed.campaigns().remove(0);
        all_belong_to(&campaign, owner);
        let shown = command().arg("show").arg(&campaign).output().unwrap();
        assert_eq!(code(&shown), Some(0), "{}", said(&shown));
        let table = String::from_utf8(shown.stdout).unwrap();
        assert!(table.contains("diego-vpn"), "{table}");
        assert_eq!(
            table,
            fs::read_to_string(campaign.join("table.txt")).unwrap()
        );
        return Ok(());
    }
    Err(too_busy("the link"))
}

/// Checks a container's settings, and what the kernel reports of every process in it.
fn no_more_than_it_needs(container: &str, service: &str, owner: u32) {
    let told = inspect(container);
    let host = &told["HostConfig"];
    let (user, powers) = match service {
        "plant" | "controller" => (NOBODY, 0),
        "orchestrator" => (owner, 0),
        _ => (0, SHAPING),
    };
    assert_eq!(host["CapDrop"], json!(["ALL"]), "{service}");
    if user == NOBODY {
        assert_eq!(host["CapAdd"], json!(null), "{service}");
        assert_eq!(told["Config"]["User"], "1000:1000", "{service}");
    }
    assert_eq!(host["ReadonlyRootfs"], true, "{service}");
    assert_eq!(host["Privileged"], false, "{service}");
    let options = host["SecurityOpt"].to_string();
    assert!(
        options.contains("no-new-privileges:true"),
        "{service}: {options}"
    );

    // What else section 5 of docker-bench asks for.
    for limit in ["Memory", "PidsLimit"] {
        assert!(
            host[limit].as_i64().is_some_and(|most| most > 0),
            "{service}: {limit}"
        );
    }
    for space in ["PidMode", "IpcMode", "UTSMode", "UsernsMode"] {
        assert_ne!(host[space], "host", "{service}: {space}");
    }
    assert_ne!(host["NetworkMode"], "host", "{service}");
    assert_eq!(
        host["Devices"].as_array().map_or(0, Vec::len),
        usize::from(powers != 0),
        "{service}"
    );
    assert!(
        !told["Mounts"].to_string().contains("docker.sock"),
        "{service}"
    );

    let processes = processes(container);
    assert!(!processes.is_empty(), "{service}");
    for process in processes {
        // A process may have ended since, and an engine on another machine has other process numbers.
        let Ok(status) = fs::read_to_string(format!("/proc/{process}/status")) else {
            continue;
        };
        let field = |name: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(name));
            line.unwrap()
                .trim_start_matches(':')
                .split_whitespace()
                .next()
                .unwrap()
        };
        let set = |name: &str| u64::from_str_radix(field(name), 16).unwrap();
        assert_eq!(set("CapEff"), powers, "{service}: {status}");
        assert_eq!(set("CapPrm"), powers, "{service}: {status}");
        assert_eq!(field("NoNewPrivs"), "1", "{service}");
        assert_eq!(field("Uid"), user.to_string(), "{service}");
    }
}

fn all_belong_to(path: &Path, owner: u32) {
    let facts = fs::symlink_metadata(path).unwrap();
    assert_eq!(
        (facts.uid(), facts.gid()),
        (owner, owner),
        "{}",
        path.display()
    );
    if facts.is_dir() {
        for entry in fs::read_dir(path).unwrap().flatten() {
            all_belong_to(&entry.path(), owner);
        }
    }
}
