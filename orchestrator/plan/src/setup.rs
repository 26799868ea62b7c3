//! A cell's setup in words: its preset, and every setting that the experiment changed.
//!
//! Examples: `paper-python`, `paper-python, websocket`, `worker, fetch, channel, outstanding 6`,
//! `paper-python, system pendulum`, `worker, safe plant`. Rate and mode are left out, since they have columns of their own.

use endpoint::{ControllerSettings, Field, Hold, Late, Lease, PageSettings, PlantSettings, Preset};
use system::System;

use crate::Cell;

impl Cell {
    /// Whether the client has its usual settings, whatever the system.
    #[must_use]
    pub fn is_plain(&self) -> bool {
        let mut with_the_papers = Cell {
            system: System::PAPER.to_owned(),
            ..self.clone()
        };
        if self.has_safe_plant() {
            with_the_papers.settings.late = Late::Apply;
            with_the_papers.hold = Hold::Last;
            with_the_papers.lease = Lease::None;
        }
        let usual = self.client.spec().preset;
        with_the_papers.setup() == with_the_papers.preset_word(usual)
    }

    /// Whether its plant is what it is by default for other clients than the paper's.
    fn has_safe_plant(&self) -> bool {
        let plant = PlantSettings {
            tick_noise: None,
            ..self.plant_settings()
        };
        plant == PlantSettings::safe(plant.h)
    }

    /// What a preset is called in words; a program of one's own has its own settings.
    fn preset_word(&self, preset: Preset) -> String {
        if self.client.is_own() && preset == self.client.spec().preset {
            "own".to_owned()
        } else {
            preset.to_string()
        }
    }

    /// The cell's setup in words. Equal words mean equal settings, except for rate and mode.
    ///
    /// A value that identifies its setting stands alone; other values follow the name of their setting.
    #[must_use]
    pub fn setup(&self) -> String {
        self.setup_at(Some(&self.system))
    }

    /// The same without the system, for what names that elsewhere.
    #[must_use]
    pub fn setup_beside_system(&self) -> String {
        self.setup_at(None)
    }

    fn setup_at(&self, system: Option<&str>) -> String {
        let own = &self.settings;
        let mut usual = self.preset.settings(own.mode, own.h);
        let is_safe = self.has_safe_plant();
        if is_safe {
            usual.late = own.late;
        }
        let system = system.filter(|name| *name != System::PAPER);
        let mut words = vec![self.preset_word(self.preset)];
        words.extend(system.map(|name| format!("system {name}")));
        words.extend(is_safe.then(|| "safe plant".to_owned()));
        let is_told = !is_safe && !self.hold.is_last();
        words.extend(is_told.then(|| format!("hold {}", self.hold)));
        let max_age = self.max_age_ns.map(endpoint::duration_text);
        words.extend(max_age.map(|age| format!("max age {age}")));
        let is_told = !is_safe && !self.lease.is_none();
        words.extend(is_told.then(|| format!("lease {}", self.lease)));
        words.extend(self.fault.as_ref().map(|name| format!("fault {name}")));
        words.extend(self.tick_noise.map(|law| format!("tick noise {law}")));
        // In this order: the transport, the page's settings, the other settings.
        let usual_page = self.preset.page();
        let of_page = self
            .page
            .iter()
            .flat_map(|page| differing(PageSettings::FIELDS, page, &usual_page));
        let (transport, others) = ControllerSettings::FIELDS.split_at(1);
        let settings = differing(transport, own, &usual)
            .chain(of_page)
            .chain(differing(others, own, &usual));
        words.extend(settings);
        // Another system brings its own reference. A plan written by hand can have any r; comparing
        // bits makes NaN equal to itself.
        let is_usual = self.system != System::PAPER || own.r.to_bits() == usual.r.to_bits();
        words.extend((!is_usual).then(|| format!("r {}", own.r)));
        words.join(", ")
    }
}

/// The settings that differ from the usual ones, in words.
fn differing<'a, S>(
    fields: &'a [Field<S>],
    own: &'a S,
    usual: &'a S,
) -> impl Iterator<Item = String> + 'a {
    let is_name = |word: &str| {
        ControllerSettings::FIELDS
            .iter()
            .any(|field| field.name == word)
    };
    fields.iter().filter_map(move |field| {
        let text = field.text(own);
        if text == field.text(usual) {
            None
        // `timeout` is a value of `timer`, but also the name of a setting.
        } else if field.is_telling && !is_name(&text) {
            Some(text)
        } else {
            Some(format!("{} {text}", field.name.replace('_', " ")))
        }
    })
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
}
