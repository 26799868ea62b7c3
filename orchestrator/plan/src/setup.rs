//! What a cell's client and plant were set to: its preset, and every setting that the experiment changed.
//!
//! In words: `paper-python`, `paper-python, websocket`, `worker, fetch, channel, outstanding 6`,
//! `paper-python, system pendulum`, `worker, safe plant`. Rate and mode are left out, since they have columns of their own.

use std::fmt;
use std::time::Duration;

use crate::system::System;
use endpoint::{Concern, ControllerSettings, Field, Mode, PageSettings, PlantSettings};
use serde::{Deserialize, Serialize};
use text::column::{EntryType, Typed};

use crate::cell::Cell;
use crate::client::Client;

/// What run a cell is, whatever its link and its repeat: what runs are grouped, compared and selected by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Condition<'a> {
    /// Who closes the loop.
    pub client: Client,
    /// What it and the plant were set to.
    pub setup: &'a Setup,
    /// `open` or `closed`.
    pub mode: Mode,
    /// The sample time.
    pub h: Duration,
}

/// What a client and its plant were set to. Equal setups mean equal settings, except for rate and mode.
#[derive(Debug, Clone, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(from = "String", into = "String")]
pub struct Setup {
    /// Where each setting comes from, and its words.
    settings: Vec<(SetBy, String)>,
}

/// Where a setting comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SetBy {
    /// The name of all that the experiment did not change.
    Preset,
    /// The plant with its law, if it is not the paper's.
    System,
    /// How the plant takes commands, and when it ticks.
    Plant,
    /// A fault of the link or of an end.
    Fault,
    /// The controller's and the page's settings.
    Client,
}

/// What a plant is called that takes commands as [`PlantSettings::safe`] does.
const SAFE_PLANT: &str = "safe plant";

impl SetBy {
    /// Where a setting of these words comes from; `None` for a preset and for a client's settings.
    fn of(words: &str) -> Option<SetBy> {
        let is_called = |name: &str| {
            let rest = words.strip_prefix(name);
            rest.is_some_and(|rest| rest.starts_with(' '))
        };
        let mut of_plant = PlantSettings::lists().map(|(field, _)| in_words(field.option.name));
        if is_called("system") {
            Some(SetBy::System)
        } else if is_called("fault") {
            Some(SetBy::Fault)
        } else {
            let is_plant = words.starts_with(SAFE_PLANT) || of_plant.any(|name| is_called(&name));
            is_plant.then_some(SetBy::Plant)
        }
    }
}

impl Setup {
    /// Nothing is set.
    pub const EMPTY: Setup = Setup {
        settings: Vec::new(),
    };

    /// The setup without what comes from these: that stands elsewhere.
    #[must_use]
    pub fn beside(&self, others: &[SetBy]) -> Setup {
        self.filtered(|(of, _)| !others.contains(of))
    }

    /// The setup without what all of `others` have too.
    #[must_use]
    pub fn apart_from(&self, others: &[&Setup]) -> Setup {
        self.filtered(|setting| !others.iter().all(|of| of.settings.contains(setting)))
    }

    /// What comes from one of these.
    #[must_use]
    pub fn only(&self, of: &[SetBy]) -> Setup {
        self.filtered(|(by, _)| of.contains(by))
    }

    fn filtered(&self, is_in: impl Fn(&(SetBy, String)) -> bool) -> Setup {
        let settings = self.settings.iter().filter(|setting| is_in(setting));
        Setup {
            settings: settings.cloned().collect(),
        }
    }

    /// Whether nothing is set.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.settings.is_empty()
    }

    /// Whether it is a preset, and nothing was changed of it.
    #[must_use]
    pub fn is_preset(&self) -> bool {
        self.settings.iter().all(|(of, _)| *of == SetBy::Preset)
    }

    fn add(&mut self, of: SetBy, words: impl IntoIterator<Item = String>) {
        self.settings
            .extend(words.into_iter().map(|words| (of, words)));
    }
}

impl Typed for Setup {
    const ENTRY: EntryType = EntryType::String;
}

impl fmt::Display for Setup {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (nth, (_, words)) in self.settings.iter().enumerate() {
            f.write_str(if nth == 0 { "" } else { ", " })?;
            f.write_str(words)?;
        }
        Ok(())
    }
}

impl From<Setup> for String {
    fn from(setup: Setup) -> String {
        setup.to_string()
    }
}

/// Reads a setup back from a table.
impl From<String> for Setup {
    fn from(words: String) -> Setup {
        let words = words.split(", ").filter(|words| !words.is_empty());
        let settings = words.enumerate().map(|(nth, words)| {
            let other = if nth == 0 {
                SetBy::Preset
            } else {
                SetBy::Client
            };
            (SetBy::of(words).unwrap_or(other), words.to_owned())
        });
        Setup {
            settings: settings.collect(),
        }
    }
}

impl Cell {
    /// Whether the client has its usual settings, whatever the system.
    #[must_use]
    pub fn is_plain(&self) -> bool {
        let with_the_papers = Cell {
            system: System::PAPER.to_owned(),
            ..self.clone()
        };
        let setup = with_the_papers.setup();
        let mut changed = setup
            .settings
            .iter()
            .filter(|(_, words)| words != SAFE_PLANT);
        self.preset == self.client.spec().preset && changed.all(|(of, _)| *of == SetBy::Preset)
    }

    /// What its preset is called in words; a program of one's own has its own settings.
    fn preset_word(&self) -> String {
        if self.client.is_own() && self.preset == self.client.spec().preset {
            "own".to_owned()
        } else {
            self.preset.to_string()
        }
    }

    /// What its client and plant were set to.
    ///
    /// A value that identifies its setting stands alone; other values follow the name of their setting.
    #[must_use]
    pub fn setup(&self) -> Setup {
        let own = &self.settings;
        let mut usual = self.preset.settings(own.mode, own.h);
        let plant = self.plant_settings();
        let is_safe = plant.is_safe();
        let usual_plant = if is_safe {
            usual.late = own.late;
            PlantSettings::safe(own.h)
        } else {
            PlantSettings::new(own.h)
        };
        let of_plant = |concern| {
            let fields = PlantSettings::lists().filter(move |(field, _)| field.concern == concern);
            differing(fields.map(|(field, _)| &field.option), &plant, &usual_plant)
        };
        let mut setup = Setup::default();
        setup.add(SetBy::Preset, [self.preset_word()]);
        let is_other = self.system != System::PAPER;
        setup.add(
            SetBy::System,
            is_other.then(|| format!("system {}", self.system)),
        );
        setup.add(SetBy::Plant, is_safe.then(|| SAFE_PLANT.to_owned()));
        setup.add(SetBy::Plant, of_plant(Concern::Commands));
        let fault = self.fault.as_ref().map(|name| format!("fault {name}"));
        setup.add(SetBy::Fault, fault);
        setup.add(SetBy::Plant, of_plant(Concern::Machine));
        setup.add(SetBy::Client, self.changed(&usual));
        setup
    }

    /// The settings of the controller and of the page that are not the preset's, in this order: the transport, the
    /// page's, the controller's others, the reference.
    fn changed(&self, usual: &ControllerSettings) -> Vec<String> {
        let own = &self.settings;
        let usual_page = self.preset.page();
        let of_page = self
            .page
            .iter()
            .flat_map(|page| differing(PageSettings::FIELDS.iter(), page, &usual_page));
        let (transport, others) = ControllerSettings::FIELDS.split_at(1);
        // Another system brings its own reference. A plan written by hand can have any r; comparing
        // bits makes NaN equal to itself.
        let is_usual = self.system != System::PAPER || own.r.to_bits() == usual.r.to_bits();
        differing(transport.iter(), own, usual)
            .chain(of_page)
            .chain(differing(others.iter(), own, usual))
            .chain((!is_usual).then(|| format!("r {}", own.r)))
            .collect()
    }
}

/// The settings that differ from the usual ones, in words.
fn differing<'a, S: 'a>(
    fields: impl Iterator<Item = &'a Field<S>> + 'a,
    own: &'a S,
    usual: &'a S,
) -> impl Iterator<Item = String> + 'a {
    let is_name = |word: &str| {
        ControllerSettings::FIELDS
            .iter()
            .any(|field| field.name == word)
    };
    fields.filter_map(move |field| {
        let text = field.text(own);
        if text == field.text(usual) {
            None
        // `timeout` is a value of `timer`, but also the name of a setting.
        } else if field.is_telling && !is_name(&text) {
            Some(text)
        } else {
            Some(format!("{} {text}", in_words(field.name)))
        }
    })
}

/// A setting's name in words.
fn in_words(name: &str) -> String {
    name.replace('_', " ")
}

#[cfg(test)]
mod tests {
    use super::{SetBy, Setup};
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
        plan.expect("an experiment").cells[0].setup().to_string()
    }

    #[test]
    fn a_setup_is_its_preset_and_what_was_laid_over_it() {
        let cases = [
            ("native", "", "paper-python"),
            ("firefox", "", "worker, safe plant"),
            (
                "firefox",
                "late = \"apply\"\nhold = \"last\"\nlease = \"none\"",
                "worker",
            ),
            ("chromium", "preset = \"today\"", "today, safe plant"),
            // Values that the preset has anyway are left out, and so are page settings of a client that
            // is not a browser.
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
                "worker, safe plant, fetch, channel, outstanding 6",
            ),
            (
                "firefox",
                "preset = \"paper-2011\"\nthread = \"worker\"\ntimer_floor = \"4ms\"",
                "paper-2011, thread worker, timer floor 4ms",
            ),
            (
                "firefox",
                "timer = \"timeout\"\nschedule = \"relative\"",
                "worker, safe plant, timer timeout, relative",
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

    #[test]
    fn what_a_setup_is_made_of_is_read_back_from_its_words() {
        let words = "worker, system cart, hold 50ms, max age 1s, lease address, fault outage, tick noise uniform 3ms, \
                     fetch, outstanding 6";
        let setup = Setup::from(words.to_owned());
        assert_eq!(setup.to_string(), words);
        let plant = "hold 50ms, max age 1s, lease address, tick noise uniform 3ms";
        assert_eq!(setup.only(&[SetBy::Plant]).to_string(), plant);
        let own = setup.beside(&[SetBy::System, SetBy::Fault, SetBy::Plant]);
        assert_eq!(own.to_string(), "worker, fetch, outstanding 6");
        let other = Setup::from("worker, system cart, fetch".to_owned());
        let apart = other.apart_from(&[&setup, &other]);
        assert!(apart.is_empty() && !setup.is_preset());
        let apart = setup.apart_from(&[&setup, &other]);
        assert_eq!(
            apart.to_string(),
            format!(
                "{}, outstanding 6",
                setup.only(&[SetBy::Plant, SetBy::Fault])
            )
        );
    }
}
