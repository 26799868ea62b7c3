//! The entry: sets the two threads up, waits for the end, reports.

use std::{
    cell::RefCell,
    future::{Future, poll_fn},
    io,
    pin::pin,
    rc::Rc,
    task::Poll,
};

use endpoint::{ArrivalRow, Inbox, Input, Process, TickRow, report};
use journal::Journal;
use pace::now_ns;
use tokio::{sync::watch, task::LocalSet};

use crate::{
    config::{Config, Ready, ServeError},
    filer::Filer,
    handler::Handler,
    latest::latest,
    server,
    session::Control,
    ticker::{Running, Ticker, input_words},
};

/// Tick 0 is due this long after the threads are set up, so that it is not late.
const START_AHEAD_NS: u64 = 5_000_000;

/// Below the ticker: a tick goes before a request. See `ticker::FIFO_PRIORITY`.
const FIFO_PRIORITY: u8 = 45;

/// Runs a plant until SIGTERM or SIGINT. The calling thread becomes the one
/// that speaks HTTP, and keeps the scheduling that it was granted.
///
/// `ready` is called once, when the plant can be reached.
///
/// # Errors
/// [`ServeError`] says what could not be had, or which rows are missing.
pub fn serve(config: &Config, ready: impl FnOnce(Ready)) -> Result<report::Plant, ServeError> {
    serve_until(config, pace::told_to_end(), ready)
}

/// Like [`serve`], until `stop` is done.
///
/// # Errors
/// See [`serve`].
pub fn serve_until(
    config: &Config,
    stop: impl Future<Output = io::Result<()>>,
    ready: impl FnOnce(Ready),
) -> Result<report::Plant, ServeError> {
    let settings = &config.settings;
    let sampled = config.plant.sampled(settings.h.ns())?;

    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()?;
    let listener = {
        let _context = runtime.enter();
        server::listen(config.listen)
    };
    let listen_error = |source| ServeError::Listen {
        address: config.listen,
        source,
    };
    let listener = listener.map_err(listen_error)?;
    let address = listener.local_addr().map_err(listen_error)?;

    // In this order: the threads that write files must not inherit real-time
    // scheduling, and no file is made for a plant that cannot listen.
    let (tick_rows, tick_journal) =
        Journal::create::<TickRow>(&config.out.join(TickRow::FILE), TickRow::COLUMNS)?;
    let (arrival_rows, arrival_journal) =
        Journal::create::<ArrivalRow>(&config.out.join(ArrivalRow::FILE), ArrivalRow::COLUMNS)?;
    let filer = Filer::start(&config.out)?;
    let (input_publisher, input_reader) = latest(input_words(Input::default()));
    let (output_publisher, output_reader) = latest([0; 2]);
    let start_ns = now_ns() + START_AHEAD_NS;
    let mut ticker = Ticker {
        process: Process::new(settings, sampled.stepper(), start_ns),
        h_ns: settings.h.ns(),
        input: input_reader,
        output: output_publisher,
        rows: tick_rows,
        fifo: config.fifo,
    }
    .start()?;
    let server_scheduling = pace::ask(config.fifo.then_some(FIFO_PRIORITY));
    let open_files = pace::raise_open_files();

    let handler = Rc::new(RefCell::new(Handler {
        settings: *settings,
        law: config.law.clone(),
        inbox: Inbox::new(settings.late),
        input: input_publisher,
        output: output_reader,
        rows: arrival_rows,
        refused: 0,
        control: Control::new(),
        filer,
        over: watch::Sender::new(0),
    }));
    let accepted = RefCell::new(0);
    let tasks = LocalSet::new();
    let ended = tasks.block_on(&runtime, async {
        let mut stop = pin!(stop);
        // Asked once before `ready`, so that a signal right after it is caught.
        if let Poll::Ready(result) = poll_fn(|context| Poll::Ready(stop.as_mut().poll(context))).await {
            return result.map_err(ServeError::Start);
        }
        ready(Ready { address, start_ns });
        tokio::select! {
            result = stop => result.map_err(ServeError::Start),
            _ = &mut ticker.ended => Err(ServeError::Ticker),
            never = server::accept(listener, Rc::clone(&handler), &accepted, open_files) => match never {},
        }
    });
    // The connections hold the handler: they end here.
    drop(tasks);
    let ticked = Running::stop(ticker).ok_or(ServeError::Ticker)?;
    let handler = Rc::into_inner(handler)
        .expect("all connections are gone")
        .into_inner();

    // All files are ended before any's error is told.
    let tick_written = tick_journal.finish(ticked.rows);
    let arrival_written = arrival_journal.finish(handler.rows);
    let filed = handler.filer.finish();
    ended?;
    let tick_rows = tick_written?;
    let arrival_rows = arrival_written?;
    if let Some(problem) = filed.problem {
        return Err(problem.into());
    }
    Ok(report::Plant {
        address,
        start_ns,
        ticks: ticked.ticks,
        missed: ticked.missed,
        arrivals: handler.inbox.arrivals(),
        refused: handler.refused,
        connections: accepted.into_inner(),
        tick_rows,
        arrival_rows,
        sessions: handler.control.sessions(),
        page_rows: filed.written,
        granted: report::PlantGranted {
            ticker: ticked.scheduling,
            server: server_scheduling,
            open_files,
        },
    })
}
