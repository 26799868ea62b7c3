//! Writes the paper's tables and figures into another folder, and says what is in them:
//! `cargo run -p webloop-paper --example figures -- RESULTS FOLDER`.

use std::path::PathBuf;
use std::{env, error, fs};

use paper::{figure, table};
use report::table::Table;

fn main() -> Result<(), Box<dyn error::Error>> {
    let folders: Vec<PathBuf> = env::args_os().skip(1).map(PathBuf::from).collect();
    let [results, out] = folders.as_slice() else {
        return Err("two folders are needed: where the results are, and where to write".into());
    };
    let campaign = analysis::Campaign::read(results)?;
    let (tables, figures) = (table::all(&campaign), figure::all(&campaign)?);
    let mut text: String = tables.iter().map(|table| table.to_text() + "\n").collect();
    for figure in &figures {
        let chart = &figure.chart;
        text += &format!(
            "{}: {}\n{}\n{}\n",
            chart.name, chart.title, chart.about, chart.source
        );
        for panel in &chart.panels {
            text += &format!(
                "  ({}) {}: {:?}\n",
                panel.letter, panel.title, panel.x.range
            );
            for series in &panel.series {
                text += &format!("    {}: {} points\n", series.name, series.points.len());
            }
        }
    }
    let files = tables.iter().flat_map(Table::files);
    for (name, content) in files.chain(figures.iter().flat_map(|figure| figure.draw().files())) {
        let path = out.join(name);
        path.parent().map_or(Ok(()), fs::create_dir_all)?;
        fs::write(path, content)?;
    }
    fs::write(out.join("figures.txt"), text)?;
    Ok(())
}
