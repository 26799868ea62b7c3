//! The paper's PI controller for the motor, with Rust's standard library alone.
//!
//! A request at a time, on one kept connection, at the deadlines start + k h. Deadlines that pass while
//! an answer is late are skipped, and the integral advances by them too. The standard library does not
//! tell the monotonic clock's time, so the start is the wall clock's, `WEBLOOP_START`.

use std::env;
use std::error::Error;
use std::io::{self, BufRead, BufReader, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::process::ExitCode;
use std::thread::sleep;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// How long a message waits for its answer.
const TIMEOUT: Duration = Duration::from_secs(5);

/// The plant, on one kept connection.
struct Plant {
    address: SocketAddr,
    connection: Option<BufReader<TcpStream>>,
}

impl Plant {
    /// The output y that it answers; `None` if no answer comes in time, or one without y.
    fn get(&mut self, path: &str) -> Option<f64> {
        let body = self.exchange(path).ok()?;
        let (_, rest) = body.split_once("&y=")?;
        rest.split('&').next()?.parse().ok()
    }

    /// The body of an answer. After an error there is no connection; the next request opens one.
    fn exchange(&mut self, path: &str) -> io::Result<String> {
        let mut connection = match self.connection.take() {
            Some(connection) => connection,
            None => self.connect()?,
        };
        let request = format!("GET {path} HTTP/1.1\r\nHost: {}\r\n\r\n", self.address);
        connection.get_mut().write_all(request.as_bytes())?;
        let (mut length, mut is_kept) = (0_u64, true);
        loop {
            let mut line = String::new();
            if connection.read_line(&mut line)? == 0 {
                return Err(ErrorKind::UnexpectedEof.into());
            }
            let line = line.trim().to_ascii_lowercase();
            match line.split_once(':') {
                Some(("content-length", value)) => {
                    length = value.trim().parse().map_err(io::Error::other)?;
                }
                Some(("connection", value)) => is_kept = value.trim() != "close",
                None if line.is_empty() => break,
                _ => {}
            }
        }
        let mut body = String::new();
        let mut rest = connection.by_ref().take(length);
        let bytes = rest.read_to_string(&mut body)?;
        if (bytes as u64) < length {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        self.connection = is_kept.then_some(connection);
        Ok(body)
    }

    fn connect(&self) -> io::Result<BufReader<TcpStream>> {
        let stream = TcpStream::connect_timeout(&self.address, TIMEOUT)?;
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(TIMEOUT))?;
        stream.set_write_timeout(Some(TIMEOUT))?;
        Ok(BufReader::new(stream))
    }
}

/// A variable of the environment.
fn told(name: &str) -> Result<String, String> {
    let remedy = "start this program by `webloop run` or `webloop conform`";
    env::var(name).map_err(|_| format!("{name} is not set; {remedy}"))
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    if told("WEBLOOP_MODE")? != "closed" {
        return Ok(ExitCode::from(127)); // an open loop is not supported
    }
    let h_s: f64 = told("WEBLOOP_H_S")?.parse()?;
    let r: f64 = told("WEBLOOP_R")?.parse()?;
    let start_s: f64 = told("WEBLOOP_START")?.parse()?;
    let duration_s: f64 = told("WEBLOOP_DURATION_S")?.parse()?;
    let address: SocketAddr = told("WEBLOOP_PLANT")?.replace("http://", "").parse()?;
    let connection = None;
    let mut plant = Plant { address, connection };

    let ahead_s = start_s - SystemTime::now().duration_since(UNIX_EPOCH)?.as_secs_f64();
    let origin = Instant::now();
    let now_s = || origin.elapsed().as_secs_f64() - ahead_s; // since the start
    let mut seen = None;
    while seen.is_none() && now_s() < -0.05 {
        seen = plant.get("/state");
        sleep(Duration::from_millis(20));
    }
    let mut y = seen.unwrap_or(0.0); // at rest
    let (mut integral, mut k, mut passed) = (0.0, 0.0, 1.0);
    loop {
        // What has passed is negative, and no duration.
        sleep(Duration::try_from_secs_f64(k * h_s - now_s()).unwrap_or_default());
        if k * h_s >= duration_s {
            return Ok(ExitCode::SUCCESS);
        }
        let e = r - y;
        integral += 0.378 * (passed * h_s) * e;
        let u = 0.1701 * e + integral;
        y = plant.get(&format!("/closed?u={u:?}")).unwrap_or(y);
        passed = ((now_s() / h_s).floor() - k).max(1.0);
        k += passed;
    }
}
