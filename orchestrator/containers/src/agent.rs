//! The agent behind its routes: its claim, its current run, and how both change.

mod answer;
mod catalogue;
mod claim;
pub(crate) mod config;
mod refusal;
mod route;
mod run;
mod seat;
pub(crate) mod serve;
mod server;
mod shelf;

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use endpoint::Hosts;
use tokio::sync::Notify;
use tokio::task::spawn_blocking;
use tokio::time::Instant;

use crate::agent::claim::Claim;
use crate::agent::config::Config;
use crate::agent::refusal::Refusal;
use crate::agent::run::{Run, lock};
use crate::name::Name;
use crate::token::Token;
use crate::wire::Health;
use process::STOP_WITHIN;

/// State that all requests share. One thread serves them all and no request holds a `std` lock
/// while it waits, so these locks are always free.
pub(crate) struct Agent {
    pub(crate) config: Config,
    /// The folder in which the runs have their folders.
    scratch: PathBuf,
    claim: Mutex<Claim>,
    /// The names that it answers to.
    pub(crate) hosts: Hosts,
    run: Mutex<Option<Arc<Run>>>,
    /// Held while the run changes, so that one is gone before the next begins.
    change: tokio::sync::Mutex<()>,
    /// Notified of each claim, which can bring the end of the agent forward.
    pub(crate) claimed: Notify,
    /// Notified when the orchestrator wants the agent to end.
    pub(crate) ending: Notify,
    ended: AtomicBool,
}

impl Agent {
    pub(crate) fn new(config: &Config, scratch: PathBuf) -> Agent {
        Agent {
            claim: Mutex::new(Claim::new(config, Instant::now())),
            hosts: Hosts::new(config.hosts.iter().cloned().chain([own_name()])),
            config: config.clone(),
            scratch,
            run: Mutex::default(),
            change: tokio::sync::Mutex::default(),
            claimed: Notify::new(),
            ending: Notify::new(),
            ended: AtomicBool::new(false),
        }
    }

    pub(crate) fn claim(&self) -> MutexGuard<'_, Claim> {
        lock(&self.claim)
    }

    /// Admits a request if its token is right; [`Claim::answered`] has to follow.
    pub(crate) fn enter(&self, presented: Option<&Token>) -> Result<(), Refusal> {
        let mut claim = self.claim();
        let claimed = claim.claimed();
        claim.enter(presented, Instant::now())?;
        if !claimed {
            self.claimed.notify_one();
        }
        Ok(())
    }

    /// Ends the current run and allows no other after it.
    pub(crate) async fn close(&self, within: Duration) {
        self.ended.store(true, Ordering::Relaxed);
        let run = lock(&self.run).take();
        if let Some(run) = run {
            run.end(within).await;
        }
    }

    /// Begins a run in an empty folder. Ends the previous run and wipes its folder.
    pub(crate) async fn begin(&self, id: Name) -> Result<(), Refusal> {
        let _change = self.change.lock().await;
        self.wipe_current().await?;
        let folder = self.scratch.join(id.as_str());
        let made = folder.clone();
        off_thread(move || Ok(shelf::make_empty(&made)?)).await?;
        if self.ended.load(Ordering::Relaxed) {
            return Err(Refusal::Ending);
        }
        lock(&self.run).replace(Arc::new(Run::new(id, folder)));
        Ok(())
    }

    /// Ends a run and wipes its folder.
    pub(crate) async fn finish(&self, id: &Name) -> Result<(), Refusal> {
        let _change = self.change.lock().await;
        self.run(id)?;
        self.wipe_current().await
    }

    async fn wipe_current(&self) -> Result<(), Refusal> {
        // Take it out first, so that no other role starts in it.
        let run = lock(&self.run).take();
        if let Some(run) = run {
            run.end(STOP_WITHIN).await;
            let folder = run.folder.clone();
            off_thread(move || Ok(shelf::wipe(&folder)?)).await?;
        }
        Ok(())
    }

    pub(crate) fn run(&self, id: &Name) -> Result<Arc<Run>, Refusal> {
        lock(&self.run)
            .as_ref()
            .filter(|run| run.id == *id)
            .cloned()
            .ok_or_else(|| Refusal::Run(id.clone()))
    }

    pub(crate) fn health(&self) -> Health {
        Health {
            agent: self.config.name,
            webloop: env!("CARGO_PKG_VERSION").to_owned(),
            claimed: self.claim().claimed(),
        }
    }
}

/// The name of this machine.
fn own_name() -> String {
    let system = rustix::system::uname();
    system.nodename().to_string_lossy().into_owned()
}

/// Does work that waits for the disk on a thread that may block.
pub(crate) async fn off_thread<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Refusal> + Send + 'static,
) -> Result<T, Refusal> {
    spawn_blocking(work)
        .await
        .map_err(|problem| Refusal::Disk(std::io::Error::other(problem)))?
}
