//! The page's address, with the page's settings as its query.
//!
//! All values are numbers or words of settings, so none needs escaping.

use std::{fmt::Write, net::SocketAddr};

use endpoint::{ControllerSettings, PageSettings};

/// What the page's address contains besides the settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Times {
    /// The first deadline; soon after loading, if not given.
    pub(crate) start_ns: Option<u64>,
    /// Time from the first deadline to the end of the deadlines.
    pub(crate) duration_ns: u64,
    /// Converts a page's time of day to the run's clock: see [`crate::clock`].
    pub(crate) clock_ns: u64,
}

/// The address at which the page runs the loop without further input.
pub(crate) fn url(
    plant: SocketAddr,
    settings: &ControllerSettings,
    page: PageSettings,
    times: Times,
) -> String {
    let Times {
        start_ns,
        duration_ns,
        clock_ns,
    } = times;
    let mut url = format!(
        "http://{plant}/?run=1&h_ns={}&duration_ns={duration_ns}",
        settings.h.ns()
    );
    let told = [serde_json::to_value(settings), serde_json::to_value(page)];
    // Numbers and words under fixed names: converting them to values cannot fail.
    for value in told.into_iter().flatten() {
        for (name, value) in value.as_object().into_iter().flatten() {
            // JavaScript gets times as whole nanoseconds.
            if name != "h" {
                let value = value
                    .as_str()
                    .map_or_else(|| value.to_string(), str::to_owned);
                // Writing to a String cannot fail.
                let _ = write!(url, "&{name}={value}");
            }
        }
    }
    if let Some(start_ns) = start_ns {
        let _ = write!(url, "&start_ns={start_ns}");
    }
    let _ = write!(url, "&clock_ns={clock_ns}");
    url
}

#[cfg(test)]
mod tests {
    use endpoint::{Mode, Preset};

    use super::*;

    #[test]
    fn a_page_is_told_everything_by_its_address() {
        let h = "3ms".parse().expect("a sample time");
        let preset = Preset::Worker;
        let address = |start_ns| {
            let times = Times {
                start_ns,
                duration_ns: 6_000_000_000,
                clock_ns: 987_654_321,
            };
            let plant = "10.77.0.2:8080".parse().expect("an address");
            url(
                plant,
                &preset.settings(Mode::Closed, h),
                preset.page(),
                times,
            )
        };
        assert_eq!(
            address(Some(123_456_789)),
            "http://10.77.0.2:8080/?run=1&h_ns=3000000&duration_ns=6000000000&connection=keep\
             &integrate=h&late=apply&mode=closed&outstanding=1&r=1.0&schedule=absolute\
             &timeout_ns=5000000000&transport=http&floor_ns=0&sender=xhr&thread=worker&timer=wait\
             &start_ns=123456789&clock_ns=987654321"
        );
        assert!(!address(None).contains("start_ns"));
    }
}
