//! One direction of a link as a shell script of tc commands, to read or to replay by hand.
//!
//! webloop itself keeps one `tc` running and sends it the same commands without starting a process for each.

use std::fmt::Write as _;

use text::counted;

use crate::profile::Profile;
use crate::setting::{Setting, Verb};
use crate::staircase::Staircase;
use crate::time::LinkTime;
use crate::way::Way;

/// What waits until a time after START, and then calls tc. Any POSIX shell and awk has it, in any locale;
/// `printf` since a bare `>` behind `print` is a redirection, and since some `sleep` reads no exponent.
const AT: &str = r#"now() { date +%s.%N; }
case $(now) in *N) now() { cut -d ' ' -f 1 /proc/uptime; } ;; esac # a date without fractions
at() {
    due=$1
    shift
    sleep "$(LC_ALL=C awk -v due="$due" -v start="$START" -v now="$(now)" '
        BEGIN { left = start + due - now; printf "%.6f", (left > 0 ? left : 0) }')"
    tc "$@"
}"#;

/// The first `span_ns` of one direction of the link of `profile` and `seed`: the set-up with the
/// empty link, each change with its time, and the removal.
#[must_use]
pub fn script(profile: &Profile, seed: u64, way: Way, span_ns: u64) -> String {
    let device = "$DEV";
    let ends = match way {
        Way::Up => "up, from controller to plant",
        Way::Down => "down, from plant to controller",
    };
    let mut text = format!("# {}, {ends}; seed {seed}.\n", profile.name());
    if profile.is_loopback() {
        text.push_str("# Both ends are on one machine: there is nothing to shape.\n");
        return text;
    }
    if let Some(fault) = profile.beyond_tc() {
        let _ = writeln!(
            text,
            "# tc cannot play the link's fault `{fault}`; webloop itself can."
        );
        return text;
    }
    let mut staircase = Staircase::new(profile, seed, way);
    let changes: Vec<_> =
        std::iter::from_fn(|| staircase.next_before(LinkTime::from_ns(span_ns))).collect();
    let _ = writeln!(
        text,
        "# {} in the first {} s. webloop feeds them to one `tc -batch -`, each at its time;\n\
         # by hand each costs the start of a tc, some milliseconds.\n\
         DEV=eth0 # the interface that leads to the other end\n\
         {AT}",
        counted(changes.len(), "change", "changes"),
        span_ns as f64 / 1e9
    );
    // The empty link is constant, so its first change is the only one.
    if let Some(empty) =
        Staircase::new(&Profile::empty(), 0, way).next_before(LinkTime::ZERO.after(1))
    {
        let command = empty.setting.command(Verb::Add, device);
        let _ = writeln!(text, "tc {command} # before link time 0");
    }
    text.push_str("START=$(now)\n");
    for change in changes {
        let s = change.at.ns() as f64 / 1e9;
        let command = change.setting.command(Verb::Change, device);
        let _ = writeln!(text, "at {s:.6} {command}");
    }
    let s = span_ns as f64 / 1e9;
    let _ = writeln!(text, "at {s:.6} {}", Setting::removal(device));
    text
}
