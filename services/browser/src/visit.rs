//! The entry point: starts a browser at the plant's page, watches it, ends it, reports.

use std::{future::Future, io, pin::pin};

use endpoint::report::{self, Browser, Confinement, Sandbox, Written};

use crate::{
    attempt::{Attempt, Visit},
    config::{Config, VisitError, refused},
    engine::find,
    plant::{Plant, State, Status, Unanswered},
    watch::Watch,
};

/// Runs a visit to its end, or until SIGTERM or SIGINT. Calls `ready` when the page holds the
/// session. If the leash provides for it, the browser dies with the calling thread.
///
/// # Errors
/// [`VisitError`] names every failure, each after a bounded time. The browser is gone by then, too.
pub fn visit(config: &Config, ready: impl FnOnce()) -> Result<report::Visit, VisitError> {
    visit_until(config, clock::stop::told_to_end(), ready)
}

/// Like [`visit`], but runs until `stop` is done instead of a signal.
///
/// # Errors
/// Those of [`visit`].
pub fn visit_until(
    config: &Config,
    stop: impl Future<Output = io::Result<()>>,
    ready: impl FnOnce(),
) -> Result<report::Visit, VisitError> {
    config.settings.check()?;
    config.page.check(&config.settings)?;
    let program = find(config.engine)?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(refused(config.engine, "start its launcher"))?;
    runtime.block_on(async {
        let mut ready = Some(ready);
        let mut stop = pin!(stop);
        let plant = Plant::at(config.plant).map_err(|error| {
            refused(config.engine, "connect to its plant")(io::Error::other(error))
        })?;
        let mut visit = Visit {
            config,
            program,
            plant,
            sandbox: true,
            reason: None,
        };
        let told = tokio::select! {
            free = visit.plant_is_free() => free.map(|()| false)?,
            told = &mut stop => told.map(|()| true).map_err(refused(config.engine, "hear signals"))?,
        };
        if told {
            return Ok(visit.report(Attempt {
                interrupted: true,
                ..Attempt::default()
            }));
        }
        loop {
            match visit.attempt(stop.as_mut(), &mut ready).await? {
                Some(report) => return Ok(report),
                None => tracing::warn!("{} runs without its sandbox", config.engine),
            }
        }
    })
}

impl Visit<'_> {
    /// Waits for the plant, and makes sure that no other client controls it.
    async fn plant_is_free(&self) -> Result<(), VisitError> {
        let (plant, within) = (self.config.plant, self.config.limits.plant);
        let unreachable = |why: Unanswered| VisitError::Unreachable {
            plant,
            waited_s: within.as_secs(),
            why: why.to_string(),
        };
        let well = self.plant.is_well_within(within);
        well.await.map_err(unreachable)?;
        match self.plant.status().await.map_err(unreachable)? {
            Status {
                state: State::Held,
                client,
                ..
            } => Err(VisitError::Taken { plant, client }),
            _ => Ok(()),
        }
    }

    pub(crate) fn report(&self, attempt: Attempt) -> report::Visit {
        let Config {
            engine,
            start_ns,
            duration_ns,
            ..
        } = *self.config;
        let watch = attempt.watch;
        let session = watch.as_ref().and_then(Watch::session).cloned();
        let own = rustix::process::geteuid().as_raw();
        report::Visit {
            client: engine,
            start_ns,
            stop_ns: start_ns.map(|start_ns| start_ns.saturating_add(duration_ns)),
            interrupted: attempt.interrupted,
            rows: Written {
                rows: session.as_ref().map_or(0, |session| session.rows),
                overflow: 0,
            },
            session,
            browser: Browser {
                version: self.program.version.clone(),
                program: self.program.path.clone(),
                arguments: attempt.arguments,
                sandbox: Sandbox {
                    kind: attempt.kind.unwrap_or(Confinement::Unknown),
                    user: attempt.user.unwrap_or(own),
                    reason: self.reason.clone(),
                },
                opened_ms: watch
                    .and_then(|watch| watch.opened())
                    .and_then(|opened| u64::try_from(opened.as_millis()).ok()),
            },
        }
    }
}
