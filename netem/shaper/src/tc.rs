//! Plays one way of a link by a netem at the root of an interface, changed in time by tc.
//!
//! The kernel delays and drops the packets; this thread passes each change to tc when it is due.
//! The [staircase](link::Staircase) computes the changes and their steps.

pub(crate) mod batch;
pub(crate) mod command;
pub(crate) mod qdisc;
pub(crate) mod tally;

use std::fs;
use std::io;
use std::os::fd::AsFd;
use std::sync::atomic::{AtomicBool, Ordering};

use clock::now::{SECOND_NS, now_ns, timespec};
use link::certificate::{Histogram, Scheduling, TcReport, TcRow};
use link::{Change, Epoch, LinkTime, Pace, Profile, STEP_NS, Setting, Staircase, Verb, Way};
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use serde_json::Value;

use crate::error::{Doing, Error, Result};
use crate::network::veth::send_whole_packets;
use crate::scheduling::{prefer_this_thread, reported};
use crate::tc::batch::Batch;
use crate::tc::command::{Restore, claim, list, version};
use crate::tc::qdisc::{Owner, Root};
use crate::tc::tally::TcTally;

/// The same as for the [player](crate::play) in user space, and for the same reason. tc inherits it.
const PRIORITY: u8 = 48;

/// The longest sleep, so that a request to stop is seen soon.
const LONGEST_SLEEP_NS: u64 = 50_000_000;

/// How far ahead the next change is looked up: longer than the lookup and a sleep may take.
const AHEAD_NS: u64 = 2 * LONGEST_SLEEP_NS;

/// tc answers within a millisecond, on the slowest machine tried within ten.
const ANSWER_NS: u64 = 2 * SECOND_NS;

/// What to play.
#[derive(Debug)]
pub struct TcConfig {
    /// The link to play.
    pub profile: Profile,
    /// The seed of the link.
    pub seed: u64,
    /// The monotonic instant of link time 0.
    pub epoch: Epoch,
    /// The link time from which on the link is played. Before it, the empty link is.
    pub opens: LinkTime,
    /// The direction to play.
    pub way: Way,
    /// The interface, in the namespace of the calling thread, through which this way's
    /// packets leave.
    pub device: String,
}

/// An answer of tc.
struct TcReply {
    asked_ns: u64,
    root: Root,
    text: Value,
}

/// A netem that is set up, and a tc that waits for its changes. If dropped without having been
/// played, it removes both.
pub struct TcPlayer {
    // Fields are dropped in order of declaration: tc first, then what it has set up.
    batch: Batch,
    restore: Restore,
    staircase: Staircase,
    way: Way,
    epoch: Epoch,
    started_ns: u64,
    scheduling: Scheduling,
    tc: String,
    found: Value,
    first: Value,
    /// The next change, once it has been looked up.
    next: Option<Change>,
    in_force: Option<Setting>,
    /// When the outstanding question was put to tc, and the setting at that time.
    asked: Option<(u64, Setting)>,
    tally: TcTally,
    answers: Histogram,
    skipped: u64,
}

impl TcPlayer {
    /// Sets up the empty link and reads back that the kernel plays it. From then on the offloads of
    /// the interface are off, so that netem gets single packets.
    ///
    /// Requests real-time scheduling for the calling thread, so that tc inherits it: play on the same
    /// thread, and start others first.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if there is no tc, no netem or no right to use it. [`Error::Failed`] if
    /// another program shapes the interface, which is then left as it is, or if the kernel plays
    /// something else than requested.
    pub fn start(config: TcConfig) -> Result<Self> {
        let tc = version()?;
        let found = claim(&config.device)?.text;
        send_whole_packets(&config.device)?;
        let scheduling = reported(&prefer_this_thread(PRIORITY));
        let mut player = Self {
            batch: Batch::start()?,
            restore: Restore {
                device: Some(config.device),
            },
            staircase: Staircase::new(&config.profile, config.seed, config.way),
            way: config.way,
            epoch: config.epoch,
            started_ns: now_ns(),
            scheduling,
            tc,
            found,
            first: Value::Null,
            next: None,
            in_force: None,
            asked: None,
            tally: TcTally::new(config.way),
            answers: Histogram::new(),
            skipped: 0,
        };
        // The empty link is constant, so its first change is the only one.
        let mut empty = Staircase::new(&Profile::empty(), 0, config.way);
        if let Some(change) = empty.next_before(LinkTime::ZERO.after(1)) {
            player.set(Verb::Add, change.setting)?;
        }
        player.first = player.ask_and_wait()?.text;
        // The link opens with the setting that is in force then. Looked up in advance, since it takes a millisecond
        // to follow a second of a restless link.
        while let Some(change) = player.staircase.next_before(config.opens.after(1)) {
            let at = config.opens;
            player.next = Some(Change { at, ..change });
        }
        Ok(player)
    }

    /// Plays until `stop` is set. At the end the interface has the kernel's queueing discipline
    /// again, however the play ends, except by a kill.
    ///
    /// `on_second` gets a row once a second and at the end. It is called between two changes, so it
    /// must neither wait nor write.
    ///
    /// # Errors
    /// [`Error::Failed`] if tc ends, or if the kernel plays something else than requested.
    pub fn play(mut self, stop: &AtomicBool, mut on_second: impl FnMut(TcRow)) -> Result<TcReport> {
        let mut row_due_ns = now_ns() + SECOND_NS;
        while !stop.load(Ordering::Relaxed) {
            self.change_if_due()?;
            if let Some(answer) = self.take_answer()? {
                on_second(self.tally.row(answer.asked_ns, answer.root.counters));
            }
            if now_ns() >= row_due_ns {
                self.ask()?;
                row_due_ns += SECOND_NS;
            }
            self.wait(row_due_ns)?;
        }
        let last = self.ask_and_wait()?;
        on_second(self.tally.row(last.asked_ns, last.root.counters));
        let device = self.take_away()?;
        Ok(TcReport {
            tc: self.tc,
            kernel: kernel_release(),
            scheduling: self.scheduling,
            epoch: self.epoch,
            started_ns: self.started_ns,
            ended_ns: last.asked_ns,
            device,
            way: self.way,
            step_ns: STEP_NS,
            changes: self.tally.changes(),
            skipped: self.skipped,
            answer: self.answers.summary(),
            found: self.found,
            first: self.first,
            last: last.text,
            traffic: self.tally.report(),
        })
    }

    fn device(&self) -> &str {
        self.restore.device.as_deref().unwrap_or_default()
    }

    fn set(&mut self, verb: Verb, setting: Setting) -> Result<()> {
        let command = setting.command(verb, self.device());
        self.batch.send(&command)?;
        self.in_force = Some(setting);
        let limited = matches!(setting.pace, Pace::Limited(_));
        self.tally.room(setting.limit, limited);
        Ok(())
    }

    /// Makes the change that is due now. A change overtaken by the next one is skipped.
    fn change_if_due(&mut self) -> Result<()> {
        let epoch = self.epoch;
        let is_due = |change: &mut Change| epoch.t_ns(change.at) <= now_ns();
        let Some(mut due) = self.next.take_if(is_due) else {
            return Ok(());
        };
        let now = epoch.link_time(now_ns()).unwrap_or_default();
        while let Some(newer) = self.staircase.next_before(now) {
            due = newer;
            self.skipped += 1;
        }
        self.set(Verb::Change, due.setting)?;
        let late_ns = now_ns().saturating_sub(epoch.t_ns(due.at));
        self.tally.changed(late_ns);
        Ok(())
    }

    /// Asks tc for the current setting, unless an answer is outstanding.
    fn ask(&mut self) -> Result<()> {
        if let (None, Some(setting)) = (self.asked, self.in_force) {
            self.asked = Some((now_ns(), setting));
            let inquiry = Setting::inquiry(self.device());
            self.batch.send(&inquiry)?;
        }
        Ok(())
    }

    /// The answer, if it has come. An error if the kernel played another setting than requested.
    fn take_answer(&mut self) -> Result<Option<TcReply>> {
        let Some((asked_ns, setting)) = self.asked else {
            return Ok(None);
        };
        let Some(answer) = self.batch.answer()? else {
            return Ok(None);
        };
        self.asked = None;
        self.answers.add(now_ns().saturating_sub(asked_ns), 1);
        let confirm = || -> io::Result<TcReply> {
            let text: Value = serde_json::from_slice(&answer)?;
            let root = Root::of(&text)?;
            root.confirm(&setting).map_err(io::Error::other)?;
            Ok(TcReply {
                asked_ns,
                root,
                text,
            })
        };
        confirm()
            .doing_with(|| format!("make `{}` play `{setting}`", self.device()))
            .map(Some)
    }

    /// Asks and waits for the answer. An outstanding answer is awaited first and discarded.
    fn ask_and_wait(&mut self) -> Result<TcReply> {
        if self.asked.is_some() {
            self.wait_for_answer()?;
        }
        self.ask()?;
        self.wait_for_answer()
    }

    fn wait_for_answer(&mut self) -> Result<TcReply> {
        let end_ns = now_ns() + ANSWER_NS;
        while now_ns() < end_ns {
            if let Some(answer) = self.take_answer()? {
                return Ok(answer);
            }
            self.sleep(end_ns)?;
        }
        Err(Error::Failed {
            action: format!("read back what is in force on `{}`", self.device()),
            source: io::Error::new(io::ErrorKind::TimedOut, "tc does not answer"),
        })
    }

    /// Sleeps until the next change, the next row or an answer.
    fn wait(&mut self, row_due_ns: u64) -> Result<()> {
        if self.next.is_none()
            && let Some(end) = self.epoch.link_time(now_ns() + AHEAD_NS)
        {
            self.next = self.staircase.next_before(end);
        }
        let change_ns = self
            .next
            .map_or(u64::MAX, |change| self.epoch.t_ns(change.at));
        self.sleep(change_ns.min(row_due_ns))
    }

    fn sleep(&self, until_ns: u64) -> Result<()> {
        let left_ns = until_ns.saturating_sub(now_ns()).min(LONGEST_SLEEP_NS);
        if left_ns == 0 {
            return Ok(());
        }
        let mut answers = [PollFd::from_borrowed_fd(self.batch.as_fd(), PollFlags::IN)];
        match poll(&mut answers, Some(&timespec(left_ns))) {
            // After a signal the caller checks `stop`.
            Ok(_) | Err(Errno::INTR) => Ok(()),
            Err(error) => Err(io::Error::from(error)).doing("wait for the next change"),
        }
    }

    /// Removes the netem and makes sure that it is gone. Returns the interface's name.
    fn take_away(&mut self) -> Result<String> {
        let device = self.device().to_owned();
        self.batch.send(&Setting::removal(&device))?;
        self.batch.finish()?;
        self.restore.device = None;
        match list(&device)?.root.owner() {
            Owner::Kernel => Ok(device),
            owner => Err(Error::Failed {
                action: format!("restore `{device}`"),
                source: io::Error::other(format!("its root is now {owner:?}")),
            }),
        }
    }
}

/// The kernel's release, as reported by the kernel.
fn kernel_release() -> String {
    let release = fs::read_to_string("/proc/sys/kernel/osrelease");
    release.map_or_else(|_| "unknown".into(), |text| text.trim().to_owned())
}
