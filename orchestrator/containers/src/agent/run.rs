//! The current run of an agent: a folder, and the roles that were started for it.
//!
//! Everything here runs on one thread. Nothing blocks that thread longer than a fork, or than the
//! kernel needs to end a killed process: whoever waits for a role to become ready or to end polls
//! for it.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::time::{Instant, sleep};

use crate::agent::catalogue;
use crate::agent::refusal::Refusal;
use crate::name::Name;
use crate::wire::{ProblemKind, RoleState, StartRole};
use process::Error;
use process::Role;
use process::Seen;
use process::Stop;
use process::exit_code;
use process::{Launch, POLL, READY_WITHIN, last_words};

/// The most roles of a run, which has fewer than ten: each is a process, and its last state is kept.
const ROLES: usize = 64;

/// A role of the run; several requests may wait for it.
type Shared = Arc<Mutex<Role>>;

/// A run, from its beginning to its end.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) id: Name,
    pub(crate) folder: PathBuf,
    roles: Mutex<BTreeMap<Name, Shared>>,
}

impl Run {
    pub(crate) fn new(id: Name, folder: PathBuf) -> Run {
        Run {
            id,
            folder,
            roles: Mutex::default(),
        }
    }

    /// Starts a role and waits until it is ready. Returns what it says then.
    ///
    /// The process dies with the calling thread, which must therefore not belong to a pool.
    pub(crate) async fn start(
        &self,
        program: &Path,
        instance: &Name,
        asked: &StartRole,
    ) -> Result<String, Refusal> {
        let role = catalogue::role(&asked.role)?;
        if lock(&self.roles).contains_key(instance) {
            return Err(Refusal::Taken(instance.clone()));
        }
        if lock(&self.roles).len() >= ROLES {
            return Err(Refusal::Roles(ROLES));
        }
        let launch = Launch {
            program,
            role,
            name: instance.as_str(),
            settings: &asked.settings,
            folder: &self.folder,
            is_watched: catalogue::is_watched(role),
        };
        let started = Role::launch(&launch, None::<&File>);
        let shared = Arc::new(Mutex::new(started.map_err(|error| Refusal::NotReady {
            words: error.to_string(),
            kind: ProblemKind::Failed,
        })?));
        lock(&self.roles).insert(instance.clone(), Arc::clone(&shared));
        let deadline = Instant::now() + READY_WITHIN;
        loop {
            let ready = lock(&shared).try_ready();
            match ready {
                Ok(Some(what)) => return Ok(what),
                Ok(None) if Instant::now() < deadline => sleep(POLL).await,
                Ok(None) => {
                    let error = lock(&shared).unready();
                    lock(&shared).kill();
                    return Err(self.not_ready(&error, instance, &shared));
                }
                Err(error) => return Err(self.not_ready(&error, instance, &shared)),
            }
        }
    }

    /// State of a role.
    pub(crate) fn state(&self, instance: &Name) -> Result<RoleState, Refusal> {
        let shared = self.role(instance)?;
        Ok(self.state_of(instance, &shared))
    }

    /// What a role has looked like from outside.
    pub(crate) fn seen(&self, instance: &Name) -> Result<Seen, Refusal> {
        Ok(lock(&*self.role(instance)?).seen())
    }

    /// Will let a role stand still at these times.
    pub(crate) fn freeze(&self, instance: &Name, stops: Vec<Stop>) -> Result<(), Refusal> {
        lock(&*self.role(instance)?).freeze(stops);
        Ok(())
    }

    /// Kills a role and forgets it, so that another may be started in its place. Returns what it has looked like.
    pub(crate) fn kill(&self, instance: &Name) -> Result<Seen, Refusal> {
        let shared = self.role(instance)?;
        let mut role = lock(&shared);
        role.kill();
        lock(&self.roles).remove(instance);
        Ok(role.seen())
    }

    /// Ends a role by SIGTERM, and after `within` by SIGKILL. Returns how it ended.
    pub(crate) async fn stop(
        &self,
        instance: &Name,
        within: Duration,
    ) -> Result<RoleState, Refusal> {
        let shared = self.role(instance)?;
        let killed = end(std::slice::from_ref(&shared), within).await;
        let mut state = self.state_of(instance, &shared);
        if let RoleState::Ended { words, .. } = &mut state
            && killed
        {
            let late = format!("did not end within {within:?} of SIGTERM and was killed");
            *words = [late, std::mem::take(words)].join("\n").trim().to_owned();
        }
        Ok(state)
    }

    /// Ends all roles by SIGTERM, and after `within` by SIGKILL.
    pub(crate) async fn end(&self, within: Duration) {
        let roles: Vec<Shared> = lock(&self.roles).values().cloned().collect();
        end(&roles, within).await;
    }

    fn role(&self, instance: &Name) -> Result<Shared, Refusal> {
        lock(&self.roles)
            .get(instance)
            .cloned()
            .ok_or_else(|| Refusal::Instance(instance.clone()))
    }

    fn state_of(&self, instance: &Name, shared: &Shared) -> RoleState {
        let code = match lock(shared).status() {
            Ok(None) => return RoleState::Running,
            Ok(Some(status)) => exit_code(status),
            // The kernel does not know the process any more: it has ended in an unknown way.
            Err(_) => -1,
        };
        let words = match code {
            0 => String::new(),
            _ => last_words(&self.folder, instance.as_str()),
        };
        RoleState::Ended { code, words }
    }

    fn not_ready(&self, error: &Error, instance: &Name, shared: &Shared) -> Refusal {
        let (kind, words) = match self.state_of(instance, shared) {
            RoleState::Ended { code, words } => (ProblemKind::of_exit(code), words),
            RoleState::Running => (ProblemKind::Failed, String::new()),
        };
        let words = [error.to_string(), words].join(": ");
        Refusal::NotReady {
            words: words.trim_end_matches(": ").to_owned(),
            kind,
        }
    }
}

/// Ends roles together. Returns whether one had to be killed.
async fn end(roles: &[Shared], within: Duration) -> bool {
    let running = |role: &&Shared| matches!(lock(role).status(), Ok(None));
    for role in roles {
        lock(role).terminate();
    }
    let deadline = Instant::now() + within;
    while Instant::now() < deadline {
        if !roles.iter().any(|role| running(&role)) {
            return false;
        }
        sleep(POLL).await;
    }
    let late: Vec<&Shared> = roles.iter().filter(running).collect();
    for role in &late {
        lock(role).kill();
    }
    !late.is_empty()
}

/// Locks a mutex, even if a request panicked while it held it: requests leave nothing half done.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
