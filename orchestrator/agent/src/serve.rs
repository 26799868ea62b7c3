//! The entry: sets an agent up, waits for what ends it, and leaves nothing behind.

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
use crate::{Config, Ended, Error, route, server, shelf};

/// How long the roles of an agent that ends may take to write their rows. With the connections'
/// time it is below a second, the most that a container's end may take.
const ROLES_WITHIN: Duration = Duration::from_millis(600);

/// Threads that may wait for the disk: a container counts them among its processes.
const DISK_THREADS: usize = 4;

/// How long the last answers may take to leave.
const ANSWERS_WITHIN: Duration = Duration::from_millis(200);

/// Runs an agent until SIGTERM or SIGINT, until its orchestrator ends it, or until it is left
/// alone. All its roles end before it does, and with it if it is killed: they are children of
/// the calling thread.
///
/// `ready` is called once, when the agent can be reached.
///
/// # Errors
/// [`Error`] says what could not be had.
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

    // Its own folder, so that what it wipes is never somebody else's.
    let scratch = scratch(config);
    shelf::make_empty(&scratch).map_err(|source| Error::write(&scratch, source))?;
    let agent = Arc::new(Agent::new(config, scratch.clone()));
    let router = route::router(Arc::clone(&agent));
    let ended = runtime.block_on(async {
        let open = GracefulShutdown::new();
        let mut stop = pin!(pace::told_to_end());
        // Asked once before `ready`, so that a signal right after it is caught.
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
        // Whoever still waits for an answer gets it now; an idle connection just closes.
        let _ = timeout(ANSWERS_WITHIN, open.shutdown()).await;
        ended
    });
    // Not waiting for a thread that reads a slow disk.
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

/// Done when the agent has waited for its orchestrator for too long. It wakes for that alone,
/// not for each request.
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
