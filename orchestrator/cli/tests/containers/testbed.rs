//! One `docker compose up` of webloop's own file, as a user would do it by hand: the project's
//! name, its settings, its results folder, and its end.

use std::fs;
use std::os::unix::fs::{PermissionsExt, chown};
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use rustix::process::geteuid;
use tempfile::TempDir;

use crate::docker::{TOP, command, docker, inspect};
use crate::webloop::{Experiment, column};

/// A generous limit: a testbed is up within some five seconds.
const UP_WITHIN: Duration = Duration::from_secs(60);

/// An agent that is told to end does so within a second.
const SILENT_WITHIN: Duration = Duration::from_secs(5);

/// The services that run for as long as a campaign does.
pub(crate) const SERVICES: [&str; 5] = [
    "plant",
    "controller",
    "plant-link",
    "controller-link",
    "orchestrator",
];

/// A project of its own. Dropping it takes it down.
pub(crate) struct Testbed {
    folder: TempDir,
    project: String,
    variables: Vec<(&'static str, String)>,
    /// More compose files, laid over webloop's.
    over: Vec<PathBuf>,
}

impl Testbed {
    /// A testbed that runs a closed loop over `topology` for `duration`.
    pub(crate) fn new(topology: &str, duration: &str) -> Testbed {
        let folder = tempfile::tempdir().unwrap();
        // The orchestrator becomes another user, who has to reach what is in the folder.
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o755)).unwrap();
        let experiments = folder.path().join("experiments");
        fs::create_dir(&experiments).unwrap();
        Experiment::new(&experiments, &["arima"], "3ms", duration);
        let results = folder.path().join("results");
        fs::create_dir(&results).unwrap();
        let mut testbed = Testbed {
            project: format!("webloop-test-{}", std::process::id()),
            variables: vec![
                ("RESULTS", results.display().to_string()),
                (
                    "EXPERIMENT",
                    "orchestrator/experiments/experiment.toml".into(),
                ),
                ("TOPOLOGY", topology.into()),
            ],
            over: Vec::new(),
            folder,
        };
        testbed.lay_over(&format!(
            "services: {{ orchestrator: {{ volumes: [{{ type: bind, source: {}, \
             target: /orchestrator/experiments, read_only: true }}] }} }}\n",
            experiments.display()
        ));
        testbed
    }

    /// Sets another variable, as in `TOPOLOGY=couva docker compose up`.
    pub(crate) fn set(&mut self, variable: &'static str, value: impl Into<String>) {
        self.variables.push((variable, value.into()));
    }

    /// Adds a compose file on top of webloop's.
    pub(crate) fn lay_over(&mut self, yaml: &str) {
        let path = self
            .folder
            .path()
            .join(format!("over-{}.yml", self.over.len()));
        fs::write(&path, yaml).unwrap();
        self.over.push(path);
    }

    pub(crate) fn results(&self) -> PathBuf {
        self.folder.path().join("results")
    }

    /// Gives the results folder to another user, if we are root. Returns the folder's owner.
    pub(crate) fn give_results_to(&self, uid: u32) -> u32 {
        if geteuid().is_root() {
            chown(self.results(), Some(uid), Some(uid)).unwrap();
            uid
        } else {
            geteuid().as_raw()
        }
    }

    /// `docker compose up`.
    pub(crate) fn up(&self) -> Command {
        // The images exist: these tests check that first.
        self.compose(&["up", "--no-build"])
    }

    /// The container of a service.
    pub(crate) fn container(&self, service: &str) -> String {
        format!("{}-{service}-1", self.project)
    }

    /// Its existing containers, running or not.
    pub(crate) fn containers(&self) -> Vec<String> {
        let filter = format!("label=com.docker.compose.project={}", self.project);
        let list = ["container", "ls", "--all", "--quiet", "--filter", &filter];
        docker(&list).unwrap().lines().map(str::to_owned).collect()
    }

    /// The exit code of each service that ran. Checks that none still runs.
    pub(crate) fn exit_codes(&self) -> Vec<(&'static str, i64)> {
        SERVICES
            .into_iter()
            .map(|service| {
                let state = &inspect(&self.container(service))["State"];
                assert_eq!(state["Running"], false, "{service} still runs");
                (service, state["ExitCode"].as_i64().unwrap())
            })
            .collect()
    }

    /// Waits until the loop is closed and its rows are copied to the host. Returns the cell's folder.
    pub(crate) fn await_rows(&self, up: &mut Child) -> PathBuf {
        let deadline = Instant::now() + UP_WITHIN;
        loop {
            let cell = self.cells().into_iter().find(|cell| {
                fs::read(cell.join("messages.csv"))
                    .is_ok_and(|text| column(&text, "seq").len() > 50)
            });
            if let Some(cell) = cell {
                return cell;
            }
            assert!(Instant::now() < deadline, "no message within {UP_WITHIN:?}");
            assert!(up.try_wait().unwrap().is_none(), "it ended by itself");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// The campaigns' folders.
    pub(crate) fn campaigns(&self) -> Vec<PathBuf> {
        folders_in(&self.results())
    }

    /// The cells' folders, without those of disturbed tries, which are beside them.
    pub(crate) fn cells(&self) -> Vec<PathBuf> {
        let campaigns = self.campaigns();
        campaigns
            .iter()
            .flat_map(|campaign| folders_in(&campaign.join("cells")))
            .filter(|cell| !cell.to_string_lossy().contains(".disturbed-"))
            .collect()
    }

    /// Removes its containers and networks.
    pub(crate) fn down(&self) {
        let _ = self
            .compose(&["down", "--volumes", "--remove-orphans", "--timeout", "2"])
            .output();
    }

    /// Waits until none of its containers runs: `up` may end before agents that were told to end.
    pub(crate) fn await_silence(&self) {
        let deadline = Instant::now() + SILENT_WITHIN;
        let filter = format!("label=com.docker.compose.project={}", self.project);
        let list = ["container", "ls", "--filter", &filter];
        loop {
            let running = docker(&list).unwrap();
            if running.lines().count() <= 1 {
                return;
            }
            assert!(Instant::now() < deadline, "these still run:\n{running}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    fn compose(&self, arguments: &[&str]) -> Command {
        let mut command = command(&["compose", "--ansi", "never", "-p", &self.project]);
        command.arg("--project-directory").arg(TOP);
        command
            .arg("-f")
            .arg(Path::new(TOP).join("docker-compose.yml"));
        for over in &self.over {
            command.arg("-f").arg(over);
        }
        command.args(arguments).envs(self.variables.clone());
        command
    }
}

impl Drop for Testbed {
    fn drop(&mut self) {
        self.down();
    }
}

fn folders_in(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.is_dir())
        .collect()
}
