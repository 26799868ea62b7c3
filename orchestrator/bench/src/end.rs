//! The ends that peers are measured with: an echo, hyper with nothing around it, and two clients that an emulator
//! starts inside its own network.
//!
//! They are processes of this binary, as the plant is one. Servers end when they are killed.

use std::convert::Infallible;
use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::str::FromStr;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use http_body_util::Full;
use hyper::body::{Bytes, Incoming};
use hyper::service::service_fn;
use hyper::{Request, Response, server::conn::http1};
use hyper_util::rt::TokioIo;
use link::certificate::Echo;
use shaper::ProbePlan;

/// The bytes of an echo: about those of a command's head and of its answer's.
pub(crate) const ECHO_BYTES: usize = 64;

/// What is asked of a server: as long as a command.
pub(crate) const PATH: &str = "/closed?seq=1234567&t_send_ns=333945719159&u=0.17010378";

/// What hyper answers: as long as a plant's state.
const ANSWER: &str =
    "seq=1234567&tick=1234567&t_arrive_ns=333946040170&y=0.12345678901234567&u=0.17010378";

/// Why an end does not serve.
#[derive(Debug, thiserror::Error)]
pub(crate) enum EndError {
    /// No such end, or a word of it is no number or address.
    #[error(
        "there is no end `{0}`; choose echo, echo PRIORITY, hyper, ping ADDRESS EVERY_MS COUNT or send ADDRESS:PORT MS"
    )]
    Unknown(String),
    /// A socket failed.
    #[error(transparent)]
    Socket(#[from] io::Error),
    /// Echoes cannot be sent.
    #[error(transparent)]
    Echoes(#[from] shaper::Error),
}

/// Serves until this process is killed; `on_line` gets `ready` and the address. A client ends by itself, and
/// `on_line` gets each of its round trips instead, in ns.
///
/// # Errors
/// If there is no such end, or a socket fails.
pub(crate) fn serve(words: &[String], mut on_line: impl FnMut(&str)) -> Result<(), EndError> {
    let unknown = || EndError::Unknown(words.join(" "));
    let known: Vec<&str> = words.iter().map(String::as_str).collect();
    let on_ready = |address: SocketAddr| on_line(&format!("ready {address}"));
    match known[..] {
        ["echo"] => Ok(echo(on_ready)?),
        ["echo", priority] => {
            clock::scheduling::ask(Some(read(priority).ok_or_else(unknown)?));
            Ok(echo(on_ready)?)
        }
        ["hyper"] => Ok(bare_hyper(on_ready)?),
        ["ping", address, every_ms, count] => {
            let target = read(address).ok_or_else(unknown)?;
            let every_ms = read(every_ms).ok_or_else(unknown)?;
            let count = read(count).ok_or_else(unknown)?;
            for rtt_ns in ping(target, every_ms, count)? {
                on_line(&rtt_ns.to_string());
            }
            Ok(())
        }
        ["send", address, ms] => {
            let address = read(address).ok_or_else(unknown)?;
            let time = Duration::from_millis(read(ms).ok_or_else(unknown)?);
            Ok(send(address, time)?)
        }
        _ => Err(unknown()),
    }
}

fn read<T: FromStr>(word: &str) -> Option<T> {
    word.parse().ok()
}

/// Echoes to a kernel at an address: their round trips, ns.
fn ping(target: Ipv4Addr, every_ms: u64, count: u32) -> shaper::Result<Vec<u64>> {
    let plan = echoes(target, every_ms, count);
    let echoes = shaper::Asker::open()?.run(&plan, &AtomicBool::new(false), |_| {})?;
    Ok(echoes.iter().filter_map(Echo::rtt_ns).collect())
}

/// Echoes on a regular grid, from now on.
pub(crate) fn echoes(target: Ipv4Addr, every_ms: u64, count: u32) -> ProbePlan {
    const MS: u64 = 1_000_000;
    ProbePlan {
        target,
        start_ns: 0,
        interval_ns: every_ms * MS,
        seed: None,
        until_ns: (1..=u64::from(count))
            .map(|sent| sent * every_ms * MS + 1000 * MS)
            .collect(),
        id: 1,
    }
}

/// Sends to an address for so long, as much as it takes.
pub(crate) fn send(address: SocketAddr, time: Duration) -> io::Result<()> {
    const CHUNK: usize = 1 << 17;
    const PATIENCE: Duration = Duration::from_secs(5);
    let mut stream = TcpStream::connect_timeout(&address, PATIENCE)?;
    let (chunk, begun) = (vec![0; CHUNK], Instant::now());
    while begun.elapsed() < time {
        stream.write_all(&chunk)?;
    }
    Ok(())
}

fn echo(on_ready: impl FnOnce(SocketAddr)) -> io::Result<()> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
    on_ready(listener.local_addr()?);
    loop {
        let (mut stream, _) = listener.accept()?;
        stream.set_nodelay(true)?;
        let mut bytes = [0; ECHO_BYTES];
        while stream.read_exact(&mut bytes).is_ok() {
            stream.write_all(&bytes)?;
        }
    }
}

fn bare_hyper(on_ready: impl FnOnce(SocketAddr)) -> io::Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()?;
    let serving = async {
        let listener = tokio::net::TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await?;
        on_ready(listener.local_addr()?);
        loop {
            let (stream, _) = listener.accept().await?;
            stream.set_nodelay(true)?;
            let connection =
                http1::Builder::new().serve_connection(TokioIo::new(stream), service_fn(answer));
            tokio::task::spawn_local(connection);
        }
    };
    tokio::task::LocalSet::new().block_on(&runtime, serving)
}

async fn answer(_: Request<Incoming>) -> Result<Response<Full<Bytes>>, Infallible> {
    Ok(Response::new(Full::new(Bytes::from_static(
        ANSWER.as_bytes(),
    ))))
}
