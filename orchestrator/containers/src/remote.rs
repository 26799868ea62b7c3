//! The orchestrator's side of an agent: calls from plain threads that wait for their answers.
//!
//! The back-end decides what to start, and when.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use reqwest::Method;

use crate::error::Error;
use crate::exchange::{Exchange, Part};
use crate::name::{AgentName, Name};
use crate::token::Token;
use crate::wire::{Health, RoleState};
use crate::wire::{StartRole, Started};
use process::Seen;
use process::Stop;
use process::{READY_WITHIN, STOP_WITHIN};

/// Time limit for what the agent does at once: a busy machine needs some ms.
const PROMPT: Duration = Duration::from_secs(5);

/// Added to the time that the agent itself allows a role.
const MARGIN: Duration = Duration::from_secs(5);

/// Most bytes of a file of somebody's own program that are taken.
const OWN_BYTES: u64 = 64 << 20;

/// Pause before asking an agent again that does not answer yet.
const RETRY: Duration = Duration::from_millis(100);

/// An agent as its orchestrator sees it. Clones refer to the same agent.
#[derive(Clone, Debug)]
pub struct Remote {
    name: AgentName,
    exchange: Arc<Exchange>,
}

/// A run at an agent, from [`Remote::begin`] to [`RemoteRun::finish`].
///
/// Dropping it does not end the run: the next run does, or the end of the agent.
#[derive(Clone, Debug)]
pub struct RemoteRun {
    remote: Remote,
    id: Name,
}

/// Asks once, without a token, who answers at `authority`: for health checks.
///
/// # Errors
/// [`Error`] when no agent answers within 2 s.
pub fn health(authority: &str) -> Result<Health, Error> {
    let exchange = Exchange::open("agent", authority, None)?;
    let body = exchange.ask(Method::GET, &["health"], Duration::from_secs(2))?;
    exchange.read(&body)
}

impl Remote {
    /// Prepares requests to the agent `name` at `authority`, such as `plant.control:7070`. Nothing
    /// is sent yet; the host name is looked up for each connection.
    ///
    /// # Errors
    /// [`Error::Authority`] when `authority` is not an address.
    pub fn open(name: AgentName, authority: &str, token: Token) -> Result<Remote, Error> {
        Ok(Remote {
            name,
            exchange: Arc::new(Exchange::open(&name.to_string(), authority, Some(token))?),
        })
    }

    /// Name of the agent.
    #[must_use]
    pub fn name(&self) -> AgentName {
        self.name
    }

    /// Waits until the agent answers, and checks its name and version.
    ///
    /// # Errors
    /// [`Error::Unanswered`] after `within`; [`Error::Stranger`] when another agent or version answers.
    pub fn wait_healthy(&self, within: Duration) -> Result<Health, Error> {
        let deadline = Instant::now() + within;
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            // Each try is short, since the host or its name may appear meanwhile.
            let patience = left.clamp(RETRY, Duration::from_secs(2));
            let health = self
                .exchange
                .ask(Method::GET, &["health"], patience)
                .and_then(|body| self.exchange.read(&body));
            match health {
                Ok(health) => return self.expect_itself(health),
                Err(Error::Unanswered { .. }) if Instant::now() + RETRY < deadline => {
                    thread::sleep(RETRY);
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// Claims the agent, or tells it that its orchestrator is still there: it ends when it hears
    /// nothing for too long.
    ///
    /// # Errors
    /// [`Error::Refused`] when it belongs to another orchestrator.
    pub fn claim(&self) -> Result<(), Error> {
        self.exchange
            .ask(Method::POST, &["claim"], PROMPT)
            .map(drop)
    }

    /// Begins a run in an empty folder there. Ends the previous run and wipes its folder.
    ///
    /// # Errors
    /// [`Error`] when the request fails, or `id` is not a plain name.
    pub fn begin(&self, id: &str) -> Result<RemoteRun, Error> {
        let id: Name = id.parse()?;
        let within = STOP_WITHIN + MARGIN;
        self.exchange
            .ask(Method::PUT, &["run", id.as_str()], within)?;
        Ok(RemoteRun {
            remote: self.clone(),
            id,
        })
    }

    /// Ends the agent. It answers first, so it may still be there for up to a second.
    ///
    /// # Errors
    /// [`Error`] when the request fails.
    pub fn end(&self) -> Result<(), Error> {
        self.exchange.ask(Method::POST, &["end"], PROMPT).map(drop)
    }

    fn expect_itself(&self, health: Health) -> Result<Health, Error> {
        let here = env!("CARGO_PKG_VERSION");
        if health.agent == self.name && health.webloop == here {
            return Ok(health);
        }
        Err(Error::Stranger {
            agent: self.name,
            authority: self.exchange.authority().to_owned(),
            found: format!(
                "{} of webloop {}, not {} of {here}",
                health.agent, health.webloop, self.name
            ),
        })
    }
}

impl RemoteRun {
    /// The agent that has the run.
    #[must_use]
    pub fn remote(&self) -> &Remote {
        &self.remote
    }

    /// Starts `role` there as `instance` and waits until it is ready. Returns what it says then.
    ///
    /// # Errors
    /// [`Error::Refused`] with the role's last words when it did not become ready; the kind is
    /// [`ProblemKind::Unsupported`](crate::ProblemKind::Unsupported) when the machine there lacks something.
    pub fn start(
        &self,
        instance: &str,
        role: &str,
        settings: serde_json::Value,
    ) -> Result<String, Error> {
        let instance: Name = instance.parse()?;
        let asked = StartRole {
            role: role.to_owned(),
            settings,
        };
        let path = ["run", self.id.as_str(), "role", instance.as_str()];
        let within = READY_WITHIN + MARGIN;
        let answer = self.exchange().tell(&path, &asked, within)?;
        let Started { ready } = self.exchange().read(&answer)?;
        Ok(ready)
    }

    /// State of a role.
    ///
    /// # Errors
    /// [`Error`] when the request fails.
    pub fn state(&self, instance: &str) -> Result<RoleState, Error> {
        self.about_role(Method::GET, instance, PROMPT)
    }

    /// What a role has looked like from outside since its start, also after its end.
    ///
    /// # Errors
    /// [`Error`] when the request fails.
    pub fn seen(&self, instance: &str) -> Result<Seen, Error> {
        let instance: Name = instance.parse()?;
        let path = ["run", self.id.as_str(), "role", instance.as_str(), "seen"];
        let body = self.exchange().ask(Method::GET, &path, PROMPT)?;
        self.exchange().read(&body)
    }

    /// Will let a role stand still at these times, in order.
    ///
    /// # Errors
    /// [`Error`] when the request fails.
    pub fn freeze(&self, instance: &str, stops: &[Stop]) -> Result<(), Error> {
        let instance: Name = instance.parse()?;
        let path = ["run", self.id.as_str(), "role", instance.as_str(), "freeze"];
        self.exchange().tell(&path, &stops, PROMPT).map(drop)
    }

    /// Kills a role, so that another may be started as this instance. Returns what it has looked like.
    ///
    /// # Errors
    /// [`Error`] when the request fails.
    pub fn kill(&self, instance: &str) -> Result<Seen, Error> {
        let instance: Name = instance.parse()?;
        let path = ["run", self.id.as_str(), "role", instance.as_str(), "kill"];
        let body = self.exchange().ask(Method::POST, &path, PROMPT)?;
        self.exchange().read(&body)
    }

    /// Ends a role by SIGTERM, and after 5 s by SIGKILL. Returns how it ended.
    ///
    /// # Errors
    /// [`Error`] when the request fails.
    pub fn stop(&self, instance: &str) -> Result<RoleState, Error> {
        self.about_role(Method::DELETE, instance, STOP_WITHIN + MARGIN)
    }

    /// The files there, with their lengths in bytes.
    ///
    /// # Errors
    /// [`Error`] when the request fails.
    pub fn files(&self) -> Result<BTreeMap<String, u64>, Error> {
        let path = ["run", self.id.as_str(), "files"];
        let body = self.exchange().ask(Method::GET, &path, PROMPT)?;
        self.exchange().read(&body)
    }

    /// A whole file; `None` if it does not exist.
    ///
    /// # Errors
    /// [`Error`] when the request fails.
    pub fn file(&self, name: &str) -> Result<Option<Vec<u8>>, Error> {
        if !self.files()?.contains_key(name) {
            return Ok(None);
        }
        let mut whole = Vec::new();
        loop {
            let part = self.part(name, whole.len() as u64)?;
            whole.extend_from_slice(&part.bytes);
            if part.bytes.is_empty() || whole.len() as u64 >= part.size {
                return Ok(Some(whole));
            }
        }
    }

    /// Copies what a program of somebody's own left in its folder there into `folder`, which is made where
    /// there is anything.
    ///
    /// # Errors
    /// [`Error`] when a request fails, or a file cannot be written here.
    pub fn take_own(&self, folder: &Path) -> Result<(), Error> {
        let path = ["run", self.id.as_str(), "own", "files"];
        let files: BTreeMap<String, u64> = {
            let body = self.exchange().ask(Method::GET, &path, PROMPT)?;
            self.exchange().read(&body)?
        };
        for (name, size) in files {
            // The agent is in the same container as the program.
            let name: Name = name.parse()?;
            let path = ["run", self.id.as_str(), "own", "file", name.as_str()];
            let mut bytes = Vec::new();
            while (bytes.len() as u64) < size.min(OWN_BYTES) {
                let part = self.exchange().part(&path, bytes.len() as u64, PROMPT)?;
                if part.bytes.is_empty() {
                    break;
                }
                bytes.extend_from_slice(&part.bytes);
            }
            let here = folder.join(name.as_str());
            fs::create_dir_all(folder)
                .and_then(|()| fs::write(&here, &bytes))
                .map_err(|source| Error::write(&here, source))?;
        }
        Ok(())
    }

    /// Ends the run's roles and wipes its folder there.
    ///
    /// # Errors
    /// [`Error`] when the request fails.
    pub fn finish(self) -> Result<(), Error> {
        let path = ["run", self.id.as_str()];
        self.exchange()
            .ask(Method::DELETE, &path, STOP_WITHIN + MARGIN)
            .map(drop)
    }

    pub(crate) fn part(&self, name: &str, from: u64) -> Result<Part, Error> {
        let path = ["run", self.id.as_str(), "file", name];
        self.exchange().part(&path, from, PROMPT)
    }

    fn about_role(
        &self,
        method: Method,
        instance: &str,
        within: Duration,
    ) -> Result<RoleState, Error> {
        let instance: Name = instance.parse()?;
        let path = ["run", self.id.as_str(), "role", instance.as_str()];
        let body = self.exchange().ask(method, &path, within)?;
        self.exchange().read(&body)
    }

    fn exchange(&self) -> &Exchange {
        &self.remote.exchange
    }
}
