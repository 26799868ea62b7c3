//! One campaign's Compose project: its own name, its environment, and its end.

use std::hash::{BuildHasher, RandomState};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use crate::compose::docker::{call, docker};
use crate::compose::ends::Ends;
use crate::compose::file::ComposeFile;
use crate::compose::file::absolute;
use crate::compose::inventory::{Thing, with_label};
use crate::compose::owner::Owner;
use crate::compose::problem::Problem;

/// The label with the campaign that a container or network belongs to.
const RUN: &str = "webloop.run";

/// Time limit for `docker compose down`, which gives each service two seconds.
const DOWN_WITHIN: Duration = Duration::from_secs(30);

/// How often to look for leftovers after that, and the pause in between: a request of a Compose
/// that was killed may still be under way in the engine.
const TRIES: u32 = 5;
const BETWEEN_TRIES: Duration = Duration::from_millis(300);

/// Ties a command to this process before it is started, so that it cannot outlive it. A function,
/// because running code between fork and exec is not this crate's job.
pub type Leash = fn(&mut Command) -> io::Result<()>;

/// A campaign in containers. Dropping it takes down what it started.
pub struct Project {
    file: ComposeFile,
    /// `webloop-` and eight hexadecimal digits; no other campaign has this name, on any engine.
    name: String,
    results: PathBuf,
    /// Description of the engine for manifests.
    engine: String,
    pub(crate) ends: Ends,
    /// What somebody's own images start by themselves, as variables; known once they are built.
    pub(crate) commands: Vec<(&'static str, String)>,
    owner: Owner,
    leash: Leash,
    /// Whether containers may exist.
    pub(crate) up: bool,
}

impl Project {
    /// Makes a project for the campaign whose results go into the folder `results`, on the engine
    /// that manifests call `engine`, with these ends.
    ///
    /// # Errors
    /// When the folder does not exist, or `/proc` does not show this process.
    pub fn new(
        file: ComposeFile,
        results: &Path,
        engine: &str,
        ends: Ends,
        leash: Leash,
    ) -> Result<Project, Problem> {
        let owner =
            Owner::this().map_err(|problem| Problem::failed("identify this process", &problem))?;
        // The system seeds the hash anew each time.
        let digits = RandomState::new().hash_one(owner.to_string()) >> 32;
        Ok(Project {
            file,
            name: format!("webloop-{digits:08x}"),
            results: absolute(results)?,
            engine: engine.to_owned(),
            ends,
            commands: Vec::new(),
            owner,
            leash,
            up: false,
        })
    }

    /// Its name, for `docker compose -p`.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Removes all containers and networks of the project, running or not. Takes no more than about
    /// a minute. A second call does nothing.
    ///
    /// # Errors
    /// When something is still there afterwards; `webloop gc` will try again.
    pub fn down(&mut self) -> Result<(), Problem> {
        if !self.up {
            return Ok(());
        }
        // The sweep below removes what this leaves.
        if let Ok(command) =
            self.compose(&["down", "--volumes", "--remove-orphans", "--timeout", "2"])
        {
            let _ = call(command, DOWN_WITHIN).inspect_err(|problem| tracing::warn!("{problem}"));
        }
        let mut refused = None;
        for _ in 0..TRIES {
            match self.sweep() {
                Ok(true) => {
                    self.up = false;
                    return Ok(());
                }
                Ok(false) => refused = None,
                Err(problem) => refused = Some(problem),
            }
            std::thread::sleep(BETWEEN_TRIES);
        }
        Err(refused.unwrap_or_else(|| {
            Problem::failed(
                format!("take the project {} down", self.name),
                "something keeps making it again; run `webloop gc`",
            )
        }))
    }

    /// Removes what has the project's label. Returns whether there was nothing.
    fn sweep(&self) -> Result<bool, Problem> {
        let things = with_label(&format!("{RUN}={}", self.name))?;
        things.iter().try_for_each(Thing::remove)?;
        Ok(things.is_empty())
    }

    /// The name of the orchestrator's container.
    pub(crate) fn orchestrator(&self) -> String {
        format!("{}-orchestrator", self.name)
    }

    /// The last lines of every agent, each after a line break; empty if they cannot be read.
    pub(crate) fn words_of_agents(&self, within: Duration) -> String {
        self.compose(&["logs", "--no-color", "--tail", "3"])
            .and_then(|command| call(command, within))
            .map(|answer| answer.out.lines().map(|line| format!("\n{line}")).collect())
            .unwrap_or_default()
    }

    /// `docker compose` for this project, with all the environment that docker-compose.yml needs.
    pub(crate) fn compose(&self, arguments: &[&str]) -> Result<Command, Problem> {
        // The containers write there as its owner.
        let folder = std::fs::metadata(&self.results).map_err(|problem| {
            Problem::Usage(format!("cannot find {}: {problem}", self.results.display()))
        })?;
        let mut command = docker();
        command
            .args([
                "compose",
                "--ansi",
                "never",
                "--project-name",
                &self.name,
                "--file",
            ])
            .arg(self.file.path())
            .arg("--project-directory")
            .arg(self.file.folder())
            .args(arguments)
            .env("WEBLOOP_RUN", &self.name)
            .env("WEBLOOP_OWNER", self.owner.to_string())
            .env("WEBLOOP_ENGINE", &self.engine)
            .envs(self.ends.variables())
            .envs(self.commands.clone())
            .env("OWNER", format!("{}:{}", folder.uid(), folder.gid()))
            .env("RESULTS", &self.results)
            // This could start services that have to stay off.
            .env_remove("COMPOSE_PROFILES");
        self.leash(&mut command)?;
        Ok(command)
    }

    /// Ties a command to this process.
    pub(crate) fn leash(&self, command: &mut Command) -> Result<(), Problem> {
        (self.leash)(command)
            .map_err(|problem| Problem::failed("tie docker to this process", &problem))
    }
}

impl Drop for Project {
    fn drop(&mut self) {
        if let Err(problem) = self.down() {
            tracing::warn!("{problem}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn project(results: &Path) -> Project {
        let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let file = ComposeFile::find(Some(&top)).expect("webloop's own");
        Project::new(file, results, "", Ends::of_client("native"), |_| Ok(())).expect("a project")
    }

    #[test]
    fn two_campaigns_never_share_a_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let names = [(); 2].map(|()| project(folder.path()).name().to_owned());
        assert_ne!(names[0], names[1]);
        for name in names {
            let digits = name.strip_prefix("webloop-").expect("the prefix");
            assert!(digits.len() == 8 && digits.chars().all(|c| c.is_ascii_hexdigit()));
        }
    }

    #[test]
    fn containers_write_as_the_owner_of_the_results() {
        let folder = tempfile::tempdir().expect("a folder");
        let mine = std::fs::metadata(folder.path()).expect("it is there");
        let command = project(folder.path())
            .compose(&["build"])
            .expect("a command");
        let value = |name: &str| {
            command
                .get_envs()
                .find(|(key, _)| *key == name)
                .and_then(|(_, value)| value?.to_str().map(str::to_owned))
        };
        assert_eq!(
            value("OWNER"),
            Some(format!("{}:{}", mine.uid(), mine.gid()))
        );
        assert!(value("RESULTS").is_some_and(|path| path.starts_with('/')));
        let owner = value("WEBLOOP_OWNER").expect("an owner");
        assert_eq!(owner.parse(), Ok(Owner::this().expect("/proc is there")));
    }
}
