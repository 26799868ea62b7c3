//! What a message passes through, path by path, for `.ci/instructions`, which counts the instructions.
//!
//! `cargo run --release -p webloop-analysis --example hot -- PATH TIMES` goes a path so many times, and prints how often
//! it did: a loop on real deadlines may miss some. `-- list` lists the paths. It measures nothing itself.
#![allow(clippy::print_stdout, reason = "its output is what it is for")]

use std::{
    error::Error,
    fmt::Write as _,
    hint::black_box,
    io::{Read, Write},
    net::{SocketAddr, TcpStream},
    path::Path,
    sync::mpsc,
    thread,
};

use analysis::{Aim, response::ResponseTrace};
use clock::journal::Journal;
use control::{preset, seconds};
use endpoint::{
    Answer, Command, MessageOutcome, MessageRow, Mode, Outstanding, PlantSettings, Policy, Preset,
    Request, SampleTime, State, TickRow, Transport,
};
use link::{Epoch, Profile, Timeline, Way};
use record::rows;
use sim::{Record, Setup};
use text::column::Row;

type Result<T, E = Box<dyn Error>> = std::result::Result<T, E>;

const MS_NS: u64 = 1_000_000;

/// Goes a path so many times, and gives how often it was gone.
type Go = fn(u64) -> Result<u64>;

const PATHS: [(&str, Go); 12] = [
    ("step", |times| step(None, times)),
    ("step over arima", |times| step(Some("arima"), times)),
    ("step over couva", |times| step(Some("couva"), times)),
    ("link arima", |times| link("arima", times)),
    ("link couva", |times| link("couva", times)),
    ("message", message),
    ("row written", written),
    ("row read", read),
    ("plant by HTTP", |times| plant(Transport::Http, times)),
    ("plant by WebSocket", |times| {
        plant(Transport::WebSocket, times)
    }),
    ("loop by HTTP", |times| both(Transport::Http, times)),
    ("loop by WebSocket", |times| {
        both(Transport::WebSocket, times)
    }),
];

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        ["list"] => PATHS.iter().for_each(|(name, _)| println!("{name}")),
        [name, times] => {
            let path = PATHS.iter().find(|(known, _)| *known == name);
            let (_, path) = path.ok_or("no such path; `list` lists them")?;
            println!("{}", path(times.parse()?)?);
        }
        _ => return Err("say `list`, or PATH TIMES".into()),
    }
    Ok(())
}

fn profile(name: &str) -> Result<Profile> {
    let source = Profile::builtin(name).ok_or("no such topology")?;
    Profile::parse(source, name).map_err(|findings| format!("{name}: {findings:?}").into())
}

fn h(ns: u64) -> Result<SampleTime> {
    Ok(SampleTime::try_new(ns)?)
}

/// Both ends, the link between them, and the loop's metrics, in virtual time.
fn step(topology: Option<&str>, times: u64) -> Result<u64> {
    struct Metrics(ResponseTrace);
    impl Record for Metrics {
        fn tick(&mut self, row: &TickRow) {
            self.0.push(row);
        }
    }
    let profile = topology.map_or_else(|| Ok(Profile::empty()), profile)?;
    let settings = Preset::PaperPython.settings(Mode::Closed, h(MS_NS)?);
    let motor = preset::paper_plant().sampled(MS_NS)?.stepper();
    let law = preset::paper_pi().into();
    let setup = Setup::ideal(&profile, settings, motor, law, times * MS_NS);
    let mut metrics = Metrics(ResponseTrace::new(Aim::step(MS_NS)));
    Ok(sim::run(&setup, &mut metrics)?.counts.due)
}

/// A packet up and one down.
fn link(topology: &str, times: u64) -> Result<u64> {
    let mut link = Timeline::new(&profile(topology)?, 1, Epoch::at_ns(0));
    for k in 0..times {
        for way in Way::BOTH {
            black_box(link.transmit(way, k * MS_NS, 166));
        }
    }
    Ok(times)
}

/// A command that is written and read, and so its answer.
fn message(times: u64) -> Result<u64> {
    for k in 0..times {
        let command = Command {
            seq: k,
            t_send_ns: 333_945_719_159 + k * MS_NS,
            u: (0.170_103_78 + seconds(k)).into(),
        };
        let request: Request = black_box(command.to_string()).parse()?;
        let state = State {
            seq: k,
            tick: k,
            t_arrive_ns: 333_946_040_170 + k * MS_NS,
            y: (0.123_456_789_012_345_67 + seconds(k)).into(),
            u: request.u,
        };
        black_box(Answer::parse(
            Mode::Closed,
            &black_box(state.to_string()),
            &command,
        )?);
    }
    Ok(times)
}

fn row(k: u64) -> MessageRow {
    let t_due_ns = 333_945_719_159 + k * MS_NS;
    let y = 0.123_456_789_012_345_67 + seconds(k);
    MessageRow {
        seq: k,
        t_due_ns,
        t_send_ns: Some(t_due_ns + 1_234),
        t_receive_ns: Some(t_due_ns + 321_012),
        t_arrive_ns: Some(t_due_ns + 123_456),
        r: 1.0,
        y: Some(y),
        e: Some(1.0 - y),
        u: Some(0.170_103_78 + seconds(k)),
        tick: Some(k),
        outcome: MessageOutcome::Answered,
        y_seq: None,
    }
}

/// From the measured thread to the file.
fn written(times: u64) -> Result<u64> {
    let folder = tempfile::tempdir()?;
    journal(&folder.path().join(MessageRow::FILE), times)
}

fn journal(path: &Path, count: u64) -> Result<u64> {
    let (mut recorder, journal) = Journal::create(path, MessageRow::COLUMNS, MessageRow::write)?;
    (0..count).for_each(|k| recorder.record(row(k)));
    Ok(journal.finish(recorder)?.rows)
}

/// Of a file that is read again and again, since it has to be written first.
fn read(times: u64) -> Result<u64> {
    const ROWS: u64 = 1000;
    let folder = tempfile::tempdir()?;
    let path = folder.path().join(MessageRow::FILE);
    journal(&path, ROWS)?;
    let mut count = 0;
    while count < times {
        rows::read(&path, |row: &MessageRow| {
            count += u64::from(black_box(row).y.is_some());
        })?;
    }
    Ok(count)
}

/// Runs a plant, which does not tick meanwhile, for as long as `client` takes.
fn beside_plant<T>(client: impl FnOnce(SocketAddr, &Path) -> Result<T>) -> Result<T> {
    let h = h(SampleTime::MAX_NS)?;
    let folder = tempfile::tempdir()?;
    let config = plant::Config {
        listen: "127.0.0.1:0".parse()?,
        hosts: Vec::new(),
        settings: PlantSettings {
            scheduling: Policy::Other,
            ..PlantSettings::new(h)
        },
        law: None,
        reference: None,
        out: folder.path().join("plant"),
        again: false,
    };
    let motor = preset::paper_plant().sampled(MS_NS)?.stepper();
    let (ready, is_ready) = mpsc::channel();
    let (stop, is_stopped) = tokio::sync::oneshot::channel::<()>();
    thread::scope(|scope| {
        let plant = scope.spawn(|| {
            let stop = async {
                let _ = is_stopped.await;
                Ok(())
            };
            plant::serve_until(&config, motor, stop, |facts| {
                let _ = ready.send(facts.address);
            })
        });
        let result = client(is_ready.recv()?, folder.path());
        drop(stop);
        plant.join().map_err(|_| "the plant panicked")??;
        result
    })
}

/// The plant over a connection, with a client that only sends and receives.
fn plant(transport: Transport, times: u64) -> Result<u64> {
    const COMMAND: &str = "seq=1234567&t_send_ns=333945719159&u=0.17010378";
    beside_plant(|address, _| {
        let mut stream = TcpStream::connect(address)?;
        stream.set_nodelay(true)?;
        let mut answer = [0; 1024];
        let mut ask = |request: &[u8], says: &[u8]| -> Result<()> {
            stream.write_all(request)?;
            let length = stream.read(&mut answer)?;
            if answer[..length]
                .windows(says.len())
                .any(|part| part == says)
            {
                return Ok(());
            }
            Err(String::from_utf8_lossy(&answer[..length]).into())
        };
        let mut request = Vec::new();
        match transport {
            Transport::Http => {
                let head = format!("GET /closed?{COMMAND} HTTP/1.1\r\nhost: {address}\r\n\r\n");
                request.extend_from_slice(head.as_bytes());
            }
            Transport::WebSocket => {
                let mut opening =
                    format!("GET /socket?mode=closed HTTP/1.1\r\nhost: {address}\r\n");
                opening.write_str(
                    "connection: upgrade\r\nupgrade: websocket\r\nsec-websocket-version: 13\r\n\
                     sec-websocket-key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n",
                )?;
                ask(opening.as_bytes(), b"101")?;
                // One frame of text, whose mask changes nothing: RFC 6455, 5.2.
                request.extend([0x81, 0x80 | COMMAND.len() as u8, 0, 0, 0, 0]);
                request.extend_from_slice(COMMAND.as_bytes());
            }
            other @ (Transport::Json | Transport::Tcp | Transport::Udp) => {
                return Err(format!("{other} is not counted").into());
            }
        }
        (0..times).try_for_each(|_| ask(&request, b"seq=1234567&"))?;
        Ok(times)
    })
}

/// Plant and controller, a message every 5 ms.
fn both(transport: Transport, times: u64) -> Result<u64> {
    const H_NS: u64 = 5 * MS_NS;
    beside_plant(|address, folder| {
        let config = controller::Config {
            plant: format!("http://{address}"),
            settings: endpoint::ControllerSettings {
                transport,
                outstanding: Outstanding::ONE,
                ..Preset::PaperPython.settings(Mode::Closed, h(H_NS)?)
            },
            claim: false,
            check: false,
            reference: None,
            law: preset::paper_pi().into(),
            start_ns: None,
            duration_ns: times * H_NS,
            connections: 1,
            out: folder.join("controller"),
            again: false,
            scheduling: Policy::Other,
        };
        let counts = controller::drive_until(&config, std::future::pending())?.counts;
        Ok(counts.answered)
    })
}
