//! Docker by hand: what it holds, what it reports of a container, and decoys that have to stay.

use std::collections::BTreeMap;
use std::process::{Command, Stdio};

use serde_json::Value;

/// The label that says which process made a thing; empty if a person did.
const OWNER: &str = "webloop.owner";

/// The checkout that this test was built in, whose compose file is tried.
pub(crate) const TOP: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// `docker` with these arguments, without the Compose variables of the tester's shell.
pub(crate) fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new("docker");
    command
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    for variable in SETTINGS {
        command.env_remove(variable);
    }
    command
}

/// The variables that docker-compose.yml reads, and those that Compose reads.
const SETTINGS: &[&str] = &[
    "TOPOLOGY",
    "CLIENT",
    "CONTROLLER",
    "CONTROLLER_TARGET",
    "CONTROLLER_IMAGE",
    "CONTROLLER_RUN",
    "PLANT",
    "PLANT_TARGET",
    "PLANT_IMAGE",
    "PLANT_RUN",
    "FILES",
    "EXPERIMENT",
    "SEED",
    "PLAYER",
    "RESULTS",
    "OWNER",
    "WEBLOOP_RUN",
    "WEBLOOP_OWNER",
    "WEBLOOP_ENGINE",
    "COMPOSE_FILE",
    "COMPOSE_PROFILES",
    "COMPOSE_PROJECT_NAME",
];

/// Calls docker. Returns its output, or its complaint as an error.
pub(crate) fn docker(arguments: &[&str]) -> Result<String, String> {
    let output = command(arguments).output().map_err(|e| e.to_string())?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
    if output.status.success() {
        Ok(text(&output.stdout))
    } else {
        Err(text(&output.stderr))
    }
}

/// Why containers cannot be tested on this machine; `None` if they can.
pub(crate) fn lack() -> Option<String> {
    if let Err(lack) = containers::compose::serves().and(containers::compose::composes()) {
        return Some(lack.to_string());
    }
    docker(&[
        "image",
        "inspect",
        "webloop",
        "webloop-link",
        "webloop-native",
    ])
    .err()
    .map(|problem| format!("{problem}; build the images: docker compose build"))
}

/// Output of `docker inspect` for a container.
pub(crate) fn inspect(container: &str) -> Value {
    let text = docker(&["container", "inspect", container]).unwrap();
    let told: Vec<Value> = serde_json::from_str(&text).unwrap();
    told.into_iter().next().unwrap()
}

/// The process numbers of a container's processes on this machine.
pub(crate) fn processes(container: &str) -> Vec<u32> {
    docker(&["container", "top", container, "-o", "pid"])
        .unwrap()
        .lines()
        .skip(1)
        .map(|pid| pid.trim().parse().unwrap())
        .collect()
}

/// Containers, networks and volumes by their number or name, each with its labels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Held(BTreeMap<String, String>);

impl Held {
    /// Everything that the engine holds now.
    pub(crate) fn now() -> Held {
        let mut held = BTreeMap::new();
        for (list, id) in [
            (&["container", "ls", "--all", "--no-trunc"][..], "{{.ID}}"),
            (&["network", "ls", "--no-trunc"][..], "{{.ID}}"),
            (&["volume", "ls"][..], "{{.Name}}"),
        ] {
            let format = format!("{id}\t{{{{.Labels}}}}");
            let said = docker(&[list, &["--format", &format]].concat()).unwrap();
            for line in said.lines() {
                let (id, labels) = line.split_once('\t').unwrap_or((line, ""));
                held.insert(format!("{} {id}", list[0]), labels.to_owned());
            }
        }
        Held(held)
    }

    /// What is here, was not in `before`, and was not made by another webloop: it was made by the
    /// process with the number `pid`, or does not say by whom.
    pub(crate) fn new_since(&self, before: &Held, pid: u32) -> Vec<String> {
        let of_others = |labels: &str| {
            labels
                .split(',')
                .filter_map(|label| label.strip_prefix(OWNER)?.strip_prefix('='))
                .any(|owner| !owner.contains(&format!(":{pid}:")))
        };
        self.0
            .iter()
            .filter(|(thing, labels)| !before.0.contains_key(*thing) && !of_others(labels))
            .map(|(thing, labels)| format!("{thing} ({labels})"))
            .collect()
    }

    /// The Compose projects of the webloop process with this number.
    pub(crate) fn projects_of(&self, pid: u32) -> Vec<String> {
        let mut projects: Vec<String> = self
            .0
            .values()
            .filter(|labels| labels.contains(OWNER) && labels.contains(&format!(":{pid}:")))
            .filter_map(|labels| {
                labels
                    .split(',')
                    .find_map(|label| label.strip_prefix("com.docker.compose.project="))
            })
            .map(str::to_owned)
            .collect();
        projects.sort();
        projects.dedup();
        projects
    }
}

/// A container, a network and a volume that are not webloop's, and a queueing discipline on that
/// network's bridge; removed at the end.
pub(crate) struct Decoys {
    name: String,
    bridge: String,
    /// What tc prints for the bridge; empty if there is no tc, or no right to use it.
    discipline: String,
}

impl Decoys {
    pub(crate) fn new() -> Decoys {
        let name = format!("webloop-decoy-{}", std::process::id());
        docker(&["volume", "create", &name]).unwrap();
        let network = docker(&["network", "create", "--internal", &name]).unwrap();
        let bridge = format!("br-{}", &network[..12]);
        docker(&[
            "container",
            "run",
            "--detach",
            "--name",
            &name,
            "--network",
            &name,
            "--volume",
            &format!("{name}:/decoy"),
            "--entrypoint",
            "sleep",
            // One that has programs of Debian's.
            "webloop-python",
            "3600",
        ])
        .unwrap();
        tc(&[
            "qdisc", "add", "dev", &bridge, "root", "handle", "9:", "htb",
        ]);
        let discipline = discipline(&bridge);
        Decoys {
            name,
            bridge,
            discipline,
        }
    }

    /// Whether all of them are still as they were made.
    pub(crate) fn stand(&self) -> bool {
        docker(&["volume", "inspect", &self.name]).is_ok()
            && docker(&["network", "inspect", &self.name]).is_ok()
            && inspect(&self.name)["State"]["Running"] == true
            && discipline(&self.bridge) == self.discipline
    }
}

impl Drop for Decoys {
    fn drop(&mut self) {
        let name = self.name.as_str();
        let _ = docker(&["container", "rm", "--force", name]);
        let _ = docker(&["network", "rm", name]);
        let _ = docker(&["volume", "rm", name]);
    }
}

/// The interface's discipline and its handle, such as `qdisc htb 9:`; the rest counts packets.
fn discipline(device: &str) -> String {
    let said = tc(&["qdisc", "show", "dev", device, "root"]);
    said.split_whitespace()
        .take(3)
        .collect::<Vec<_>>()
        .join(" ")
}

fn tc(arguments: &[&str]) -> String {
    Command::new("tc")
        .args(arguments)
        .output()
        .map_or(String::new(), |output| {
            String::from_utf8_lossy(&output.stdout).into_owned()
        })
}
