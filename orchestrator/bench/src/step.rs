//! A step: a message and its answer, back to back, both ends on one processor.
//!
//! Webloop's are whole: a plant that ticks, a controller with its law, and every row written. Peers send and
//! answer as many bytes, and do nothing else. Of a controller's rows, a step is `t_receive_ns - t_send_ns`.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::process::Command;
use std::time::{Duration, Instant};

use endpoint::MessageRow;
use http_body_util::{BodyExt, Empty};
use hyper::Request;
use hyper::body::Bytes;
use hyper::client::conn::http1;
use hyper_util::rt::TokioIo;

use crate::contender::{Contender, Kind, Lack, Measured, quantiles};
use crate::end::ECHO_BYTES;
use crate::role::{Role, output};
use crate::{Context, load, python};

const FIGURES: [(&str, f64); 3] = [("p50_us", 0.5), ("p99_us", 0.99), ("p99.9_us", 0.999)];

/// What is asked of a server: as long as a command.
pub(crate) const PATH: &str = "/closed?seq=1234567&t_send_ns=333945719159&u=0.17010378";

/// Steps before those that count: connections, caches and rings are warm after them.
const WARM_UP: usize = 300;

/// The base of the table.
pub(crate) const BASE: &str = "TCP echo";

pub(crate) const CONTENDERS: [Contender; 10] = [
    Contender {
        name: BASE,
        kind: Kind::Limit,
        measure: |context| context.processors.on_one(|| echo(context)),
    },
    Contender {
        name: "webloop, WebSocket",
        kind: Kind::Webloop,
        measure: |context| context.processors.on_one(|| webloop(context, "websocket")),
    },
    Contender {
        name: "webloop, HTTP",
        kind: Kind::Webloop,
        measure: |context| context.processors.on_one(|| webloop(context, "http")),
    },
    Contender {
        name: "hyper",
        kind: Kind::Peer,
        measure: |context| context.processors.on_one(|| hyper(context)),
    },
    Contender {
        name: "reqwest",
        kind: Kind::Peer,
        measure: |context| context.processors.on_one(|| reqwest(context)),
    },
    Contender {
        name: "wrk",
        kind: Kind::Peer,
        measure: |context| context.processors.on_one(|| load::wrk(context)),
    },
    Contender {
        name: "oha",
        kind: Kind::Peer,
        measure: |context| context.processors.on_one(|| load::oha(context)),
    },
    Contender {
        name: "curl",
        kind: Kind::Peer,
        measure: |context| context.processors.on_one(|| load::curl(context)),
    },
    Contender {
        name: "Python http.client",
        kind: Kind::Peer,
        measure: |context| context.processors.on_one(|| http_client(context)),
    },
    Contender {
        name: "the paper's way",
        kind: Kind::Peer,
        measure: |context| context.processors.on_one(|| python::step_paper(context)),
    },
];

/// A server of this binary without a plant.
pub(crate) fn server(context: &Context<'_>, end: &str) -> Result<Role, Lack> {
    Role::start(Command::new(context.webloop).args(["serve", "end", end]))
}

/// Takes steps for as long as is asked, and gives how long each took.
fn steps(
    context: &Context<'_>,
    mut step: impl FnMut() -> Result<(), Lack>,
) -> Result<Measured, Lack> {
    for _ in 0..WARM_UP {
        step()?;
    }
    let begun = Instant::now();
    let mut took_ns = Vec::with_capacity(1 << 16);
    while begun.elapsed() < Duration::from_millis(context.measure_ms) {
        let from_ns = pace::now_ns();
        step()?;
        took_ns.push(pace::now_ns() - from_ns);
    }
    quantiles(took_ns, &FIGURES)
}

fn echo(context: &Context<'_>) -> Result<Measured, Lack> {
    let server = server(context, "echo")?;
    let mut stream = TcpStream::connect(server.address)?;
    stream.set_nodelay(true)?;
    let mut bytes = [7; ECHO_BYTES];
    steps(context, || {
        stream.write_all(&bytes)?;
        Ok(stream.read_exact(&mut bytes)?)
    })
}

fn webloop(context: &Context<'_>, transport: &str) -> Result<Measured, Lack> {
    let plant = Role::plant(context.webloop, "1ms", &context.folder.join("plant"))?;
    let folder = context.folder.join("controller");
    // What it takes to open the connection is before the steps that count.
    let duration = format!("{}ms", context.measure_ms + 100);
    let mut controller = Command::new(context.webloop);
    controller
        .args(["serve", "controller", "--transport", transport])
        .args(["--plant", &plant.address.to_string()])
        .args([
            "--h",
            "10us",
            "--outstanding",
            "1",
            "--schedule",
            "relative",
        ])
        .args(["--duration", &duration, "--out"])
        .arg(&folder);
    output(&mut controller)?;
    plant.end()?;
    let mut rows = csv::Reader::from_path(folder.join(MessageRow::FILE))?;
    let rows = rows.deserialize().collect::<Result<Vec<MessageRow>, _>>();
    let rows = rows?;
    let answered = rows.iter().skip(WARM_UP);
    let took_ns = answered.filter_map(|row| Some(row.t_receive_ns? - row.t_send_ns?));
    quantiles(took_ns.collect(), &FIGURES)
}

fn runtime() -> Result<tokio::runtime::Runtime, Lack> {
    Ok(tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()?)
}

fn failed(error: impl std::error::Error) -> Lack {
    Lack(error.to_string())
}

fn hyper(context: &Context<'_>) -> Result<Measured, Lack> {
    let server = server(context, "hyper")?;
    let runtime = runtime()?;
    let connected = runtime.block_on(async {
        let stream = tokio::net::TcpStream::connect(server.address).await?;
        stream.set_nodelay(true)?;
        http1::handshake(TokioIo::new(stream)).await.map_err(failed)
    });
    let (mut sender, connection) = connected?;
    runtime.spawn(connection);
    let host = server.address.to_string();
    steps(context, || {
        runtime.block_on(async {
            let request = Request::get(PATH).header("host", &host);
            let request = request.body(Empty::<Bytes>::new()).map_err(failed)?;
            let response = sender.send_request(request).await.map_err(failed)?;
            response.into_body().collect().await.map_err(failed)?;
            // The connection takes the next request once its task has seen the end of this one.
            sender.ready().await.map_err(failed)
        })
    })
}

fn reqwest(context: &Context<'_>) -> Result<Measured, Lack> {
    let server = server(context, "hyper")?;
    let runtime = runtime()?;
    let client = reqwest::Client::builder()
        .no_proxy()
        .http1_only()
        .tcp_nodelay(true)
        .build()
        .map_err(failed)?;
    let url = format!("http://{}{PATH}", server.address);
    steps(context, || {
        runtime.block_on(async {
            let response = client.get(&url).send().await.map_err(failed)?;
            response.bytes().await.map(drop).map_err(failed)
        })
    })
}

fn http_client(context: &Context<'_>) -> Result<Measured, Lack> {
    let server = server(context, "hyper")?;
    python::step_http_client(context, server.address)
}
