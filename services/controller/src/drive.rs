//! The entry point: warms up, runs the deadlines, waits for messages under way, reports.

use std::{
    future::{Future, poll_fn},
    io,
    pin::Pin,
    pin::pin,
    task::{Context, Poll, Waker},
    time::Duration,
};

use clock::journal::{Journal, Kept, Recorder};
use clock::{alarm::Alarm, now::now_ns, scheduling::Granted};
use endpoint::{ControllerEnd, Loss, MessageRow, Signals, Step, report};
use futures_util::{StreamExt, stream::FuturesUnordered};
use text::column::Row;
use tokio::runtime::LocalOptions;

use crate::{
    config::{Config, DriveError},
    transport::{Address, Ended, ExchangeError, Http, Pool, Tcp, Transport, Udp, WebSocket},
};

/// Just below the plant's ticker, like the plant's own HTTP thread.
const FIFO_PRIORITY: u8 = 45;

/// How long to wait for a plant that is still starting.
const WARM_UP: Duration = Duration::from_secs(10);

/// Pause between requests to a plant that does not answer yet.
const WARM_UP_PAUSE: Duration = Duration::from_millis(50);

/// If no start is given, it is this long after the warm-up.
const START_AHEAD_NS: u64 = 200_000_000;

/// Runs a controller for its duration, or until SIGTERM or SIGINT. The calling thread keeps the
/// scheduling that it was granted.
///
/// # Errors
/// [`DriveError`], with what was not available or which rows are missing. A message that fails is a
/// row, not an error.
pub fn drive(config: &Config) -> Result<report::Native, DriveError> {
    drive_until(config, clock::stop::told_to_end())
}

/// Like [`drive`], but runs until `stop` is done instead of a signal.
///
/// # Errors
/// Those of [`drive`].
pub fn drive_until(
    config: &Config,
    stop: impl Future<Output = io::Result<()>>,
) -> Result<report::Native, DriveError> {
    let settings = &config.settings;
    settings.check()?;
    if config.claim {
        settings.check_session()?;
    }
    if config.check {
        settings.check_checksum()?;
    }
    let address = Address::parse(&config.plant)?;
    let http = Http::new(Pool::new(&address, config), config);
    match settings.transport {
        endpoint::Transport::Http | endpoint::Transport::Json => drive_by(http, config, stop),
        endpoint::Transport::Tcp => drive_by(Tcp::conduit(http, &address, config), config, stop),
        endpoint::Transport::Udp => drive_by(Udp::new(http, &address, config), config, stop),
        endpoint::Transport::WebSocket => {
            drive_by(WebSocket::conduit(http, &address, config)?, config, stop)
        }
    }
}

fn drive_by(
    mut transport: impl Transport,
    config: &Config,
    stop: impl Future<Output = io::Result<()>>,
) -> Result<report::Native, DriveError> {
    // The journal's thread must not inherit real-time scheduling.
    let path = config.out.join(MessageRow::FILE);
    let (rows, journal, _) =
        Journal::open(&path, MessageRow::COLUMNS, MessageRow::write, config.again)?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build_local(LocalOptions::default())?;
    let granted = clock::scheduling::ask(config.scheduling.priority(FIFO_PRIORITY));
    let open_files = clock::limit::raise_open_files();

    runtime.block_on(async {
        // Polled when it is woken itself, and not with every message.
        let mut stop = FuturesUnordered::from_iter([stop]);
        let mut stop = pin!(async move { stop.next().await.unwrap_or(Ok(())) });
        // If stopped before the plant was read, y is 0, the output at rest.
        let (y, stopped) = tokio::select! {
            y = warm_up(config, &mut transport) => (y?, false),
            result = &mut stop => (0.0.into(), result.map(|()| true)?),
        };
        let start_ns = config.start_ns.unwrap_or_else(|| now_ns() + START_AHEAD_NS);
        let stop_ns = start_ns.saturating_add(config.duration_ns);
        let mut end =
            ControllerEnd::try_new(config.settings, config.law.clone(), y, start_ns, stop_ns)?
                .following(config.reference.clone());
        if config.again {
            end = end.resumed(now_ns());
        }
        let mut run = Run {
            end,
            transport,
            rows,
            first_failure: None,
        };
        let interrupted = stopped || run.deadlines(&granted, stop).await?;
        run.transport.close().await;
        let Kept { rows, overflow } = journal.finish(run.rows)?;
        Ok(report::Native {
            start_ns,
            stop_ns,
            counts: run.end.counts(),
            first_failure: run.first_failure,
            interrupted,
            rows: report::Written { rows, overflow },
            granted: report::ControllerGranted {
                controller: report::Scheduling::new(
                    granted.asked_priority,
                    granted.fifo_priority,
                    granted.slack_ns,
                    granted.refused,
                ),
                open_files,
            },
        })
    })
}

/// Waits for the plant, opens the connections, and returns the plant's output.
async fn warm_up(config: &Config, transport: &mut impl Transport) -> Result<Signals, DriveError> {
    let mut why = String::from("no attempt ended");
    let answers = async {
        loop {
            match transport.observe().await {
                Ok(observation) => return observation.y,
                Err(error) => why = error.to_string(),
            }
            tokio::time::sleep(WARM_UP_PAUSE).await;
        }
    };
    let Ok(y) = tokio::time::timeout(WARM_UP, answers).await else {
        let plant = config.plant.clone();
        return Err(DriveError::Unreachable {
            plant,
            waited_s: WARM_UP.as_secs(),
            why,
        });
    };
    transport.open(config.connections).await;
    Ok(y)
}

/// A run of deadlines.
struct Run<T> {
    end: ControllerEnd,
    transport: T,
    rows: Recorder<MessageRow>,
    first_failure: Option<String>,
}

impl<T: Transport> Run<T> {
    /// Runs through all deadlines and waits for all messages; returns whether `stop` came first.
    async fn deadlines(
        &mut self,
        granted: &Granted,
        mut stop: Pin<&mut impl Future<Output = io::Result<()>>>,
    ) -> io::Result<bool> {
        let mut alarm = Alarm::new(granted)?;
        loop {
            match self.end.poll(now_ns()) {
                Step::Send(command) => {
                    self.transport.send(command);
                    continue;
                }
                Step::Missed(row) => {
                    self.rows.record(row);
                    continue;
                }
                Step::Sleep { until_ns } => alarm.set(until_ns)?,
                Step::AwaitAnswer => {}
                Step::Finished if self.end.oldest_under_way().is_none() => return Ok(false),
                Step::Finished => {}
            }
            // The deadline goes first. After it has rung, messages that have come by then are
            // processed, so that the command uses the newest output.
            tokio::select! {
                biased;
                rung = alarm.rung() => {
                    rung?;
                    let mut context = Context::from_waker(Waker::noop());
                    while let Poll::Ready(ended) = self.transport.poll_ended(&mut context) {
                        self.ended(ended);
                    }
                }
                ended = poll_fn(|context| self.transport.poll_ended(context)) => self.ended(ended),
                stopped = &mut stop => {
                    stopped?;
                    self.give_up();
                    return Ok(true);
                }
            }
        }
    }

    /// Records the end of a message.
    fn ended(&mut self, ended: Ended) {
        let Ended { seq, t_ns, result } = ended;
        let row = match result {
            Ok(answer) => self.end.answered(&answer, t_ns),
            Err(ExchangeError::Timeout) => self.end.lost(seq, Loss::Timeout, t_ns),
            Err(problem) => {
                if self.first_failure.is_none() {
                    let why = problem.to_string();
                    tracing::warn!(seq, why, "the first message failed");
                    self.first_failure = Some(why);
                }
                self.end.lost(seq, Loss::Failed, t_ns)
            }
        };
        self.rows
            .record(row.expect("each message ends once, and its answer names it"));
    }

    /// Ends every message under way as failed.
    fn give_up(&mut self) {
        let now_ns = now_ns();
        while let Some(seq) = self.end.oldest_under_way() {
            if let Some(row) = self.end.lost(seq, Loss::Failed, now_ns) {
                self.rows.record(row);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use clock::journal::ROW_BYTES;
    use endpoint::MessageOutcome;

    use super::*;

    #[test]
    fn the_longest_row_of_a_run_fits_into_its_part_of_the_buffer() {
        let number = Some(-f64::MIN_POSITIVE);
        let row = MessageRow {
            seq: u64::MAX,
            t_due_ns: u64::MAX,
            t_send_ns: Some(u64::MAX),
            t_receive_ns: Some(u64::MAX),
            t_arrive_ns: Some(u64::MAX),
            r: -f64::MIN_POSITIVE,
            y: number,
            e: number,
            u: number,
            tick: Some(u64::MAX),
            outcome: MessageOutcome::Answered,
            y_seq: None,
        };
        let mut text = Vec::new();
        MessageRow::write(&row, &mut text);
        let bytes = text.len();
        assert!((200..=ROW_BYTES).contains(&bytes), "{bytes}");
    }
}
