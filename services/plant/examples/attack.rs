//! What one attacker costs a loop: a 1 kHz closed loop over HTTP on loopback, beside one attack at a time.
//!
//! `cargo run --release -p webloop-plant --example attack -- [seconds] [words of an attack's name]`
//!
//! Each attack is made on a sink, which accepts, reads and throws away, and on the plant, in turns. The loop is the
//! same: what it loses beside the sink, it loses to the processor that the attacker takes; what it
//! loses more, it loses to the plant. Plant, sink and attacker are processes of their own.
#![allow(clippy::print_stdout, reason = "its output is what it is for")]

use std::{
    error::Error,
    io::{BufRead, BufReader, Read, Write},
    net::{SocketAddr, TcpStream},
    process::{Child, ChildStdin, Command, Stdio},
    sync::atomic::{AtomicBool, Ordering},
    thread,
    time::{Duration, Instant},
};

use clock::now::now_ns;
use control::preset;
use endpoint::PlantSettings;
use plant::{Config, serve_until};
use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    time::sleep,
};

type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// The sample time of the loop.
const H: Duration = Duration::from_millis(1);

/// Sink and plant are attacked in turns, so that what else the machine does hits both; medians of the turns count.
const ROUNDS: u32 = 3;

/// Below the plant's threads, above all that has no priority, as the native controller.
const FIFO_PRIORITY: u8 = 40;

/// An attack: many connections that each send something, and again what follows, after a pause.
struct Attack {
    name: &'static str,
    connections: usize,
    first: fn() -> Vec<u8>,
    again: fn() -> Vec<u8>,
    pause: Duration,
    /// Whether it reads what it is answered.
    reads: bool,
    /// Whether each connection is left at once, and another opened.
    leaves: bool,
}

const ATTACKS: [Attack; 11] = [
    Attack {
        name: "slow heads",
        connections: 1_000,
        first: || b"GET /state HTTP/1.1\r\nHost: 127.0.0.1\r\n".to_vec(),
        again: || b"X: y\r\n".to_vec(),
        pause: Duration::from_secs(1),
        ..HELD
    },
    Attack {
        name: "slow bodies",
        connections: 1_000,
        first: || claim(1_000, b"{"),
        again: || b" ".to_vec(),
        pause: Duration::from_secs(1),
        ..HELD
    },
    Attack {
        name: "stalled sessions",
        connections: 4_000,
        first: || claim(1_000, &[b' '; 900]),
        ..HELD
    },
    Attack {
        name: "session claims",
        connections: 8,
        first: || claim(14, br#"{"client":"x"}"#).repeat(20),
        again: || claim(14, br#"{"client":"x"}"#).repeat(20),
        ..BUSY
    },
    Attack {
        name: "pipelining",
        connections: 8,
        first: || GET.repeat(500),
        again: || GET.repeat(500),
        ..BUSY
    },
    Attack {
        name: "slow readers",
        connections: 1_000,
        first: || b"GET /openapi.json HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n".repeat(500),
        reads: false,
        ..HELD
    },
    Attack {
        name: "held connections",
        connections: 8_500,
        ..HELD
    },
    Attack {
        name: "new connections",
        connections: 16,
        first: || GET.to_vec(),
        leaves: true,
        ..BUSY
    },
    Attack {
        name: "WebSockets",
        connections: 8_500,
        first: || WEBSOCKET.to_vec(),
        ..HELD
    },
    Attack {
        name: "oversized heads and bodies",
        connections: 16,
        first: || [b"GET /".as_slice(), &b"a".repeat(1 << 20)].concat(),
        again: || claim(1 << 30, &b"a".repeat(1 << 20)),
        ..BUSY
    },
    Attack {
        name: "oversized frames",
        connections: 16,
        // A text of 2^40 bytes by its own word, masked by zeros.
        first: || [WEBSOCKET, b"\x81\xff\0\0\x01\0\0\0\0\0\0\0\0\0"].concat(),
        again: || b"a".repeat(1 << 20),
        ..BUSY
    },
];

/// Connections that are held, and opened again when they are closed.
const HELD: Attack = Attack {
    name: "",
    connections: 0,
    first: Vec::new,
    again: Vec::new,
    pause: Duration::from_secs(1),
    reads: true,
    leaves: false,
};

/// Connections on which there is always more.
const BUSY: Attack = Attack {
    pause: Duration::ZERO,
    ..HELD
};

const GET: &[u8] = b"GET /state HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";

const WEBSOCKET: &[u8] = b"GET /socket?mode=closed HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: upgrade\r\n\
    Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";

fn claim(length: usize, body: &[u8]) -> Vec<u8> {
    let head = format!(
        "POST /session HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\nContent-Length: {length}\r\n\r\n"
    );
    [head.as_bytes(), body].concat()
}

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words[..] {
        ["--plant"] => plant(),
        ["--sink"] => sink(),
        ["--attacker", index, address] => {
            attack(&ATTACKS[index.parse::<usize>()?], address.parse()?)
        }
        _ => {
            let seconds = words.first().copied().unwrap_or("10").parse()?;
            bench(seconds, &words.get(1..).unwrap_or_default().join(" "))
        }
    }
}

/// Prints a row for each attack whose name has these words.
fn bench(seconds: u64, words: &str) -> Outcome<()> {
    println!(
        "{:<27} {:>9} {:>9} {:>9} {:>9} {:>9} {:>5} {:>9} {:>9}",
        "attack", "p50 sink", "p50", "p99 sink", "p99", "p99 more", "lost", "RSS more", "fresh"
    );
    let (mut held, mut worst) = (0, Vec::new());
    for (index, attack) in ATTACKS.iter().enumerate() {
        if !attack.name.contains(words) {
            continue;
        }
        let plant = Part::start(&["--plant"])?;
        let sink = Part::start(&["--sink"])?;
        let beside = |victim: SocketAddr| -> Outcome<Seen> {
            let attacker = Part::start(&["--attacker", &index.to_string(), &victim.to_string()])?;
            // Until all its connections are there.
            thread::sleep(Duration::from_secs(1));
            let seen = drive(&plant, Duration::from_secs(seconds) / ROUNDS);
            drop(attacker);
            seen
        };
        // The first run warms the plant up; what it takes for that is not the attacker's.
        drive(&plant, Duration::from_secs(1))?;
        let (mut calm, mut hit) = (Vec::new(), Vec::new());
        for _ in 0..ROUNDS {
            calm.push(beside(sink.address)?);
            hit.push(beside(plant.address)?);
        }
        let pairs = std::iter::zip(&calm, &hit);
        let more_us = middle(pairs.map(|(calm, hit)| hit.p99_us - calm.p99_us));
        let all = |of: fn(&Seen) -> i64| [&calm, &hit].map(|seen| middle(seen.iter().map(of)));
        let ([calm_p50, hit_p50], [calm_p99, hit_p99]) = (all(|of| of.p50_us), all(|of| of.p99_us));
        if more_us <= 50 || hit_p99 * 10 <= calm_p99 * 11 {
            held += 1;
        }
        // Memory stays that an attack took, so before the first one.
        let most_kib = hit.iter().map(|of| of.rss_kib).max().unwrap_or(0);
        let more_mib = most_kib.saturating_sub(calm[0].rss_kib) as f64 / 1024.0;
        let lost: u64 = hit.iter().map(|of| of.lost).sum();
        let fresh_ms = hit.iter().map(|of| of.fresh_ms).max().unwrap_or(0);
        println!(
            "{:<27} {calm_p50:>6} us {hit_p50:>6} us {calm_p99:>6} us {hit_p99:>6} us {more_us:>+6} us {lost:>5} {more_mib:>5.1} MiB {fresh_ms:>6} ms",
            attack.name,
        );
        worst.push((more_us, attack.name, lost, more_mib, fresh_ms));
    }
    let Some((more_us, name, ..)) = worst.iter().max_by_key(|of| of.0) else {
        return Ok(());
    };
    println!(
        "row 14: {held} of {} attacks within +10 % or 50 us of p99 beside a sink, most beside `{name}` ({more_us:+} us); {} control connections lost; at most {:.1} MiB more; a newcomer served within {} ms",
        worst.len(),
        worst.iter().map(|of| of.2).sum::<u64>(),
        worst.iter().map(|of| of.3).fold(0.0, f64::max),
        worst.iter().map(|of| of.4).max().unwrap_or(0),
    );
    Ok(())
}

/// The middle one of [`ROUNDS`] values.
fn middle(values: impl Iterator<Item = i64>) -> i64 {
    let mut values: Vec<i64> = values.collect();
    values.sort_unstable();
    values[values.len() / 2]
}

/// What the loop saw.
struct Seen {
    p50_us: i64,
    p99_us: i64,
    /// How often its connection broke.
    lost: u64,
    /// The most memory that the plant had.
    rss_kib: u64,
    /// The longest time from a fresh connection to its first answer.
    fresh_ms: u64,
}

/// Runs the loop for a time.
fn drive(plant: &Part, duration: Duration) -> Outcome<Seen> {
    let done = AtomicBool::new(false);
    thread::scope(|scope| {
        let watch = scope.spawn(|| {
            let (mut rss_kib, mut fresh_ms) = (0, 0);
            while !done.load(Ordering::Relaxed) {
                rss_kib = rss_kib.max(plant.rss_kib());
                let begun = Instant::now();
                let mut stream = TcpStream::connect(plant.address)?;
                stream.set_read_timeout(Some(Duration::from_secs(10)))?;
                let answered = stream
                    .write_all(GET)
                    .and_then(|()| stream.read(&mut [0; 1024]));
                let took_ms = begun.elapsed().as_millis() as u64;
                fresh_ms = fresh_ms.max(if matches!(answered, Ok(1..)) {
                    took_ms
                } else {
                    10_000
                });
                thread::sleep(Duration::from_millis(100));
            }
            Outcome::Ok((rss_kib, fresh_ms))
        });
        let driver = scope.spawn(|| {
            clock::scheduling::ask(Some(FIFO_PRIORITY));
            let (mut took, mut lost) = (Vec::new(), 0);
            let mut stream = connect(plant.address)?;
            let mut buffer = [0; 1024];
            let start = Instant::now();
            let steps = (duration.as_nanos() / H.as_nanos()) as u32;
            for k in 0..steps {
                thread::sleep((start + H * k).saturating_duration_since(Instant::now()));
                let request = format!(
                    "GET /closed?seq={k}&t_send_ns={}&u=0.1 HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n",
                    now_ns()
                );
                let sent = Instant::now();
                let answered = stream
                    .write_all(request.as_bytes())
                    .and_then(|()| stream.read(&mut buffer));
                took.push(sent.elapsed());
                if !matches!(answered, Ok(read) if buffer[..read].starts_with(b"HTTP/1.1 200 ")) {
                    lost += 1;
                    stream = connect(plant.address)?;
                }
            }
            took.sort_unstable();
            Outcome::Ok((took, lost))
        });
        let driven = driver.join().map_err(|_| "the loop ended in a panic")?;
        done.store(true, Ordering::Relaxed);
        let (took, lost) = driven?;
        let (rss_kib, fresh_ms) = watch.join().map_err(|_| "the watch ended in a panic")??;
        let at = |share: f64| took[((took.len() - 1) as f64 * share) as usize].as_micros() as i64;
        Ok(Seen {
            p50_us: at(0.5),
            p99_us: at(0.99),
            lost,
            rss_kib,
            fresh_ms,
        })
    })
}

fn connect(address: SocketAddr) -> std::io::Result<TcpStream> {
    let stream = TcpStream::connect(address)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(Duration::from_secs(5)))?;
    Ok(stream)
}

/// A process of this program, which ends with its standard input.
struct Part {
    child: Child,
    input: Option<ChildStdin>,
    address: SocketAddr,
}

impl Part {
    /// Starts it, and waits for the line with its address.
    fn start(arguments: &[&str]) -> Outcome<Self> {
        let mut child = Command::new(std::env::current_exe()?)
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let output = child.stdout.take().ok_or("no output")?;
        let mut line = String::new();
        BufReader::new(output).read_line(&mut line)?;
        let input = child.stdin.take();
        let address = line.trim().parse()?;
        Ok(Self {
            child,
            input,
            address,
        })
    }

    fn rss_kib(&self) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id()));
        let status = status.unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        let digits = line.and_then(|line| line.split_whitespace().next());
        digits.and_then(|digits| digits.parse().ok()).unwrap_or(0)
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        self.input = None;
        let _ = self.child.wait();
    }
}

/// Done when standard input ends.
async fn ended() -> std::io::Result<()> {
    let (done, is_done) = tokio::sync::oneshot::channel();
    thread::spawn(move || {
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        let _ = done.send(());
    });
    let _ = is_done.await;
    Ok(())
}

/// Says where it is, and stays on standard output no longer.
fn say(address: SocketAddr) {
    println!("{address}");
}

fn plant() -> Outcome<()> {
    let folder = tempfile::tempdir()?;
    let settings = PlantSettings::new("1ms".parse()?);
    let config = Config {
        listen: "127.0.0.1:0".parse()?,
        hosts: Vec::new(),
        settings,
        law: None,
        reference: None,
        out: folder.path().to_owned(),
        again: false,
    };
    let motor = preset::paper_plant().sampled(settings.h.ns())?.stepper();
    serve_until(&config, motor, ended(), |ready| say(ready.address))?;
    Ok(())
}

fn runtime() -> std::io::Result<tokio::runtime::Runtime> {
    clock::limit::raise_open_files();
    tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
}

fn sink() -> Outcome<()> {
    runtime()?.block_on(async {
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await?;
        say(listener.local_addr()?);
        let served = async {
            loop {
                if let Ok((mut stream, _)) = listener.accept().await {
                    tokio::spawn(async move {
                        let mut bytes = vec![0; 4096];
                        while let Ok(1..) = stream.read(&mut bytes).await {}
                    });
                }
            }
        };
        tokio::select! {
            () = served => {}
            _ = ended() => {}
        }
        Ok(())
    })
}

fn attack(attack: &'static Attack, address: SocketAddr) -> Outcome<()> {
    let runtime = runtime()?;
    say(address);
    runtime.block_on(async {
        for _ in 0..attack.connections {
            tokio::spawn(async move {
                loop {
                    let _ = assail(attack, address).await;
                    // It does not stop at a door that is shut.
                    sleep(Duration::from_millis(1)).await;
                }
            });
        }
        let _ = ended().await;
    });
    runtime.shutdown_background();
    Ok(())
}

/// One connection, to its end.
async fn assail(attack: &Attack, address: SocketAddr) -> std::io::Result<()> {
    let stream = tokio::net::TcpStream::connect(address).await?;
    let (mut from, mut to) = stream.into_split();
    let write = async {
        to.write_all(&(attack.first)()).await?;
        if attack.leaves {
            return Ok(());
        }
        loop {
            let more = (attack.again)();
            if more.is_empty() {
                std::future::pending::<()>().await;
            }
            to.write_all(&more).await?;
            sleep(attack.pause).await;
        }
    };
    let read = async {
        if !attack.reads {
            std::future::pending::<()>().await;
        }
        let mut bytes = vec![0; 1024];
        while from.read(&mut bytes).await? > 0 {}
        Ok(())
    };
    tokio::select! {
        written = write => written,
        read = read => read,
    }
}
