//! A loop at 10 kHz: which share of its messages and ticks is in time, and how long a message takes.
//!
//! A message is in time if it is sent before the next one is due, a tick likewise. The echo is as bare as it can
//! be: a thread that waits for the same deadlines and sends, one that receives, and the echo's own, all with
//! real-time scheduling. Like the controller, it does not wait for an answer before it sends again, so that both meet a
//! pause of the machine with as many messages; and what it could not send in time it leaves out.

use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use std::process::Command;
use std::thread;

use endpoint::{MessageRow, TickRow};
use record::rows;

use crate::comparison::{Bound, Table, goal};
use crate::contender::{Contender, Lack, Measured, quantiles};
use crate::context::Context;
use crate::end::ECHO_BYTES;
use crate::role::{Role, output};

const H_NS: u64 = 100_000;

/// The priority of the plant's own HTTP thread and of the native controller.
const FIFO_PRIORITY: u8 = 45;

pub(crate) const TABLE: Table = Table {
    about: "a loop at 10 kHz: round trips, and what is in time",
    base: Some("TCP echo, FIFO"),
    processors: None,
    contenders: &[
        Contender::limit("TCP echo, FIFO", echo),
        Contender::webloop("webloop, HTTP", |context| webloop(context, "http")),
        Contender::webloop("webloop, WebSocket", |context| {
            webloop(context, "websocket")
        }),
    ],
    goals: &[
        goal("webloop, HTTP", "sent_pct", None, Bound::AtLeast(99.0)),
        goal("webloop, HTTP", "ticked_pct", None, Bound::AtLeast(99.0)),
        goal(
            "webloop, HTTP",
            "p99.9_us",
            Some("TCP echo, FIFO"),
            Bound::AtMost(1.5),
        ),
    ],
};

/// Round trips, and the share of deadlines that were met.
fn figures(took_ns: Vec<u64>, sent: usize, due: usize) -> Result<Measured, Lack> {
    let mut figures = quantiles(took_ns)?;
    figures.push(("sent_pct", share_pct(sent, due)));
    Ok(figures)
}

fn share_pct(of: usize, all: usize) -> f64 {
    100.0 * of as f64 / all.max(1) as f64
}

fn echo(context: &Context<'_>) -> Result<Measured, Lack> {
    let server = Role::server(context, &["echo", &FIFO_PRIORITY.to_string()])?;
    let stream = TcpStream::connect(server.address)?;
    stream.set_nodelay(true)?;
    let due = (context.measure_ms * 1_000_000 / H_NS) as usize;
    let (sent_ns, received_ns) = thread::scope(|scope| {
        let receiver = scope.spawn(|| receive(&stream, due));
        let sender = scope.spawn(|| send(&stream, due));
        (sender.join(), receiver.join())
    });
    let (sent_ns, received_ns) = match (sent_ns, received_ns) {
        (Ok(sent_ns), Ok(received_ns)) => (sent_ns?, received_ns?),
        (Err(panic), _) | (_, Err(panic)) => std::panic::resume_unwind(panic),
    };
    // One connection keeps them in order.
    let took_ns = received_ns.iter().zip(&sent_ns).map(|(to, from)| to - from);
    figures(took_ns.collect(), sent_ns.len(), due)
}

/// Sends at each deadline that it does not miss. Gives when.
fn send(mut stream: &TcpStream, due: usize) -> Result<Vec<u64>, Lack> {
    let mut pacer = clock::pacer::Pacer::new(&clock::scheduling::ask(Some(FIFO_PRIORITY)));
    let mut sent_ns = Vec::with_capacity(due);
    let start_ns = clock::now::now_ns() + 10_000_000;
    for k in 0..due as u64 {
        let due_ns = start_ns + k * H_NS;
        pacer.sleep_until(due_ns);
        let now_ns = clock::now::now_ns();
        if now_ns < due_ns + H_NS {
            stream.write_all(&[7; ECHO_BYTES])?;
            sent_ns.push(now_ns);
        }
    }
    // The echo ends behind the last message, and so does who receives.
    stream.shutdown(Shutdown::Write)?;
    Ok(sent_ns)
}

/// Receives all that comes back. Gives when.
fn receive(mut stream: &TcpStream, most: usize) -> Result<Vec<u64>, Lack> {
    clock::scheduling::ask(Some(FIFO_PRIORITY));
    let mut received_ns = Vec::with_capacity(most);
    let mut bytes = [0; ECHO_BYTES];
    while stream.read_exact(&mut bytes).is_ok() {
        received_ns.push(clock::now::now_ns());
    }
    Ok(received_ns)
}

fn webloop(context: &Context<'_>, transport: &str) -> Result<Measured, Lack> {
    let plant_folder = context.folder.join("plant");
    let plant = Role::plant(context, "100us", &plant_folder)?;
    let folder = context.folder.join("controller");
    let mut controller = Command::new(&context.programs.webloop);
    controller
        .args(["serve", "controller", "--h", "100us"])
        .args(["--transport", transport])
        .args(["--plant", &plant.address.to_string()])
        .args(["--duration", &format!("{}ms", context.measure_ms), "--out"])
        .arg(&folder);
    output(&mut controller)?;
    plant.end()?;
    let (mut took_ns, mut due, mut sent) = (Vec::new(), 0, 0);
    rows::read(&folder.join(MessageRow::FILE), |row: &MessageRow| {
        due += 1;
        sent += usize::from(row.t_send_ns.is_some());
        let ends_ns = row.t_receive_ns.zip(row.t_send_ns);
        took_ns.extend(ends_ns.map(|(to_ns, from_ns)| to_ns - from_ns));
    })?;
    let (mut ticks, mut in_time) = (0, 0);
    rows::read(&plant_folder.join(TickRow::FILE), |row: &TickRow| {
        ticks += 1;
        in_time += usize::from(row.t_tick_ns < row.t_due_ns + H_NS);
    })?;
    let mut figures = figures(took_ns, sent, due)?;
    figures.push(("ticked_pct", share_pct(in_time, ticks)));
    Ok(figures)
}
