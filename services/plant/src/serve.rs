//! The entry point: starts the two threads, waits for the end, reports.

use std::{
    cell::{OnceCell, RefCell},
    collections::BTreeMap,
    future::{Future, poll_fn},
    io,
    net::SocketAddr,
    path::PathBuf,
    pin::pin,
    rc::Rc,
    task::Poll,
};

use clock::journal::{Journal, JournalError, Kept, Recorder};
use clock::{now::now_ns, scheduling::Granted};
use endpoint::{ArrivalRow, Hosts, Inbox, Model, Process, SampleTime, SecondRow, TickRow, report};
use futures_util::{StreamExt, stream::FuturesUnordered};
use text::column::Row;
use tokio::{
    net::{TcpListener, UdpSocket},
    runtime::Runtime,
    sync::watch,
    task::LocalSet,
};

use crate::{
    config::{Config, Ready, ServeError},
    datagram,
    filer::Filer,
    handler::Handler,
    latest::latest,
    server,
    session::Control,
    shared::Shared,
    ticker::{Running, Ticker, input_words, output_words},
};

/// Tick 0 is due this long after the threads have been started, so that it is not late.
const START_AHEAD_NS: u64 = 5_000_000;

/// Below the ticker, so that a tick precedes a request. See `ticker::FIFO_PRIORITY`.
const FIFO_PRIORITY: u8 = 45;

/// Runs a plant until SIGTERM or SIGINT; `model` advances by the settings' h at a step, and is at rest. The
/// calling thread serves HTTP and keeps the scheduling that it was granted.
///
/// Calls `ready` once, when the plant can be reached.
///
/// # Errors
/// [`ServeError`], with what was not available or which rows are missing.
pub fn serve(
    config: &Config,
    model: impl Model + Send + 'static,
    ready: impl FnOnce(Ready),
) -> Result<report::Plant, ServeError> {
    serve_until(config, model, clock::stop::told_to_end(), ready)
}

/// Like [`serve`], but runs until `stop` is done instead of a signal.
///
/// # Errors
/// Those of [`serve`].
pub fn serve_until(
    config: &Config,
    model: impl Model + Send + 'static,
    stop: impl Future<Output = io::Result<()>>,
    ready: impl FnOnce(Ready),
) -> Result<report::Plant, ServeError> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()?;
    let (listener, address) = listen(config.listen, &runtime)?;
    let datagrams = config
        .settings
        .udp
        .then(|| bind(address, &runtime))
        .transpose()?;
    // No files are created for a plant that cannot listen.
    let mut plant = Started::new(config, Box::new(model))?;
    let (start_ns, open_files) = (plant.start_ns, plant.open_files);

    let handler = Rc::clone(&plant.handler);
    let accepted = RefCell::new(0);
    let tasks = LocalSet::new();
    let shared = Rc::new(Shared::new(handler));
    if let Some(socket) = datagrams {
        tasks.spawn_local(datagram::serve(socket, Rc::clone(&shared)));
    }
    let served = async {
        tokio::select! {
            _ = &mut plant.ticker.ended => ServeError::Ticker,
            never = server::accept(listener, shared, &accepted, open_files) => match never {},
        }
    };
    let ready = || ready(Ready { address, start_ns });
    // Polled when it is woken itself, and not with every connection.
    let mut end = FuturesUnordered::from_iter([end(stop, ready, served)]);
    let ended = tasks.block_on(&runtime, end.next());
    let ended = ended.expect("it has one end");
    drop(end);
    // The connections hold the handler, so they end here.
    drop(tasks);
    plant.finish(ended, address, accepted.into_inner())
}

/// The started threads of a plant, the data that they share, and their files.
struct Started {
    /// When tick 0 is due.
    start_ns: u64,
    ticker: Running,
    tick_journal: Journal,
    /// If there is a second input or output.
    second_journal: Option<Journal>,
    arrival_journal: Journal,
    handler: Rc<RefCell<Handler>>,
    /// The scheduling granted to the calling thread, which serves HTTP.
    server: Granted,
    /// Files and sockets that may be open.
    open_files: u64,
}

impl Started {
    /// Starts the threads in this order, since those that write files must not inherit real-time scheduling.
    fn new(config: &Config, model: Box<dyn Model + Send>) -> Result<Started, ServeError> {
        let settings = config.settings;
        let again = config.again;
        let ticks = config.out.join(TickRow::FILE);
        let (tick_rows, tick_journal, last_tick) =
            Journal::open(&ticks, TickRow::COLUMNS, TickRow::write, again)?;
        let inputs = model.inputs();
        let has_second = model.has_second();
        let (at_rest, can_reset) = (model.at_rest(), model.can_reset());
        let second = has_second.then(|| open_second(config)).transpose()?;
        let (second_rows, second_journal) = second.unzip();
        let path = config.out.join(ArrivalRow::FILE);
        let (arrival_rows, arrival_journal, last_arrival) =
            Journal::open(&path, ArrivalRow::COLUMNS, ArrivalRow::write, again)?;
        let filer = Filer::start(&config.out, again)?;
        let arrivals = last_arrival.map_or(0, |row| row.n.saturating_add(1));
        let inbox = Inbox::new(&settings, inputs).resumed(arrivals);
        let (input, input_reader) = latest(input_words(inbox.input(), 0));
        let (start_ns, k) = start(ticks, last_tick, settings.h)?;
        let process = Process::new(&settings, model, start_ns).resumed(k);
        let (output_publisher, output) = latest(output_words(process.output(), 0));
        let ticker = Ticker {
            process,
            h_ns: settings.h.ns(),
            input: input_reader,
            output: output_publisher,
            rows: tick_rows,
            second: second_rows,
            scheduling: settings.scheduling,
        }
        .start()?;
        let handler = Handler {
            settings,
            hosts: hosts(config),
            law: config.law.clone(),
            reference: config.reference.clone(),
            signals: [inputs, at_rest.count()],
            description: OnceCell::new(),
            inbox,
            input,
            output,
            rows: arrival_rows,
            refusals: BTreeMap::new(),
            at_rest,
            can_reset,
            resets: 0,
            control: Control::new(settings.lease),
            filer,
            over: watch::Sender::new(0),
        };
        Ok(Started {
            start_ns,
            ticker,
            tick_journal,
            second_journal,
            arrival_journal,
            handler: Rc::new(RefCell::new(handler)),
            server: clock::scheduling::ask(settings.scheduling.priority(FIFO_PRIORITY)),
            open_files: clock::limit::raise_open_files(),
        })
    }

    /// Stops the ticker, completes the files and reports; `ended` is how serving came to its end. No connection may
    /// be left.
    fn finish(
        self,
        ended: Result<(), ServeError>,
        address: SocketAddr,
        connections: u64,
    ) -> Result<report::Plant, ServeError> {
        let ticked = Running::stop(self.ticker).ok_or(ServeError::Ticker)?;
        let handler = Rc::into_inner(self.handler)
            .expect("all connections are gone")
            .into_inner();

        // All files are closed before the first error is returned.
        let tick_written = self.tick_journal.finish(ticked.rows);
        let second = self.second_journal.zip(ticked.second);
        let second_written = second.map(|(journal, rows)| journal.finish(rows));
        let arrival_written = self.arrival_journal.finish(handler.rows);
        let filed = handler.filer.finish();
        ended?;
        let (tick_rows, arrival_rows) = (tick_written?, arrival_written?);
        if let Some(problem) = filed.problem {
            return Err(problem.into());
        }
        Ok(report::Plant {
            address,
            start_ns: self.start_ns,
            ticks: ticked.ticks,
            missed: ticked.missed,
            arrivals: arrival_rows.rows + arrival_rows.overflow,
            refused: handler.refusals.values().sum(),
            refusals: handler
                .refusals
                .iter()
                .map(|(kind, count)| ((*kind).to_owned(), *count))
                .collect(),
            trips: ticked.trips,
            connections,
            tick_rows: written(tick_rows),
            second_rows: second_written.transpose()?.map(written),
            arrival_rows: written(arrival_rows),
            sessions: handler.control.sessions(),
            page_rows: filed.written,
            granted: report::PlantGranted {
                ticker: scheduling(ticked.granted),
                server: scheduling(self.server),
                open_files: self.open_files,
            },
            program: None,
        })
    }
}

/// What a journal did, as the report has it.
fn written(Kept { rows, overflow }: Kept) -> report::Written {
    report::Written { rows, overflow }
}

/// What a thread was granted, as the report has it.
fn scheduling(granted: Granted) -> report::Scheduling {
    report::Scheduling::new(
        granted.asked_priority,
        granted.fifo_priority,
        granted.slack_ns,
        granted.refused,
    )
}

/// Opens the file of the second input and output.
fn open_second(config: &Config) -> Result<(Recorder<SecondRow>, Journal), JournalError> {
    let path = config.out.join(SecondRow::FILE);
    let (rows, journal, _) =
        Journal::open(&path, SecondRow::COLUMNS, SecondRow::write, config.again)?;
    Ok((rows, journal))
}

/// When tick 0 is due, and which tick is next: behind the last one of an earlier life, if there was one.
fn start(ticks: PathBuf, last: Option<TickRow>, h: SampleTime) -> Result<(u64, u64), ServeError> {
    let now_ns = now_ns();
    let first_ns = now_ns + START_AHEAD_NS;
    match last {
        None => Ok((first_ns, 0)),
        Some(TickRow { t_due_ns, .. }) if t_due_ns > now_ns => Err(ServeError::Ahead {
            path: ticks,
            t_due_ns,
            now_ns,
        }),
        Some(TickRow { k, t_due_ns, .. }) => {
            let since_start_ns = k.saturating_mul(h.ns());
            let start_ns = t_due_ns.saturating_sub(since_start_ns);
            Ok((start_ns, h.next_k(start_ns, first_ns)))
        }
    }
}

/// The names that the plant answers to, its machine's among them.
fn hosts(config: &Config) -> Hosts {
    let own = rustix::system::uname()
        .nodename()
        .to_string_lossy()
        .into_owned();
    Hosts::new(config.hosts.iter().cloned().chain([own]))
}

fn listen(address: SocketAddr, runtime: &Runtime) -> Result<(TcpListener, SocketAddr), ServeError> {
    let _context = runtime.enter();
    let listened = server::listen(address).and_then(|listener| {
        let address = listener.local_addr()?;
        Ok((listener, address))
    });
    listened.map_err(|source| ServeError::Listen { address, source })
}

/// The socket of the datagrams, at the same address as HTTP.
fn bind(address: SocketAddr, runtime: &Runtime) -> Result<UdpSocket, ServeError> {
    let _context = runtime.enter();
    let bound = std::net::UdpSocket::bind(address).and_then(|socket| {
        socket.set_nonblocking(true)?;
        UdpSocket::from_std(socket)
    });
    bound.map_err(|source| ServeError::Listen { address, source })
}

/// Calls `ready` and waits for `stop`, or for `served`, which is an error.
async fn end(
    stop: impl Future<Output = io::Result<()>>,
    ready: impl FnOnce(),
    served: impl Future<Output = ServeError>,
) -> Result<(), ServeError> {
    let mut stop = pin!(stop);
    // Polled once before `ready`, so that a signal right after it is caught.
    let asked = poll_fn(|context| Poll::Ready(stop.as_mut().poll(context))).await;
    if let Poll::Ready(result) = asked {
        return result.map_err(ServeError::Start);
    }
    ready();
    tokio::select! {
        result = stop => result.map_err(ServeError::Start),
        error = served => Err(error),
    }
}
