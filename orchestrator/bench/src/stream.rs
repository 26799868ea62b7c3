//! One TCP stream across: how many Mbit/s a cable carries alone, and with an emulator of no
//! delay in it.

use std::io::{self, Read};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use clock::now::now_ns;
use link::{Epoch, LinkTime};
use shaper::{
    CONTROLLER_INTERFACE, Namespace, PLANT_ADDRESS, PLANT_INTERFACE, PacketPort, PlayerConfig,
    connect, join, play,
};

use crate::comparison::{Bound, Table, goal};
use crate::contender::{Contender, Lack, Measured};
use crate::context::Context;
use crate::crossing::constant;
use crate::{end, rattan};

const PORT: u16 = 4000;

pub(crate) const TABLE: Table = Table {
    about: "one TCP stream across a link of no delay",
    base: Some("veth alone"),
    processors: None,
    contenders: &[
        Contender::limit("veth alone", veth),
        Contender::webloop("webloop", played),
        Contender::peer("Rattan", through_rattan),
    ],
    goals: &[
        goal("webloop", "mbit_s", Some("veth alone"), Bound::AtLeast(0.5)),
        goal("webloop", "mbit_s", Some("Rattan"), Bound::AtLeast(10.0)),
    ],
};

fn veth(context: &Context<'_>) -> Result<Measured, Lack> {
    let ends = || -> shaper::Result<_> {
        let (controller, plant) = (Namespace::new()?, Namespace::new()?);
        let [_, address] = connect(&controller, &plant)?;
        Ok((controller, plant, address))
    };
    let (controller, plant, address) = ends()?;
    stream(context, &controller, &plant, address)
}

fn played(context: &Context<'_>) -> Result<Measured, Lack> {
    let text = "name = \"none\"\nabout = \"no delay\"\n[both.delay]\nbase = \"0ms\"\n";
    let profile = constant(text)?;
    let ends = || -> shaper::Result<_> {
        let [controller, plant, middle] = [Namespace::new()?, Namespace::new()?, Namespace::new()?];
        let in_segments = profile.treats_packets_alike();
        join(&controller, &plant, &middle, in_segments)?;
        Ok((controller, plant, middle))
    };
    let (controller, plant, middle) = ends()?;
    let done = AtomicBool::new(false);
    thread::scope(|scope| {
        let player = scope.spawn(|| {
            middle.run(|| {
                let config = PlayerConfig {
                    profile,
                    seed: 1,
                    epoch: Epoch::at_ns(now_ns()),
                    opens: LinkTime::ZERO,
                    controller: PacketPort::open(CONTROLLER_INTERFACE)?,
                    plant: PacketPort::open(PLANT_INTERFACE)?,
                    packets: None,
                };
                play(config, &done, |_| {})
            })
        });
        let figures = stream(context, &controller, &plant, PLANT_ADDRESS);
        done.store(true, Ordering::Relaxed);
        match player.join() {
            Ok(played) => played?,
            Err(panic) => std::panic::resume_unwind(panic),
        };
        figures
    })
}

fn through_rattan(context: &Context<'_>) -> Result<Measured, Lack> {
    let around = Namespace::new()?;
    let words = format!("send $RATTAN_BASE:{PORT} {}", context.measure_ms);
    received(&around, Ipv4Addr::UNSPECIFIED, || {
        rattan::run(context, &around, "0ms", &words).map(drop)
    })
}

/// Sends from one namespace to the other for as long as is asked.
fn stream(
    context: &Context<'_>,
    from: &Namespace,
    to: &Namespace,
    address: Ipv4Addr,
) -> Result<Measured, Lack> {
    let time = Duration::from_millis(context.measure_ms);
    let send = || Ok(end::send(SocketAddr::from((address, PORT)), time));
    received(to, address, || Ok(from.run(send)??))
}

/// What arrives in a namespace of what is sent.
fn received(
    to: &Namespace,
    address: Ipv4Addr,
    send: impl FnOnce() -> Result<(), Lack>,
) -> Result<Measured, Lack> {
    let listener = to.run(|| Ok(TcpListener::bind((address, PORT))));
    let listener = listener??;
    // Whoever sends nothing is not waited for.
    let own = listener.local_addr()?;
    thread::scope(|scope| {
        let receiver = scope.spawn(move || rate_mbit_s(&listener));
        let sent = send();
        if sent.is_err() {
            let _ = to.run(|| Ok(TcpStream::connect((Ipv4Addr::LOCALHOST, own.port()))));
        }
        let rate = match receiver.join() {
            Ok(rate) => rate?,
            Err(panic) => std::panic::resume_unwind(panic),
        };
        sent.map(|()| vec![("mbit_s", rate)])
    })
}

/// The rate at which a first connection brings bytes, until its end. An emulator that ends with its client drops
/// the end of the connection with what is under way: silence is an end too.
fn rate_mbit_s(listener: &TcpListener) -> io::Result<f64> {
    const CHUNK: usize = 1 << 17;
    const SILENCE: Duration = Duration::from_secs(1);
    let (mut stream, _) = listener.accept()?;
    stream.set_read_timeout(Some(SILENCE))?;
    let (mut chunk, mut bytes) = (vec![0; CHUNK], 0);
    let begun = Instant::now();
    let mut last = begun;
    while let Ok(read @ 1..) = stream.read(&mut chunk) {
        bytes += read;
        last = Instant::now();
    }
    Ok(bytes as f64 * 8e-6 / (last - begun).as_secs_f64())
}
