//! Holds packets at the end that sends them, and releases each after the same delay, in order.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use clock::now::now_ns;
use link::Way;

use crate::packets::tcp;
use crate::queue::Queue;
use crate::target::{Target, enter, inside, tool};

const MS: u64 = 1_000_000;

/// Below the player's priority, 48, and above the ends', 45.
const PRIORITY: u8 = 47;

/// Queue numbers of the two ways, which share a namespace over loopback.
const NUMBERS: [u16; 2] = [770, 771];

/// Which packets are held.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Held {
    /// TCP to the plant's port or from it.
    Tcp,
    /// Everything except echoes.
    AllButEchoes,
    /// This percentage of the TCP segments that carry a request or an answer.
    Share(u32),
    /// The TCP segments that open a connection.
    Opening,
}

impl Held {
    /// The iptables match for these packets of a way.
    fn matched(self, way: Way) -> String {
        match self {
            Self::Tcp => tcp(way),
            Self::AllButEchoes => "! -p icmp".to_owned(),
            Self::Share(percent) => format!(
                "{} --tcp-flags PSH PSH -m statistic --mode random --probability {}",
                tcp(way),
                f64::from(percent) / 100.0
            ),
            Self::Opening => format!("{} --tcp-flags SYN SYN", tcp(way)),
        }
    }
}

/// Delays the packets of these `ways`.
pub(crate) fn delay(
    target: &Target,
    held: Held,
    delay_ms: u64,
    ways: &[Way],
) -> Result<String, String> {
    let rule = |verb: &str| {
        ways.iter().try_for_each(|way| {
            let matched = held.matched(*way);
            let number = NUMBERS[*way as usize];
            let line = format!("iptables -{verb} OUTPUT {matched} -j NFQUEUE --queue-num {number}");
            inside(target.source(*way), || tool(&line)).map(drop)
        })
    };
    let done = AtomicBool::new(false);
    thread::scope(|scope| {
        let (ready, is_ready) = mpsc::channel();
        let holders: Vec<_> = ways
            .iter()
            .map(|way| {
                let (ready, done) = (ready.clone(), &done);
                scope.spawn(move || {
                    let queue = enter(target.source(*way)).and_then(|()| {
                        let open = Queue::open(NUMBERS[*way as usize]);
                        open.map_err(|problem| format!("no netfilter queue: {problem}"))
                    });
                    // Report now: whoever waits for all queues must not wait for this thread's end.
                    let said = queue.as_ref().map(drop).map_err(Clone::clone);
                    let _ = ready.send(said);
                    drop(ready);
                    hold(&queue?, delay_ms * MS, done)
                })
            })
            .collect();
        drop(ready);
        let disturbed = is_ready
            .iter()
            .collect::<Result<(), String>>()
            .and_then(|()| {
                target.await_beginning()?;
                rule("A")?;
                let from = target.now();
                target.await_end()?;
                rule("D").map(|()| from)
            });
        thread::sleep(Duration::from_millis(delay_ms + 5));
        done.store(true, Ordering::Relaxed);
        let counts = holders.into_iter().zip(ways).map(|(holder, way)| {
            let (count, late_ns) = holder
                .join()
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
            Ok(format!(
                "{count} packets {way} (at most {:.1} ms longer)",
                late_ns as f64 / 1e6
            ))
        });
        let counts: Vec<_> = counts.collect::<Result<_, String>>()?;
        let from = disturbed?;
        Ok(format!(
            "held for {delay_ms} ms {from}: {}",
            counts.join(", ")
        ))
    })
}

/// Holds and releases packets until `done`. Returns how many, and how late the latest release was.
fn hold(queue: &Queue, delay_ns: u64, done: &AtomicBool) -> Result<(u64, u64), String> {
    let fail = |problem| format!("the netfilter queue broke: {problem}");
    clock::scheduling::ask(Some(PRIORITY));
    let (mut count, mut latest_ns) = (0, 0);
    let mut held = VecDeque::new();
    while !done.load(Ordering::Relaxed) {
        let due_ns = now_ns() + delay_ns;
        queue
            .take(|id| held.push_back((due_ns, id)))
            .map_err(fail)?;
        while let Some((due_ns, id)) = held.front().copied() {
            let Some(late_ns) = now_ns().checked_sub(due_ns) else {
                break;
            };
            queue.release(id).map_err(fail)?;
            (count, latest_ns) = (count + 1, late_ns.max(latest_ns));
            held.pop_front();
        }
        let next_ns = held
            .front()
            .map(|(due_ns, _)| due_ns.saturating_sub(now_ns()));
        queue.wait(next_ns.unwrap_or(5 * MS)).map_err(fail)?;
    }
    Ok((count, latest_ns))
}
