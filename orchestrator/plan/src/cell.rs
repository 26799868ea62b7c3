//! The unit of work: one topology, client, mode, rate and repeat, with everything a run needs.

use std::path::{Path, PathBuf};

use crate::system::System;
use endpoint::{
    Clock, ControllerSettings, Hold, Lease, NoiseLaw, PageSettings, PlantSettings, Policy, Preset,
    Reference, SampleTime, Shape, TickNoise, Transport,
};
use link::LinkTime;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::client::Client;
use crate::file_name;
use crate::seed::fingerprint;

/// Link time of the client's first message. It is the same in every back-end, so that every client
/// meets the same bad second.
pub const START_AT: LinkTime = LinkTime::from_ns(1_300_000_000);

/// One run to be made: resolved, valid, independent of every other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// Its place in the plan, from 0.
    pub index: usize,
    /// Readable and unique in its plan: `couva-native-closed-333hz-r01-3fa2c1`. Names its folder.
    pub id: String,
    /// Name of the link's profile.
    pub topology: String,
    /// Name of the plant and its law.
    #[serde(default = "paper_system", skip_serializing_if = "is_paper_system")]
    pub system: String,
    /// Who closes the loop.
    pub client: Client,
    /// What the client's settings are called, and what they are but for words of the experiment.
    #[serde(default = "paper_python")]
    pub preset: Preset,
    /// Which repeat it is, from 1.
    pub repeat: u32,
    /// Seed of the link's realisation; equal for all clients, rates and modes of a repeat.
    pub link_seed: u64,
    /// How long the controller sends, in ns.
    pub duration_ns: u64,
    /// The controller's settings; the plant takes h and `late` from here too.
    pub settings: ControllerSettings,
    /// The plant's output at the loop's start; 0 at rest.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub y0: f64,
    /// How the reference moves; it rests at the settings' r, if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Shape>,
    /// How long the plant holds a command when no other comes, and what comes then.
    #[serde(default, skip_serializing_if = "Hold::is_last")]
    pub hold: Hold,
    /// How old a command may be when it reaches the plant; absent, any age.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_age_ns: Option<u64>,
    /// Who may command the plant at a time.
    #[serde(default, skip_serializing_if = "Lease::is_none")]
    pub lease: Lease,
    /// How late the plant ticks by its own machine, drawn by the link's seed; absent, it is as punctual as it
    /// can be.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tick_noise: Option<NoiseLaw>,
    /// What the threads of the plant and of the native controller ask the kernel for.
    #[serde(default, skip_serializing_if = "Policy::is_fifo")]
    pub scheduling: Policy,
    /// The fault that the run meets, by its name in the plan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<String>,
    /// How the page goes about it, where the client is a browser.
    #[serde(default)]
    pub page: Option<PageSettings>,
    /// How many cells may run together with this one, itself among them; 1 is alone. What it measures
    /// does not depend on it, or the experiment would not say so: its id does not tell. In a manifest, how
    /// many did.
    #[serde(default = "alone", skip_serializing_if = "is_alone")]
    pub together: u16,
}

fn alone() -> u16 {
    1
}

// Serde passes a reference.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_alone(together: &u16) -> bool {
    *together == 1
}

// Serde passes a reference.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_zero(y0: &f64) -> bool {
    *y0 == 0.0
}

fn paper_system() -> String {
    System::PAPER.to_owned()
}

fn is_paper_system(system: &str) -> bool {
    system == System::PAPER
}

/// The preset of plans that were written before plans named one.
fn paper_python() -> Preset {
    Preset::PaperPython
}

/// Hex digits of an id's fingerprint.
const FINGERPRINT: usize = 6;

impl Cell {
    /// A cell of these settings with the paper's system, still without its place in a plan, its link, its duration and
    /// its id. The plant's h and `late` are those of `settings`.
    #[must_use]
    pub fn new(
        client: Client,
        preset: Preset,
        settings: ControllerSettings,
        plant: &PlantSettings,
    ) -> Cell {
        // By their names, so that none is forgotten; a run has the others from elsewhere.
        let PlantSettings {
            h: _,
            late: _,
            hold,
            max_age_ns,
            clock: _,
            lease,
            check: _,
            udp: _,
            tick_noise,
            scheduling,
        } = *plant;
        Cell {
            index: 0,
            id: String::new(),
            topology: String::new(),
            system: paper_system(),
            client,
            preset,
            repeat: 0,
            link_seed: 0,
            duration_ns: 0,
            settings,
            y0: 0.0,
            reference: None,
            hold,
            max_age_ns,
            lease,
            tick_noise: tick_noise.map(|noise| noise.law),
            scheduling,
            fault: None,
            page: None,
            together: alone(),
        }
    }

    /// The changes of its reference; `None` if that rests, or a file says what no plan does.
    #[must_use]
    pub fn moving_reference(&self) -> Option<Reference> {
        let shape = self.reference.as_ref()?;
        shape.over(self.settings.h, self.duration_ns).ok()
    }

    /// Sets the id from the other fields: words for people, then six hex digits of a fingerprint, for
    /// what the words leave out (outstanding, schedule, seed, duration ...). Index and `together` do
    /// not change it.
    pub(crate) fn identify(&mut self) {
        self.id = String::new();
        let index = std::mem::take(&mut self.index);
        let together = std::mem::replace(&mut self.together, alone());
        // Plain data of strings and numbers: serialising it cannot fail.
        let text = serde_json::to_string(self).unwrap_or_default();
        (self.index, self.together) = (index, together);
        self.id = format!("{}-{}", self.words(), fingerprint(&text, FINGERPRINT));
    }

    /// Whether the id has the form that [`identify`](Cell::identify) gives it: it begins with the topology, and ends with
    /// mode, rate, repeat and a fingerprint. What is between, and the fingerprint, may be of another version's words.
    pub(crate) fn is_identified(&self) -> bool {
        let end = format!(
            "-{}-{}-r{:02}-",
            self.settings.mode,
            rate_label(self.settings.h),
            self.repeat
        );
        let is_digit = |byte: u8| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte);
        let Some((words, print)) = self
            .id
            .len()
            .checked_sub(FINGERPRINT)
            .and_then(|at| self.id.split_at_checked(at))
        else {
            return false;
        };
        let words = words.strip_prefix(&self.topology);
        words.is_some_and(|rest| rest.starts_with('-') && rest.ends_with(&end))
            && print.bytes().all(is_digit)
    }

    /// The part of the id that is for people: `couva-native-closed-333hz-r01`.
    fn words(&self) -> String {
        format!(
            "{}{}{}-{}-{}-{}-r{:02}",
            self.topology,
            self.system_label(),
            self.fault_label(),
            self.client_label(),
            self.settings.mode,
            rate_label(self.settings.h),
            self.repeat
        )
    }

    /// The system's part of the id; empty for the paper's system.
    fn system_label(&self) -> String {
        if is_paper_system(&self.system) {
            String::new()
        } else {
            format!("-{}", self.system)
        }
    }

    /// The fault's part of the id; empty without one.
    fn fault_label(&self) -> String {
        let label = |name: &String| format!("-{name}");
        self.fault.as_ref().map_or_else(String::new, label)
    }

    /// The client's part of the id, with the preset unless it is the client's default. A browser always
    /// has it, since the preset defines its page.
    fn client_label(&self) -> String {
        if !self.client.is_browser() && self.preset == self.client.spec().preset {
            self.client.to_string()
        } else {
            format!("{}-{}", self.client, self.preset)
        }
    }

    /// The cell's rate as people write it, such as `333 Hz`.
    #[must_use]
    pub fn rate(&self) -> String {
        rate(self.settings.h)
    }

    /// Whether `other` describes the same run, in any plan: every field is equal except the index and
    /// `together`.
    #[must_use]
    pub fn is_same(&self, other: &Cell) -> bool {
        let alike = Cell {
            index: self.index,
            together: self.together,
            ..other.clone()
        };
        alike == *self
    }

    /// The plant's settings. The link's seed also draws the extra time of its ticks.
    #[must_use]
    pub fn plant_settings(&self) -> PlantSettings {
        let seed = self.link_seed;
        PlantSettings {
            h: self.settings.h,
            late: self.settings.late,
            hold: self.hold,
            max_age_ns: self.max_age_ns,
            // A run is on one machine. Where no age is asked for, its settings stay what they were.
            clock: match self.max_age_ns {
                Some(_) => Clock::Shared,
                None => Clock::Own,
            },
            lease: self.lease,
            check: false,
            udp: self.settings.transport == Transport::Udp,
            tick_noise: self.tick_noise.map(|law| TickNoise { law, seed }),
            scheduling: self.scheduling,
        }
    }

    /// The cell's folder, relative to its campaign's folder.
    #[must_use]
    pub fn folder(&self) -> PathBuf {
        Path::new(file_name::CELLS).join(&self.id)
    }

    /// The link time by which all of it is over, an answer that was waited for and the echoes after it too, with ten
    /// minutes to spare: a stamp after that is none of this run.
    #[must_use]
    pub fn closes_at(&self) -> LinkTime {
        const SPARE_NS: u64 = 600_000_000_000;
        let lasts_ns = self.duration_ns.saturating_add(self.settings.timeout_ns);
        START_AT.after(lasts_ns).after(SPARE_NS)
    }

    /// Number of messages due in this cell: one every h, the first at once.
    #[must_use]
    pub fn due(&self) -> u64 {
        self.duration_ns.div_ceil(self.settings.h.ns())
    }
}

fn rate_label(h: SampleTime) -> String {
    rated(h, "", "hz", "khz")
}

/// 1/h as people write it, such as `333 Hz`.
#[must_use]
pub fn rate(h: SampleTime) -> String {
    rated(h, " ", "Hz", "kHz")
}

/// 1/h as the paper writes it (`3.3`, `333`, `1 k`): truncated, not rounded.
fn rated(h: SampleTime, gap: &str, hz: &str, khz: &str) -> String {
    let tenths_hz = 10_000_000_000 / h.ns();
    if tenths_hz >= 10_000 && tenths_hz.is_multiple_of(10_000) {
        return format!("{}{gap}{khz}", tenths_hz / 10_000);
    }
    let (whole, tenth) = (tenths_hz / 10, tenths_hz % 10);
    if whole >= 10 || tenth == 0 {
        format!("{whole}{gap}{hz}")
    } else {
        format!("{whole}.{tenth}{gap}{hz}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_read_as_the_paper_writes_them() {
        for (h, words) in [
            ("300ms", "3.3 Hz"),
            ("100ms", "10 Hz"),
            ("10ms", "100 Hz"),
            ("3ms", "333 Hz"),
            ("1ms", "1 kHz"),
            ("100us", "10 kHz"),
            ("2s", "0.5 Hz"),
        ] {
            let h: SampleTime = h.parse().expect("a sample time");
            assert_eq!(rate(h), words);
        }
    }
}
