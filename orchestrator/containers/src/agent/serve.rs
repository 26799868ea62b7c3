//! The entry point: sets an agent up, waits for its end, and leaves nothing behind.

use std::future::{Future, poll_fn};
use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::pin::pin;
use std::sync::Arc;
use std::task::Poll;
use std::time::Duration;

use hyper_util::server::graceful::GracefulShutdown;
use tokio::time::{Instant, sleep_until, timeout};

use crate::agent::Agent;
use crate::agent::config::{Config, Ended};
use crate::agent::route;
use crate::agent::server;
use crate::agent::shelf;
use crate::error::Error;

/// How long roles may take to write their rows when the agent ends. Together with the connections'
/// time this is below a second, the limit for the end of a container.
const ROLES_WITHIN: Duration = Duration::from_millis(600);

/// Maximum number of threads that wait for the disk: a container counts them as processes.
const DISK_THREADS: usize = 4;

/// How long sending the last answers may take.
const ANSWERS_WITHIN: Duration = Duration::from_millis(200);

/// Runs an agent until SIGTERM or SIGINT, until its orchestrator ends it, or until no orchestrator
/// has been heard for too long. All its roles end before it does. If it is killed, they die with
/// it: they are children of the calling thread.
///
/// `ready` is called once, when the agent can be reached.
///
/// # Errors
/// [`Error`] when it cannot listen, start its runtime, or write its folder.
pub fn serve(config: &Config, ready: impl FnOnce(SocketAddr)) -> Result<Ended, Error> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .max_blocking_threads(DISK_THREADS)
        .build()?;
    let listen_error = |source| Error::Listen {
        address: config.listen,
        source,
    };
    let listener = {
        let _context = runtime.enter();
        server::listen(config.listen)
    };
    let listener = listener.map_err(listen_error)?;
    let address = listener.local_addr().map_err(listen_error)?;

    // A folder of its own, so that it never wipes the files of others.
    let scratch = scratch(config);
    shelf::make_empty(&scratch).map_err(|source| Error::write(&scratch, source))?;
    let agent = Arc::new(Agent::new(config, scratch.clone()));
    let router = route::router(Arc::clone(&agent));
    let ended = runtime.block_on(async {
        let open = GracefulShutdown::new();
        let mut stop = pin!(clock::stop::told_to_end());
        // Poll once before `ready`, so that a signal right after it is caught.
        if let Poll::Ready(result) =
            poll_fn(|context| Poll::Ready(stop.as_mut().poll(context))).await
        {
            return result.map(|()| Ended::Signalled);
        }
        ready(address);
        let ended = tokio::select! {
            result = stop => result.map(|()| Ended::Signalled),
            () = agent.ending.notified() => Ok(Ended::Asked),
            ended = left_alone(&agent) => Ok(ended),
            never = server::accept(&listener, &router, &open) => match never {},
        };
        agent.close(ROLES_WITHIN).await;
        // Answers in progress are still sent; an idle connection just closes.
        let _ = timeout(ANSWERS_WITHIN, open.shutdown()).await;
        ended
    });
    // Do not wait for a thread that reads a slow disk.
    runtime.shutdown_background();
    let wiped = shelf::wipe(&scratch).map_err(|source| Error::write(&scratch, source));
    let ended = ended.map_err(|problem: io::Error| Error::Start(problem))?;
    wiped?;
    Ok(ended)
}

/// The folder of an agent's runs.
fn scratch(config: &Config) -> PathBuf {
    config.scratch.join(format!("webloop-{}", config.name))
}

/// Returns when the agent has waited for its orchestrator for too long. It wakes up for that and
/// for claims, not for each request.
async fn left_alone(agent: &Agent) -> Ended {
    loop {
        let ends = agent.claim().ends(Instant::now());
        if Instant::now() >= ends {
            return agent.claim().ended();
        }
        tokio::select! {
            () = sleep_until(ends) => {}
            () = agent.claimed.notified() => {}
        }
    }
}
