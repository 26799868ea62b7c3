//! Writes the page of a results folder: `cargo run -p webloop-report --example page -- DIR OUT.html`.

use std::error::Error;
use std::path::Path;

use analysis::Campaign;
use report::{Exhibits, Report};

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [folder, out] = words.as_slice() else {
        return Err("name a results folder, and the file that the page goes to".into());
    };
    let campaign = Campaign::read(Path::new(folder))?;
    let report = Report::of(&campaign, Exhibits::default())?;
    std::fs::write(out, report::page::render(&report, &report.draw()))?;
    Ok(())
}
