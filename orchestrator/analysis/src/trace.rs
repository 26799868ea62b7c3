//! The series of one run that figures show, row by row: its step response (Fig. 5 and 6), the plant's
//! intervals (Fig. 7) and the control intervals (Fig. 8 and 9).
//!
//! Summaries of these series are in [`crate::response`], [`crate::tick`] and [`crate::arrival`];
//! arrivals against their schedule are in [`crate::lateness`].

use std::ops::{ControlFlow, Range};
use std::path::Path;

use endpoint::{ArrivalRow, TickRow};
use plan::file_name;
use record::ReadError;
use record::rows::{read, read_while};

use crate::statistics::ms_between;

/// The plant's output and input at each tick, from the first deadline to the planned end. Time is the plant's own: the
/// n-th value is at n h, n from 0.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Response {
    /// y after each tick.
    pub y: Vec<f64>,
    /// u of each tick.
    pub u: Vec<f64>,
}

impl Response {
    /// That of a run that lasted from one instant to another, ns, from its ticks.
    #[must_use]
    pub fn of(ticks: &[TickRow], run_ns: &Range<u64>) -> Response {
        let mut response = Response::default();
        ticks.iter().for_each(|row| response.push(row, run_ns));
        response
    }

    fn push(&mut self, row: &TickRow, run_ns: &Range<u64>) {
        if run_ns.contains(&row.t_due_ns) {
            self.y.push(row.y);
            self.u.push(row.u);
        }
    }
}

/// The [`Response`] of a closed loop whose run lasted from one instant to another, ns: at most so many of its first
/// ticks. A figure mostly shows the first seconds of many, and the rest of the file takes the longer to read.
///
/// # Errors
/// [`ReadError`] if `ticks.csv` cannot be read.
pub fn response(folder: &Path, run_ns: &Range<u64>, most: usize) -> Result<Response, ReadError> {
    let mut response = Response::default();
    let path = folder.join(file_name::TICKS);
    read_while(&path, |row: &TickRow| {
        response.push(row, run_ns);
        if response.y.len() < most {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    })?;
    Ok(response)
}

/// Time from each tick of the plant to the next, ms, in order.
///
/// # Errors
/// [`ReadError`] if `ticks.csv` cannot be read.
pub fn tick_intervals_ms(folder: &Path) -> Result<Vec<f64>, ReadError> {
    let mut intervals = Intervals::default();
    let path = folder.join(file_name::TICKS);
    read(&path, |row: &TickRow| {
        intervals.push(row.t_tick_ns);
    })?;
    Ok(intervals.ms)
}

/// Time from each arrival at the plant to the next, ms, in order.
///
/// # Errors
/// [`ReadError`] if `arrivals.csv` cannot be read.
pub fn control_intervals_ms(folder: &Path) -> Result<Vec<f64>, ReadError> {
    let mut intervals = Intervals::default();
    let path = folder.join(file_name::ARRIVALS);
    read(&path, |row: &ArrivalRow| {
        intervals.push(row.t_arrive_ns);
    })?;
    Ok(intervals.ms)
}

/// Differences of consecutive timestamps.
#[derive(Debug, Default)]
struct Intervals {
    last_ns: Option<u64>,
    ms: Vec<f64>,
}

impl Intervals {
    fn push(&mut self, t_ns: u64) {
        if let Some(last_ns) = self.last_ns.replace(t_ns) {
            self.ms.push(ms_between(last_ns, t_ns));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str, text: &str) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(folder.path().join(name), text).expect("a writable folder");
        folder
    }

    #[test]
    fn a_response_runs_from_the_first_deadline_to_the_planned_end() {
        // Two ticks before it; then a command comes late, one holds for two ticks, and one to the end.
        let text = "k,t_due_ns,t_tick_ns,u,y,seq\n\
                    0,0,0,0,0,\n1,3,3,0,0,\n2,6,6,1,0.25,0\n3,9,9,1,0.5,1\n\
                    4,12,12,1,0.75,1\n5,15,15,1,1,2\n6,18,18,1,9,2\n";
        let folder = folder("ticks.csv", text);
        let y = |most| response(folder.path(), &(3..18), most).expect("readable").y;
        assert_eq!(y(6), [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(y(2), [0.0, 0.25]);
    }

    #[test]
    fn intervals_are_between_neighbours_and_may_go_back() {
        let text = "k,t_due_ns,t_tick_ns,u,y,seq\n\
                    0,0,1000000,0,0,\n1,0,4000000,0,0,\n2,0,3500000,0,0,\n";
        let ticks = folder("ticks.csv", text);
        assert_eq!(
            tick_intervals_ms(ticks.path()).expect("readable"),
            [3.0, -0.5]
        );
        let text = "n,seq,t_send_ns,t_arrive_ns,tick,u,outcome\n\
                    0,0,0,7000000,0,0,acknowledged\n1,1,0,7000000,0,0,acknowledged\n";
        let arrivals = folder("arrivals.csv", text);
        assert_eq!(
            control_intervals_ms(arrivals.path()).expect("readable"),
            [0.0]
        );
    }
}
