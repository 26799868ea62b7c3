//! Requests that are nearly right: whatever is changed in one, the plant neither breaks nor blames itself, and a
//! request that it refuses leaves the input as it was.
//!
//! Some thousand are part of the tests. `WEBLOOP_TEST_MUTATIONS=1000000` makes as many, over the same seeds and on.

use std::{
    io::{Read, Write},
    net::{Shutdown, SocketAddr, TcpStream},
    panic,
    sync::atomic::{AtomicU64, Ordering},
};

use plant::Ready;

use crate::support::{PATIENCE, config, get, with_config};

/// What is changed: each is right, or is refused for one reason.
const CORPUS: [&str; 17] = [
    "GET /closed?seq=7&t_send_ns=5&u=0.5 HTTP/1.1\r\nHost: plant\r\nAccept: application/json\r\n\r\n",
    "GET /closed?u=-1e-3 HTTP/1.1\r\nHost: 127.0.0.1:80\r\nConnection: keep-alive\r\n\r\nGET /closed?u=1 HTTP/1.1\r\nHost: plant\r\n\r\n",
    "GET /open?seq=7&t_send_ns=5&u=0.5 HTTP/1.1\r\nHost: plant\r\n\r\n",
    "GET /state HTTP/1.0\r\n\r\n",
    "GET /session HTTP/1.1\r\nHost: [::1]\r\nOrigin: http://[::1]\r\nSec-Fetch-Site: same-origin\r\n\r\n",
    "HEAD /health HTTP/1.1\r\nHost: plant\r\nReferer: http://plant/\r\n\r\n",
    "POST /session HTTP/1.1\r\nHost: plant\r\nContent-Type: application/json\r\nContent-Length: 12\r\n\r\n{\"client\":1}",
    "POST /session HTTP/1.1\r\nHost: plant\r\nContent-Type: application/json\r\nTransfer-Encoding: chunked\r\n\r\n6\r\n{\"clie\r\n6;a=b\r\nnt\":1}\r\n0\r\nX: y\r\n\r\n",
    "POST /session/rows?chunk=0 HTTP/1.1\r\nHost: plant\r\nWebloop-Session: 0123456789abcdef0123456789abcdef\r\nContent-Type: text/csv\r\nContent-Length: 2\r\n\r\n0,",
    "POST /session/end HTTP/1.1\r\nHost: plant\r\nExpect: 100-continue\r\nContent-Type: application/json\r\nContent-Length: 2\r\n\r\n{}",
    "GET /socket?mode=closed HTTP/1.1\r\nHost: plant\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n\u{1}\u{5}u=0.5",
    "GET / HTTP/1.1\r\nHost: localhost\r\n\r\nGET /openapi.json HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n",
    "OPTIONS * HTTP/1.1\r\nHost: plant\r\n\r\n",
    "CONNECT plant:80 HTTP/1.1\r\nHost: plant:80\r\n\r\n",
    "POST /closed HTTP/1.1\r\nHost: plant\r\nContent-Type: application/json\r\nContent-Length: 7\r\n\r\n{\"u\":1}GET /state HTTP/1.1\r\nHost: plant\r\n\r\n",
    "POST /closed HTTP/1.1\r\nHost: plant\r\nContent-Type: application/json\r\nTransfer-Encoding: chunked\r\n\r\n4\r\n{\"u\"\r\n5\r\n:0.5}\r\n0\r\n\r\n",
    "mode=closed\nseq=1&t_send_ns=5&u=0.5\nu=0.25\n\nseq=2&u=-1\n",
];

/// What is put in.
const WORDS: [&[u8]; 34] = [
    b"\r\n",
    b"\n",
    b"\r",
    b"\0",
    b" ",
    b"\t",
    b":",
    b"\x80",
    b"\xff",
    b"\x1b[2J",
    b"%00",
    b"%",
    b"&u=1",
    b"u=NaN",
    b"1e999",
    b"-0",
    b"9007199254740993",
    b"\r\nContent-Length: 3",
    b"\r\nContent-Length: 0",
    b"\r\nTransfer-Encoding: chunked",
    b"\r\nTransfer-Encoding: x",
    b"\r\nHost: a",
    b"Host: ",
    b"\r\n\r\n",
    b"0\r\n\r\n",
    b"HTTP/1.1",
    b"GET /closed?u=9 HTTP/1.1\r\n",
    b"\x81\x85\0\0\0\0u=9.5",
    b"\x88\x80\0\0\0\0",
    b"\x89\xff",
    b"ffffffffffffffff",
    b"\r\nConnection: close",
    b"\nu=7\n",
    b"mode=open\n",
];

/// The numbers of a seed (splitmix64).
struct Draws(u64);

impl Draws {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % limit.max(1) as u64) as usize
    }

    /// A request of the corpus with up to four changes.
    fn request(&mut self) -> Vec<u8> {
        let mut bytes = CORPUS[self.below(CORPUS.len())].as_bytes().to_vec();
        for _ in 0..1 + self.below(4) {
            let at = self.below(bytes.len());
            let end = (at + self.below(20)).min(bytes.len());
            match self.below(8) {
                0 if !bytes.is_empty() => bytes[at] ^= 1 << self.below(8),
                1 if !bytes.is_empty() => bytes[at] = self.below(256) as u8,
                2 => drop(bytes.drain(at..end)),
                3 => bytes.extend_from_within(at..end),
                4 => bytes.truncate(at),
                5 => {
                    let other = CORPUS[self.below(CORPUS.len())].as_bytes();
                    let from = self.below(other.len());
                    bytes.splice(at..end, other[from..].iter().copied());
                }
                _ => drop(bytes.splice(at..at, WORDS[self.below(WORDS.len())].iter().copied())),
            }
        }
        bytes
    }
}

/// All that comes back on a connection of its own.
fn answers(address: SocketAddr, bytes: &[u8]) -> String {
    let mut stream = TcpStream::connect(address).expect("the plant listens");
    stream
        .set_read_timeout(Some(PATIENCE))
        .expect("a valid timeout");
    // It may have refused and closed already.
    let _ = stream.write_all(bytes);
    let _ = stream.shutdown(Shutdown::Write);
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    String::from_utf8_lossy(&answer).into_owned()
}

/// The statuses of answers, one behind the other.
fn statuses(text: &str) -> impl Iterator<Item = u16> + '_ {
    let heads = text.split("HTTP/1.").skip(1);
    heads.filter_map(|head| head.get(2..5)?.parse().ok())
}

#[test]
fn whatever_is_changed_in_a_request_a_refused_one_moves_nothing() {
    static PANICS: AtomicU64 = AtomicU64::new(0);
    let shown = panic::take_hook();
    panic::set_hook(Box::new(move |panic| {
        PANICS.fetch_add(1, Ordering::Relaxed);
        shown(panic);
    }));
    let count = std::env::var("WEBLOOP_TEST_MUTATIONS");
    let count: u64 = count.map_or(4_000, |text| text.parse().expect("a number"));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (mut moved, before_kib) = (0_u64, resident_kib());
    with_config(config(folder.path()), |Ready { address, .. }| {
        let held = || {
            let (_, body) = get(address, "/state", "*/*");
            let mut fields = body.trim().split('&');
            let u = fields.find_map(|field| field.strip_prefix("u="));
            let u = u.expect("an input");
            u.parse::<f64>().expect("a finite input")
        };
        let mut before = held();
        for seed in 0..count {
            let request = Draws(seed).request();
            let text = answers(address, &request);
            for status in statuses(&text) {
                assert!(status < 500, "seed {seed}: {text}");
            }
            let after = held();
            if after.to_bits() != before.to_bits() {
                // A socket's answers are frames, and a command may be one of two requests.
                let has_taken = statuses(&text).any(|status| status == 200 || status == 101);
                let says = has_taken || text.lines().any(|line| line.starts_with("seq="));
                assert!(
                    says && after.is_finite(),
                    "seed {seed}: {before} {after} {text}"
                );
                moved += 1;
            }
            before = after;
        }
        assert!(moved > 0, "some are right");
    })
    .expect("a run without errors");
    assert_eq!(PANICS.load(Ordering::Relaxed), 0);
    let more_kib = resident_kib().saturating_sub(before_kib);
    println!(
        "row 12: {count} mutated requests: 0 panics, 0 answers of 5xx, {moved} inputs, each by a request that was taken, 0 by a refused one; memory +{:.1} MiB, with the test's own",
        more_kib as f64 / 1024.0
    );
    assert!(more_kib < 16 << 10, "{more_kib} KiB more");
}

/// Memory of this process that is resident, KiB; the plant is a thread of it.
fn resident_kib() -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").expect("Linux");
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let number = line.and_then(|line| line.split_whitespace().next());
    number.expect("VmRSS").parse().expect("a number")
}
