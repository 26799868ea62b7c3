//! What the tests of this crate share: a small HTTP server, one visit at a
//! time, and what to do where there is no browser.

use std::{
    collections::HashMap,
    fs,
    io::{BufRead, BufReader, Read, Write},
    net::{SocketAddr, TcpListener, TcpStream},
    os::unix::fs::PermissionsExt,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    thread,
};

use browser::Engine;
use tempfile::TempDir;

/// A browser is a process-wide matter, and two at a time spoil each other's limits.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// Waits for all other tests that start a browser.
pub(crate) fn alone() -> MutexGuard<'static, ()> {
    ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The browsers of this machine; a test without any is skipped, and says so.
pub(crate) fn engines() -> Vec<Engine> {
    let found = |engine: &Engine| match browser::found(*engine) {
        Ok(_) => true,
        Err(missing) => {
            println!("SKIPPED: {missing}");
            false
        }
    };
    Engine::ALL.iter().copied().filter(found).collect()
}

/// A folder for a browser's own, that another user may pass through.
pub(crate) fn scratch() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let mode = fs::Permissions::from_mode(0o711);
    fs::set_permissions(folder.path(), mode).expect("its mode");
    folder
}

/// What was asked.
pub(crate) struct Request {
    pub(crate) method: String,
    /// Without the query.
    pub(crate) path: String,
    pub(crate) query: String,
    pub(crate) body: String,
}

/// What is answered: status, content type, body.
pub(crate) type Response = (u16, &'static str, Vec<u8>);

/// Serves on a free port of loopback as long as the test runs. All answers have
/// the headers that isolate a page.
pub(crate) fn serve(answer: impl Fn(&Request) -> Response + Send + Sync + 'static) -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = listener.local_addr().expect("its address");
    let answer = Arc::new(answer);
    thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let answer = Arc::clone(&answer);
            // A connection that breaks is its client's business.
            thread::spawn(move || exchange(&stream, &*answer));
        }
    });
    address
}

fn exchange(stream: &TcpStream, answer: &impl Fn(&Request) -> Response) -> std::io::Result<()> {
    let mut lines = BufReader::new(stream);
    let mut first = String::new();
    lines.read_line(&mut first)?;
    let mut words = first.split_whitespace();
    let method = words.next().unwrap_or_default().to_owned();
    let target = words.next().unwrap_or_default();
    let (path, query) = target.split_once('?').unwrap_or((target, ""));
    let mut headers = HashMap::new();
    loop {
        let mut line = String::new();
        lines.read_line(&mut line)?;
        let Some((name, value)) = line.split_once(':') else {
            break;
        };
        headers.insert(name.to_ascii_lowercase(), value.trim().to_owned());
    }
    let length = headers.get("content-length").and_then(|n| n.parse().ok());
    let mut body = vec![0; length.unwrap_or(0)];
    lines.read_exact(&mut body)?;
    let (status, kind, content) = answer(&Request {
        method,
        path: path.to_owned(),
        query: query.to_owned(),
        body: String::from_utf8_lossy(&body).into_owned(),
    });
    let mut stream = stream;
    write!(
        stream,
        "HTTP/1.1 {status} -\r\nContent-Type: {kind}\r\nContent-Length: {}\r\n\
         Connection: close\r\nCache-Control: no-store\r\n\
         Cross-Origin-Opener-Policy: same-origin\r\n\
         Cross-Origin-Embedder-Policy: require-corp\r\n\
         Cross-Origin-Resource-Policy: same-origin\r\n\r\n",
        content.len()
    )?;
    stream.write_all(&content)
}
