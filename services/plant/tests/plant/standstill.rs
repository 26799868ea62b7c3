//! Connections that stand still: each is closed when its step has taken too long, also among a thousand of its kind.

use std::{env, ops::Range, thread, time::Duration};

use plant::Ready;
use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    net::TcpStream,
    time::{Instant, timeout},
};

use crate::support::{PATIENCE, config, with_config};

/// A kind of connection: what is sent on it before it stands still, how the plant's answer begins, and after how
/// many seconds of silence the plant closes it.
struct Kind {
    name: &'static str,
    text: &'static str,
    says: &'static str,
    after_s: u64,
}

const CLAIM: &str = "POST /session HTTP/1.1\r\nHost: plant\r\nContent-Type: application/json\r\n";

const KINDS: [Kind; 7] = [
    kind("nothing", "", "", 5),
    kind("half a line", "GET /state", "HTTP/1.1 408 ", 5),
    kind(
        "half a head",
        "GET /state HTTP/1.1\r\nHost: plant\r\n",
        "HTTP/1.1 408 ",
        5,
    ),
    kind(
        "half a body",
        "CLAIMContent-Length: 20\r\n\r\n{",
        "HTTP/1.1 408 ",
        5,
    ),
    kind(
        "half a chunk",
        "CLAIMTransfer-Encoding: chunked\r\n\r\n5\r\n{",
        "HTTP/1.1 408 ",
        5,
    ),
    kind(
        "no second request",
        "GET /state HTTP/1.1\r\nHost: plant\r\n\r\n",
        "HTTP/1.1 200 ",
        5,
    ),
    // Beside another that moves the plant, a controller's idle connection has twice as long.
    kind(
        "no second command",
        "GET /closed?u=0 HTTP/1.1\r\nHost: plant\r\n\r\n",
        "HTTP/1.1 200 ",
        10,
    ),
];

const fn kind(name: &'static str, text: &'static str, says: &'static str, after_s: u64) -> Kind {
    Kind {
        name,
        text,
        says,
        after_s,
    }
}

impl Kind {
    /// After which times it must be closed. A busy machine may take a second more for that.
    fn limits(&self) -> Range<Duration> {
        Duration::from_millis(4_800)..Duration::from_millis(self.after_s * 1000 + 1_500)
    }

    /// How long each of `count` connections at once stood still, the quickest first.
    fn stand(&self, count: usize) -> Vec<Duration> {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut took = Vec::new();
        with_config(config(folder.path()), |Ready { address, .. }| {
            let runtime = tokio::runtime::Builder::new_current_thread()
                .enable_all()
                .build();
            let text = self.text.replace("CLAIM", CLAIM);
            runtime.expect("a runtime").block_on(async {
                let stand = || {
                    let text = text.clone();
                    tokio::spawn(async move {
                        let mut stream = TcpStream::connect(address).await.expect("it listens");
                        stream.write_all(text.as_bytes()).await.expect("it reads");
                        let begun = Instant::now();
                        let mut answer = Vec::new();
                        let read = timeout(PATIENCE, stream.read_to_end(&mut answer)).await;
                        (read.is_ok(), begun.elapsed(), answer)
                    })
                };
                let standing: Vec<_> = (0..count).map(|_| stand()).collect();
                for connection in standing {
                    let (is_closed, elapsed, answer) = connection.await.expect("no panic");
                    assert!(is_closed, "{}: open after {elapsed:?}", self.name);
                    assert!(
                        answer.starts_with(self.says.as_bytes()),
                        "{}: {}",
                        self.name,
                        String::from_utf8_lossy(&answer)
                    );
                    took.push(elapsed);
                }
            });
        })
        .expect("a run without errors");
        took.sort_unstable();
        took
    }
}

#[test]
fn a_connection_that_stands_still_is_closed_within_five_seconds() {
    serial::timed(
        "a_connection_that_stands_still_is_closed_within_five_seconds",
        || {
            let count = env::var("WEBLOOP_TEST_STANDING").ok();
            let count = count.map_or(1, |text| text.parse().expect("a number"));
            clock::limit::raise_open_files();
            let of = |kind: &Kind| {
                let took = kind.stand(count);
                for one in &took {
                    assert!(kind.limits().contains(one), "{}: {one:?}", kind.name);
                }
                took
            };
            let took: Vec<Vec<Duration>> = if count == 1 {
                thread::scope(|scope| {
                    let kinds = KINDS.each_ref();
                    let standing = kinds.map(|kind| scope.spawn(move || of(kind)));
                    standing.map(|kind| kind.join().expect("no panic")).into()
                })
            } else {
                // One kind after the other, so that none has more connections beside it than its own.
                KINDS.iter().map(of).collect()
            };
            for (kind, took) in KINDS.iter().zip(&took) {
                let within = Duration::from_millis(kind.after_s * 1000 + 500);
                let at =
                    |share: f64| took[((took.len() - 1) as f64 * share) as usize].as_secs_f64();
                println!(
                    "row 14: `{}`, {count} at once: {} closed within {within:?}; p1 {:.2} s, p50 {:.2} s, p99 {:.2} s, \
                 the last after {:.2} s",
                    kind.name,
                    took.iter().filter(|one| **one <= within).count(),
                    at(0.01),
                    at(0.5),
                    at(0.99),
                    at(1.0)
                );
            }
        },
    );
}
