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
use record::rows;

use crate::comparison::{Bound, Table, goal};
use crate::contender::{Contender, Lack, Measured, quantiles};
use crate::context::Context;
use crate::end::{ECHO_BYTES, PATH};
use crate::role::{Role, output};
use crate::{load, python};

/// Steps before those that count: connections, caches and rings are warm after them.
const WARM_UP: usize = 300;

pub(crate) const TABLE: Table = Table {
    about: "a message and its answer, back to back, both ends on one processor",
    base: Some("TCP echo"),
    processors: Some(1),
    contenders: &[
        Contender::limit("TCP echo", echo),
        Contender::webloop("webloop, WebSocket", |context| {
            webloop(context, "websocket")
        }),
        Contender::webloop("webloop, HTTP", |context| webloop(context, "http")),
        Contender::peer("hyper", hyper),
        Contender::peer("reqwest", reqwest),
        Contender::peer("wrk", load::wrk),
        Contender::peer("oha", load::oha),
        Contender::peer("curl", load::curl),
        Contender::peer("Python http.client", http_client),
        Contender::peer("the paper's way", python::step_paper),
    ],
    goals: &[
        goal(
            "webloop, HTTP",
            "p50_us",
            Some("TCP echo"),
            Bound::AtMost(2.0),
        ),
        goal(
            "webloop, WebSocket",
            "p50_us",
            Some("TCP echo"),
            Bound::AtMost(1.5),
        ),
        goal(
            "the paper's way",
            "p50_us",
            Some("webloop, HTTP"),
            Bound::AtLeast(19.0),
        ),
        goal(
            "the paper's way",
            "p50_us",
            Some("webloop, WebSocket"),
            Bound::AtLeast(25.0),
        ),
    ],
};

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
        let from_ns = clock::now::now_ns();
        step()?;
        took_ns.push(clock::now::now_ns() - from_ns);
    }
    quantiles(took_ns)
}

fn echo(context: &Context<'_>) -> Result<Measured, Lack> {
    let server = Role::server(context, &["echo"])?;
    let mut stream = TcpStream::connect(server.address)?;
    stream.set_nodelay(true)?;
    let mut bytes = [7; ECHO_BYTES];
    steps(context, || {
        stream.write_all(&bytes)?;
        Ok(stream.read_exact(&mut bytes)?)
    })
}

fn webloop(context: &Context<'_>, transport: &str) -> Result<Measured, Lack> {
    let plant = Role::plant(context, "1ms", &context.folder.join("plant"))?;
    let folder = context.folder.join("controller");
    // What it takes to open the connection is before the steps that count.
    let duration = format!("{}ms", context.measure_ms + 100);
    let mut controller = Command::new(&context.programs.webloop);
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
    let mut took_ns = Vec::new();
    rows::read(&folder.join(MessageRow::FILE), |row: &MessageRow| {
        took_ns.extend(
            row.t_receive_ns
                .zip(row.t_send_ns)
                .map(|(to_ns, from_ns)| to_ns - from_ns),
        );
    })?;
    quantiles(took_ns.split_off(WARM_UP.min(took_ns.len())))
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
    let server = Role::server(context, &["hyper"])?;
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
    let server = Role::server(context, &["hyper"])?;
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
    let server = Role::server(context, &["hyper"])?;
    python::step_http_client(context, server.address)
}
