//! The page's files, embedded in the program. The plant serves them and sets their headers.

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const JAVASCRIPT: &str = "text/javascript; charset=utf-8";
const SVG: &str = "image/svg+xml";

/// A file of the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct File {
    /// Its path in a request: `/` for the page itself, `/style.css`.
    pub path: &'static str,
    /// Its content type.
    pub kind: &'static str,
    /// Its content.
    pub bytes: &'static [u8],
}

/// The page itself at `/`, and every other file under its own name.
macro_rules! files {
    ($index:literal; $($kind:ident: $($name:literal)+;)+) => {
        &[File {
            path: "/",
            kind: HTML,
            bytes: include_bytes!(concat!("../page/", $index)),
        }, $($(File {
            path: concat!("/", $name),
            kind: $kind,
            bytes: include_bytes!(concat!("../page/", $name)),
        },)+)+]
    };
}

/// All files of the page.
pub const FILES: &[File] = files! {
    "index.html";
    CSS: "style.css";
    SVG: "icon.svg";
    JAVASCRIPT:
        "aged.js" "app.js" "canvas.js" "choice.js" "chore.js" "clock.js" "course.js" "display.js" "drive.js"
        "end.js" "feedback.js" "fetch.js" "form.js" "histogram.js" "law.js" "message.js" "model.js"
        "pid.js" "plot.js" "probe.js" "record.js" "remote.js" "report.js" "ring.js" "row.js" "sender.js"
        "sentence.js" "run.js" "session.js" "setting.js" "smith.js" "socket.js" "thread.js" "timer.js" "trace.js"
        "transfer.js" "way.js" "worker.js" "xhr.js";
};

#[cfg(test)]
mod tests {
    use std::{collections::BTreeSet, fs, path::Path};

    use super::*;

    #[test]
    fn every_file_of_the_page_is_carried() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("page");
        let name = |path: &str| match path {
            "/" => "/index.html".to_owned(),
            other => other.to_owned(),
        };
        let there: BTreeSet<String> = fs::read_dir(folder)
            .expect("the page's folder")
            .flatten()
            .map(|entry| format!("/{}", entry.file_name().to_string_lossy()))
            .collect();
        let carried: BTreeSet<String> = FILES.iter().map(|file| name(file.path)).collect();
        assert_eq!(carried, there);
    }
}
