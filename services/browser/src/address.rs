//! The page's address: everything that it is told, as a query.
//!
//! All values are numbers or words of settings, so none needs escaping.

use std::{fmt::Write, net::SocketAddr};

use endpoint::{ControllerSettings, PageSettings};

/// What the page is told beside its settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Times {
    /// The first deadline; soon after loading, if not given.
    pub(crate) start_ns: Option<u64>,
    /// Deadlines end this long after the first.
    pub(crate) duration_ns: u64,
    /// What makes a page's time of day the run's: see [`crate::clock`].
    pub(crate) clock_ns: u64,
}

/// The address at which the page runs the loop by itself.
pub(crate) fn url(
    plant: SocketAddr,
    settings: &ControllerSettings,
    page: PageSettings,
    times: Times,
) -> String {
    let ControllerSettings {
        mode,
        h,
        r,
        outstanding,
        transport,
        // A browser keeps its connections, and asks nobody.
        connection: _,
        schedule,
        integrate,
        late,
        timeout_ns,
    } = settings;
    let PageSettings {
        thread,
        sender,
        timer,
        floor_ns,
    } = page;
    let Times {
        start_ns,
        duration_ns,
        clock_ns,
    } = times;
    let mut url = format!(
        "http://{plant}/?run=1&mode={mode}&h_ns={}&r={r}&duration_ns={duration_ns}\
         &schedule={schedule}&integrate={integrate}&late={late}&timeout_ns={timeout_ns}\
         &outstanding={outstanding}&transport={transport}&thread={thread}&sender={sender}\
         &timer={timer}&floor_ns={floor_ns}",
        h.ns(),
    );
    if let Some(start_ns) = start_ns {
        // Writing to a String cannot fail.
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
            "http://10.77.0.2:8080/?run=1&mode=closed&h_ns=3000000&r=1&duration_ns=6000000000\
             &schedule=absolute&integrate=h&late=apply&timeout_ns=5000000000&outstanding=1\
             &transport=http&thread=worker&sender=xhr&timer=wait&floor_ns=0\
             &start_ns=123456789&clock_ns=987654321"
        );
        assert!(!address(None).contains("start_ns"));
    }
}
