//! Measures the contenders of a table in turn, as often as is asked.
//!
//! Each repetition measures them all, one after another, and a ratio is taken within a repetition: what disturbs the
//! machine for longer than a repetition is in both of its numbers.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::argument::Settings;
use crate::context::{Context, Programs};
use crate::group::Group;
use crate::outcome::{MeasuredTable, Series};
use crate::processor::Processors;

/// Measures a table. Calls `on_contender` with each contender and the number of the repetition before it is measured.
///
/// Ends early, with what is measured by then, when `stop` is set.
///
/// # Errors
/// If there is no temporary folder, or the kernel does not say which processors there are.
pub(crate) fn measure(
    group: Group,
    settings: &Settings,
    programs: &Programs,
    stop: &AtomicBool,
    mut on_contender: impl FnMut(&str, u32),
) -> io::Result<MeasuredTable> {
    let table = group.table();
    let mut series: Vec<Series> = table.contenders.iter().map(Series::new).collect();
    let processors = table.processors.map(Processors::last).transpose()?;
    for time in 0..settings.times.min(group.most_times()) {
        for one in &mut series {
            if stop.load(Ordering::Relaxed) {
                return Ok(MeasuredTable { group, series });
            }
            if one.is_skipped() {
                continue;
            }
            on_contender(one.contender.name, time);
            let folder = tempfile::tempdir()?;
            let context = Context {
                measure_ms: settings.measure_ms,
                programs,
                folder: folder.path().to_owned(),
            };
            let measure = || (one.contender.measure)(&context);
            one.add(match &processors {
                Some(processors) => processors.run(measure),
                None => measure(),
            });
        }
    }
    Ok(MeasuredTable { group, series })
}
