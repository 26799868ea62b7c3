//! How a plant is set up, declared once: the lists of an experiment, what a cell is called by, what virtual time and a
//! plant over HTTP are told, and the options of `webloop serve plant` are made from [`PlantSettings::FIELDS`].
//!
//! [`crate::plant`] has the effects. How a plan is written has its own place for each, in `plan`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use text::{WEEK_NS, duration_text};

use crate::field::{Field, InvalidSetting, word_field};
use crate::hold::Hold;
use crate::noise::TickNoise;
use crate::sample_time::SampleTime;
use crate::setting::{Clock, Late, Lease, Policy};

/// A setting of the plant by its name.
#[derive(Debug)]
pub struct PlantField {
    /// The setting as an option of `webloop serve plant`; what it decides is said to whoever runs a plant by hand.
    pub option: Field<PlantSettings>,
    /// What it decides, said to whoever writes an experiment; `None` where a cell has it from something else.
    pub list: Option<&'static str>,
    /// What of the plant it concerns.
    pub concern: Concern,
}

/// What of a plant a setting concerns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Concern {
    /// How it takes commands, and what it does without: what makes it safe.
    Commands,
    /// When its machine lets it tick.
    Machine,
    /// By what ways it is reached, beside HTTP.
    Reach,
}

/// Everything that the plant's end is set up with.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlantSettings {
    /// Sample time.
    pub h: SampleTime,
    /// What becomes of a command that a newer one has overtaken.
    pub late: Late,
    /// How long a command is held when no other comes, and what comes then.
    #[serde(default, skip_serializing_if = "Hold::is_last")]
    pub hold: Hold,
    /// How old a command may be when it arrives; `None` is any age.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_age_ns: Option<u64>,
    /// Whose clock its age is told by.
    #[serde(default, skip_serializing_if = "Clock::is_own")]
    pub clock: Clock,
    /// Who may command at a time.
    #[serde(default, skip_serializing_if = "Lease::is_none")]
    pub lease: Lease,
    /// Whether every command needs a checksum.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub check: bool,
    /// Whether it takes commands by UDP too, at the same port.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub udp: bool,
    /// How late it ticks by its own machine; `None` is as punctual as it can be.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tick_noise: Option<TickNoise>,
    /// What its threads ask the kernel for.
    #[serde(default, skip_serializing_if = "Policy::is_fifo")]
    pub scheduling: Policy,
}

impl PlantSettings {
    /// Settings of a plant that does what the paper's did.
    #[must_use]
    pub fn new(h: SampleTime) -> Self {
        Self {
            h,
            late: Late::Apply,
            hold: Hold::Last,
            max_age_ns: None,
            clock: Clock::Own,
            lease: Lease::None,
            check: false,
            udp: false,
            tick_noise: None,
            scheduling: Policy::Fifo,
        }
    }

    /// Settings of a plant that is safe against a controller that goes wrong, as far as it can be without
    /// the controller's help.
    #[must_use]
    pub fn safe(h: SampleTime) -> Self {
        Self {
            late: Late::Drop,
            hold: Hold::safe(h),
            lease: Lease::Address,
            ..Self::new(h)
        }
    }

    /// The same, with the extra times of its ticks drawn by `seed`.
    #[must_use]
    pub fn drawn_by(self, seed: u64) -> Self {
        let drawn = |noise| TickNoise { seed, ..noise };
        Self {
            tick_noise: self.tick_noise.map(drawn),
            ..self
        }
    }

    /// Whether it takes commands as a [safe](Self::safe) one does, whatever its machine.
    #[must_use]
    pub fn is_safe(&self) -> bool {
        let safe = Self::safe(self.h);
        let mut of_commands = Self::FIELDS
            .iter()
            .filter(|field| field.concern == Concern::Commands);
        of_commands.all(|field| field.option.text(self) == field.option.text(&safe))
    }

    /// The settings that an experiment may choose, each with what is said of its list.
    pub fn lists() -> impl Iterator<Item = (&'static PlantField, &'static str)> {
        let list = |field: &'static PlantField| Some((field, field.list?));
        Self::FIELDS.iter().filter_map(list)
    }
}

#[rustfmt::skip]
impl PlantSettings {
    /// Its settings, but for the sample time, which belongs to a run. A text is empty where there is none.
    pub const FIELDS: &[PlantField] = &[
        PlantField {
            option: word_field!(late, "Commands that are repeated or older than the newest: apply or drop", "LATE", false),
            // The controller's, for both ends.
            list: None,
            concern: Concern::Commands,
        },
        PlantField {
            option: word_field!(hold, "How long the plant keeps the last command: last (no limit), or a time, then 0, or \"100ms then hold\", \"100ms then 0.5\", \"100ms then ramp 1s\" (default: 10 h, and 1s at the least)", "TIME", false),
            list: Some("How long the plant keeps the last command: last (no limit), or a time and what follows: 100ms (then 0), 100ms then hold, 100ms then 0.5, 100ms then ramp 1s"),
            concern: Concern::Commands,
        },
        PlantField {
            option: Field {
                name: "max_age",
                about: "How old a command may be when it arrives, by its stamp (default: any age)",
                placeholder: "TIME",
                is_telling: false,
                read: |plant, text| {
                    plant.max_age_ns = Some(InvalidSetting::time("max_age", text, 1..=WEEK_NS)?);
                    Ok(())
                },
                text: |plant| plant.max_age_ns.map_or_else(String::new, duration_text),
            },
            list: Some("How old a command may be when it reaches the plant, such as 50ms; any age, if not given"),
            concern: Concern::Commands,
        },
        PlantField {
            option: word_field!(clock, "Whose clock stamps commands: own (each controller's) or shared (this machine's, as always over loopback)", "CLOCK", false),
            // A run is on one machine.
            list: None,
            concern: Concern::Commands,
        },
        PlantField {
            option: word_field!(lease, "Who may command at a time: none (whoever sends), address (one IP address) or token (one session)", "LEASE", false),
            list: Some("Who may command the plant at a time: none (whoever sends), address (one IP address) or token (one session)"),
            concern: Concern::Commands,
        },
        PlantField {
            option: word_field!(check, "Take only commands that end with their checksum", "", false),
            // The clients of a run send none.
            list: None,
            concern: Concern::Commands,
        },
        PlantField {
            option: word_field!(udp, "Take commands by UDP too, at the same port: a datagram each", "", false),
            // It follows from the transport.
            list: None,
            concern: Concern::Reach,
        },
        PlantField {
            option: Field {
                name: "tick_noise",
                about: "Law of each tick's extra delay, like \"uniform 3ms\" or \"normal 1ms\"",
                placeholder: "LAW",
                is_telling: false,
                read: |plant, text| {
                    let law = InvalidSetting::word("tick_noise", text)?;
                    plant.tick_noise = Some(TickNoise { law, seed: 0 });
                    Ok(())
                },
                text: |plant| plant.tick_noise.map_or_else(String::new, |noise| noise.law.to_string()),
            },
            list: Some("How late the plant ticks by its own machine: uniform 3ms, normal 1ms; punctual, if not given"),
            concern: Concern::Machine,
        },
        PlantField {
            option: word_field!(scheduling, "What its threads ask the kernel for: fifo (real time) or other (as a desktop's programs)", "POLICY", false),
            list: Some("What the threads of webloop's plant and native controller ask the kernel for: fifo (real time) or other (as a desktop's programs)"),
            concern: Concern::Machine,
        },
    ];
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_setting_but_the_sample_time_is_a_field_that_reads_what_it_writes() {
        let h = "3ms".parse().expect("a sample time");
        let mut settings = PlantSettings::safe(h);
        for (name, text) in [
            ("max_age", "50ms"),
            ("clock", "shared"),
            ("check", "true"),
            ("udp", "true"),
            ("tick_noise", "uniform 3ms"),
            ("scheduling", "other"),
        ] {
            let field = PlantSettings::FIELDS
                .iter()
                .find(|field| field.option.name == name)
                .expect(name);
            assert_eq!(field.option.read(&mut settings, text), Ok(()));
        }
        let mut read = PlantSettings::new(h);
        for PlantField { option, .. } in PlantSettings::FIELDS {
            assert_eq!(option.read(&mut read, &option.text(&settings)), Ok(()));
            let error = option.read(&mut read, "nonsense").expect_err(option.name);
            assert!(!error.to_string().is_empty());
        }
        assert_eq!(read, settings);
        let written = serde_json::to_value(settings).expect("plain fields");
        let all = written.as_object().map_or(0, serde_json::Map::len);
        assert_eq!(PlantSettings::FIELDS.len(), all - 1);
        assert_eq!(
            settings.drawn_by(7).tick_noise.map(|noise| noise.seed),
            Some(7)
        );
    }

    #[test]
    fn a_plant_is_safe_by_how_it_takes_commands_and_not_by_its_machine() {
        let h = "3ms".parse().expect("a sample time");
        let mut settings = PlantSettings::safe(h);
        for (
            PlantField {
                option, concern, ..
            },
            text,
        ) in PlantSettings::FIELDS.iter().zip([
            "apply",
            "2s",
            "1s",
            "shared",
            "none",
            "true",
            "true",
            "normal 1ms",
            "other",
        ]) {
            let mut other = settings;
            assert_eq!(option.read(&mut other, text), Ok(()));
            assert_eq!(
                other.is_safe(),
                *concern != Concern::Commands,
                "{}",
                option.name
            );
            assert!(settings.is_safe());
        }
        settings = PlantSettings::new(h);
        assert!(!settings.is_safe());
    }
}
