//! Settings by name, for code that reads, forwards or shows them without its own list: experiments,
//! command lines, a cell's setup in words.
//!
//! Mode, sample time and reference are not among them, since they belong to a run. The settings are
//! declared with their types.

use std::fmt::{self, Display};
use std::ops::RangeInclusive;
use std::str::FromStr;

use text::duration_ns;

/// A setting of `S` by its name.
#[derive(Debug)]
pub struct Field<S> {
    /// Its name in TOML, like `timer_floor`; a command line has `-` instead of `_`.
    pub name: &'static str,
    /// What it decides, and its possible words, in one line.
    pub about: &'static str,
    /// The placeholder for its value in a help text; empty for a switch, which is set without a value.
    pub placeholder: &'static str,
    /// Whether its words are clear without the setting's name: `websocket` is, `new` is not.
    pub is_telling: bool,
    pub(crate) read: fn(&mut S, &str) -> Result<(), InvalidSetting>,
    pub(crate) text: fn(&S) -> String,
}

/// Why a setting is invalid, and what to do about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InvalidSetting {
    /// The setting's name.
    pub name: &'static str,
    /// What is wrong.
    pub problem: String,
    /// What to do; empty if the problem says it.
    pub remedy: &'static str,
}

impl InvalidSetting {
    /// Reads a word; the word's own error lists the choices.
    pub(crate) fn word<T: FromStr<Err: Display>>(
        name: &'static str,
        text: &str,
    ) -> Result<T, Self> {
        text.parse().map_err(|error: T::Err| Self {
            name,
            problem: error.to_string(),
            remedy: "",
        })
    }

    /// Reads a time in a range.
    pub(crate) fn time(
        name: &'static str,
        text: &str,
        range: RangeInclusive<u64>,
    ) -> Result<u64, Self> {
        duration_ns(text, range).map_err(|invalid| Self {
            name,
            problem: invalid.to_string(),
            remedy: invalid.remedy,
        })
    }
}

impl Display for InvalidSetting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.remedy {
            "" => f.write_str(&self.problem),
            remedy => write!(f, "{}; {remedy}", self.problem),
        }
    }
}

impl std::error::Error for InvalidSetting {}

impl<S> Field<S> {
    /// Sets the field to the value of `text`.
    ///
    /// # Errors
    /// [`InvalidSetting`] if that is not a valid value.
    pub fn read(&self, settings: &mut S, text: &str) -> Result<(), InvalidSetting> {
        (self.read)(settings, text)
    }

    /// Its value, as people write it.
    #[must_use]
    pub fn text(&self, settings: &S) -> String {
        (self.text)(settings)
    }
}

/// A setting that is one of several words.
macro_rules! word_field {
    ($field:ident, $about:literal, $placeholder:literal, $is_telling:literal) => {
        $crate::field::Field {
            name: stringify!($field),
            about: $about,
            placeholder: $placeholder,
            is_telling: $is_telling,
            read: |settings, text| {
                settings.$field = $crate::field::InvalidSetting::word(stringify!($field), text)?;
                Ok(())
            },
            text: |settings| settings.$field.to_string(),
        }
    };
}

/// A setting that is a time of `$least_ns` or more.
macro_rules! span_field {
    ($name:literal, $field:ident, $about:literal, $least_ns:literal) => {
        $crate::field::Field {
            name: $name,
            about: $about,
            placeholder: "TIME",
            is_telling: false,
            read: |settings, text| {
                settings.$field =
                    $crate::field::InvalidSetting::time($name, text, $least_ns..=text::WEEK_NS)?;
                Ok(())
            },
            text: |settings| text::duration_text(settings.$field),
        }
    };
}

pub(crate) use {span_field, word_field};

#[cfg(test)]
mod tests {
    use crate::page::PageSettings;
    use crate::preset::Preset;
    use crate::setting::{ControllerSettings, Mode};

    #[test]
    fn every_field_reads_what_it_writes() {
        let h = "3ms".parse().expect("a sample time");
        for preset in Preset::ALL {
            let (settings, page) = (preset.settings(Mode::Closed, h), preset.page());
            let (mut read, mut page_read) = (settings, page);
            for field in ControllerSettings::FIELDS {
                assert_eq!(field.read(&mut read, &field.text(&settings)), Ok(()));
                let error = field.read(&mut read, "nonsense").expect_err(field.name);
                assert!(error.to_string().contains("`nonsense`"), "{error}");
            }
            for field in PageSettings::FIELDS {
                assert_eq!(field.read(&mut page_read, &field.text(&page)), Ok(()));
            }
            assert_eq!((read, page_read), (settings, page));
        }
    }

    #[test]
    fn every_setting_is_a_field_but_those_that_are_a_run_s_own() {
        let h = "3ms".parse().expect("a sample time");
        let settings = serde_json::to_value(Preset::Worker.settings(Mode::Closed, h));
        let count = |value: serde_json::Value| value.as_object().map_or(0, serde_json::Map::len);
        let all = count(settings.expect("plain fields"));
        // mode, h and r
        assert_eq!(ControllerSettings::FIELDS.len(), all - 3);
        // A page without chores does not say so.
        let page = serde_json::to_value(PageSettings {
            chores_ns: 1,
            ..Preset::Worker.page()
        });
        assert_eq!(
            PageSettings::FIELDS.len(),
            count(page.expect("plain fields"))
        );
    }
}
