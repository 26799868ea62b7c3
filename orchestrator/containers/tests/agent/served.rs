//! An agent on a thread of the test, and requests to it, byte by byte.

use std::fs;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::mpsc;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use containers::{AgentName, Config, Ended, Error, Remote, Token};
use tempfile::TempDir;

/// The token that tests claim with.
pub(crate) const TOKEN: &str = "0123456789abcdef-mine";

/// Another orchestrator's.
pub(crate) const OTHER: &str = "0123456789abcdef-other";

/// Generous: for what takes milliseconds on an idle machine.
pub(crate) const SOON: Duration = Duration::from_secs(10);

pub(crate) struct Served {
    pub(crate) address: SocketAddr,
    pub(crate) folder: TempDir,
    thread: Option<JoinHandle<Result<Ended, Error>>>,
}

/// An answer, as it came.
#[derive(Debug)]
pub(crate) struct Answer {
    pub(crate) status: u16,
    pub(crate) head: String,
    pub(crate) body: Vec<u8>,
}

impl Answer {
    pub(crate) fn json(&self) -> serde_json::Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|_| panic!("{}", self.text()))
    }

    pub(crate) fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }
}

impl Served {
    /// An agent that nobody has claimed.
    pub(crate) fn unclaimed(change: impl FnOnce(&mut Config)) -> Served {
        let folder = tempfile::tempdir().unwrap();
        let mut config = Config {
            listen: "127.0.0.1:0".parse().unwrap(),
            hosts: vec!["agent".to_owned(), "a".to_owned()],
            name: AgentName::Plant,
            scratch: folder.path().join("scratch"),
            token: None,
            unclaimed: Config::UNCLAIMED,
            silence: Config::SILENCE,
            program: stand_in(folder.path()),
        };
        change(&mut config);
        let (sender, ready) = mpsc::channel();
        let thread = thread::spawn(move || {
            containers::serve(&config, |address| sender.send(address).unwrap())
        });
        Served {
            address: ready.recv_timeout(SOON).unwrap(),
            folder,
            thread: Some(thread),
        }
    }

    /// An agent that is ours and in the run `r1`.
    pub(crate) fn claimed() -> Served {
        let served = Served::unclaimed(|_| {});
        assert_eq!(served.ask("POST", "/claim", b"").status, 200);
        assert_eq!(served.ask("PUT", "/run/r1", b"").status, 201);
        served
    }

    pub(crate) fn remote(&self) -> Remote {
        let token: Token = TOKEN.parse().unwrap();
        let remote = Remote::open(AgentName::Plant, &self.address.to_string(), token).unwrap();
        remote.wait_healthy(SOON).unwrap();
        remote.claim().unwrap();
        remote
    }

    /// The folder of the agent's runs.
    pub(crate) fn scratch(&self) -> PathBuf {
        self.folder.path().join("scratch/webloop-plant")
    }

    pub(crate) fn ask(&self, method: &str, path: &str, body: &[u8]) -> Answer {
        self.ask_as(Some(TOKEN), method, path, body)
    }

    pub(crate) fn ask_as(
        &self,
        token: Option<&str>,
        method: &str,
        path: &str,
        body: &[u8],
    ) -> Answer {
        let authorization = token.map_or(String::new(), |token| {
            format!("Authorization: Bearer {token}\r\n")
        });
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: agent\r\nConnection: close\r\n{authorization}Content-Length: {}\r\n\r\n",
            body.len()
        );
        self.raw(&[head.as_bytes(), body].concat())
    }

    /// Starts a role that behaves like `how`.
    pub(crate) fn start(&self, instance: &str, how: &str) -> Answer {
        let body = format!(r#"{{"role": "plant", "settings": {{"h": "{how}"}}}}"#);
        self.ask("POST", &format!("/run/r1/role/{instance}"), body.as_bytes())
    }

    /// Sends bytes, and reads to the end of the connection.
    pub(crate) fn raw(&self, bytes: &[u8]) -> Answer {
        let mut stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(2 * SOON)).unwrap();
        // An agent that has refused need not read on.
        let _ = stream.write_all(bytes);
        let mut all = Vec::new();
        let _ = stream.read_to_end(&mut all);
        let end = all.windows(4).position(|four| four == b"\r\n\r\n");
        let end = end.unwrap_or_else(|| panic!("no answer: {}", String::from_utf8_lossy(&all)));
        let head = String::from_utf8_lossy(&all[..end]).into_owned();
        Answer {
            status: head[9..12].parse().unwrap(),
            head,
            body: all[end + 4..].to_vec(),
        }
    }

    /// Waits for the agent's end.
    pub(crate) fn ended(&mut self, within: Duration) -> Ended {
        let thread = self.thread.take().unwrap();
        let deadline = Instant::now() + within;
        while !thread.is_finished() {
            assert!(
                Instant::now() < deadline,
                "the agent did not end within {within:?}"
            );
            thread::sleep(Duration::from_millis(5));
        }
        thread.join().unwrap().unwrap()
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        if let Some(thread) = self.thread.take()
            && !thread.is_finished()
        {
            // A test that never claimed it claims it now.
            let _ = self.ask("POST", "/claim", b"");
            let _ = self.ask("POST", "/end", b"");
            if !thread::panicking() {
                thread.join().unwrap().unwrap();
            }
        }
    }
}

/// Whether the process is gone, or goes within a generous time.
pub(crate) fn gone(process: u32) -> bool {
    let deadline = Instant::now() + SOON;
    let there = || fs::exists(format!("/proc/{process}")).unwrap();
    while there() && Instant::now() < deadline {
        thread::sleep(Duration::from_millis(5));
    }
    !there()
}

/// The process number that a stand-in says when it is ready.
pub(crate) fn process(answer: &Answer) -> u32 {
    let ready = answer.json()["ready"].as_str().unwrap().to_owned();
    ready.split(' ').next().unwrap().parse().unwrap()
}

/// The stand-in as a program. Another process makes it: a file that any thread here has open for
/// writing cannot be executed by the child that another thread forks meanwhile.
fn stand_in(folder: &Path) -> PathBuf {
    let program = folder.join("stand-in");
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/agent/stand-in.sh");
    let status = Command::new("install")
        .args(["-m", "755", script])
        .arg(&program)
        .status();
    assert!(status.unwrap().success());
    program
}
