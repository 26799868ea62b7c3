//! A cell's setup in words: its preset, and every setting that the experiment laid over it.
//!
//! `paper-python`, `paper-python, websocket`, `worker, fetch, channel, outstanding 6`,
//! `paper-python, system pendulum`. Rate and mode
//! are not in it: they have columns of their own.

use endpoint::Timer;
use jiff::SignedDuration;
use system::System;

use crate::Cell;

impl Cell {
    /// Whether its client is set up as is usual for it, whatever the system.
    #[must_use]
    pub fn is_plain(&self) -> bool {
        let with_the_papers = Cell {
            system: System::PAPER.to_owned(),
            ..self.clone()
        };
        with_the_papers.setup() == self.client.preset().to_string()
    }

    /// The cell's setup in words; equal words are equal settings but for rate and mode.
    ///
    /// A word that only one setting has stands alone; the others follow their setting's name.
    #[must_use]
    pub fn setup(&self) -> String {
        let own = &self.settings;
        let usual = self.preset.settings(own.mode, own.h);
        let mut words = vec![self.preset.to_string()];
        let mut laid = |over: bool, word: String| {
            if over {
                words.push(word);
            }
        };
        laid(
            self.system != System::PAPER,
            format!("system {}", self.system),
        );
        laid(!self.hold.is_last(), format!("hold {}", self.hold));
        let noise = self.tick_noise.map(|law| format!("tick noise {law}"));
        laid(noise.is_some(), noise.unwrap_or_default());
        laid(own.transport != usual.transport, own.transport.to_string());
        if let Some(page) = &self.page {
            let usual = self.preset.page();
            // `worker` is a preset too, and `timeout` another setting.
            laid(
                page.thread != usual.thread,
                format!("thread {}", page.thread),
            );
            laid(page.sender != usual.sender, page.sender.to_string());
            let timer = match page.timer {
                Timer::Timeout => "timer timeout".to_owned(),
                timer => timer.to_string(),
            };
            laid(page.timer != usual.timer, timer);
            let floor = format!("timer floor {}", time(page.floor_ns));
            laid(page.floor_ns != usual.floor_ns, floor);
        }
        let outstanding = format!("outstanding {}", own.outstanding);
        laid(own.outstanding != usual.outstanding, outstanding);
        let connection = format!("connection {}", own.connection);
        laid(own.connection != usual.connection, connection);
        laid(own.schedule != usual.schedule, own.schedule.to_string());
        let integrate = format!("integrate {}", own.integrate);
        laid(own.integrate != usual.integrate, integrate);
        laid(own.late != usual.late, format!("late {}", own.late));
        let timeout = format!("timeout {}", time(own.timeout_ns));
        laid(own.timeout_ns != usual.timeout_ns, timeout);
        // A system's reference is its own. A plan by hand can have any; bit by bit, so that NaN is
        // itself.
        let is_own = self.system != System::PAPER;
        laid(
            !is_own && own.r.to_bits() != usual.r.to_bits(),
            format!("r {}", own.r),
        );
        words.join(", ")
    }
}

/// As an experiment writes it: `10ms`, `1s 500ms`.
fn time(ns: u64) -> String {
    let ns = i64::try_from(ns).unwrap_or(i64::MAX);
    format!("{:#}", SignedDuration::from_nanos(ns))
}

#[cfg(test)]
mod tests {
    use crate::{Instead, Plan, ProfileText};

    fn setups(client: &str, words: &str) -> String {
        let source = format!(
            "name = \"mine\"\n[[cells]]\ntopology = [\"arima\"]\nclient = [\"{client}\"]\n\
             mode = \"closed\"\nh = [\"3ms\"]\nduration = \"1s\"\n{words}"
        );
        let profile = |_: &str| {
            let source = link::Profile::builtin("arima")
                .expect("built in")
                .to_owned();
            Ok(ProfileText {
                source,
                ..ProfileText::default()
            })
        };
        let plan = Plan::resolve(&source, "mine.toml", &Instead::default(), profile);
        plan.expect("an experiment").cells[0].setup()
    }

    #[test]
    fn a_setup_is_its_preset_and_what_was_laid_over_it() {
        let cases = [
            ("native", "", "paper-python"),
            ("firefox", "", "worker"),
            ("chromium", "preset = \"today\"", "today"),
            // What the preset has anyway tells nothing, nor what a page does of a client that is none.
            (
                "python",
                "outstanding = \"unlimited\"\nthread = \"main\"",
                "paper-python",
            ),
            (
                "native",
                "transport = \"websocket\"",
                "paper-python, websocket",
            ),
            (
                "chromium",
                "sender = \"fetch\"\ntimer = \"channel\"\noutstanding = \"6\"",
                "worker, fetch, channel, outstanding 6",
            ),
            (
                "firefox",
                "preset = \"paper-2011\"\nthread = \"worker\"\ntimer_floor = \"4ms\"",
                "paper-2011, thread worker, timer floor 4ms",
            ),
            (
                "firefox",
                "timer = \"timeout\"\nschedule = \"relative\"",
                "worker, timer timeout, relative",
            ),
            (
                "native",
                "connection = \"new\"\nintegrate = \"elapsed\"\nlate = \"drop\"\ntimeout = \"1500ms\"",
                "paper-python, connection new, integrate elapsed, late drop, timeout 1s 500ms",
            ),
            (
                "native",
                "system = [\"quadrotor\"]\nhold = \"50ms\"",
                "paper-python, system quadrotor, hold 50ms",
            ),
        ];
        for (client, words, setup) in cases {
            assert_eq!(setups(client, words), setup, "{client}: {words}");
        }
    }
}
