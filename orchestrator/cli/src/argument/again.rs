//! The command that goes on with runs that are not complete.

use std::path::Path;

use clap::ValueEnum;

use plan::RepeatCount;

use super::campaign::{Backend, Choice, Player, Replacement, Run, word};

impl Run {
    /// The command line that repeats what is not complete in this folder: with all options that change what runs,
    /// where, and how it is judged, and without those that change only what is shown. For a shell.
    pub(crate) fn again(&self, folder: &Path) -> String {
        // Each field is named, so that a new one is decided upon.
        let Run {
            experiment: _,
            quick,
            choice: Choice { only, cells, shard },
            full,
            jobs,
            instead,
            fix,
            seed,
            backend,
            no_build,
            player,
            awake,
            timing,
            tries,
            dry_run: _,
            no_report,
            live: _,
            // The folder is named, whoever chose it.
            out: _,
            resume: _,
            failed: _,
            progress: _,
            require,
            // Of a gate: `run` has no word for it.
            undecided: _,
        } = self;
        let mut line = Line("webloop run".to_owned());
        match quick {
            true => line.flag("--quick", true),
            false => line.word(self.experiment()),
        }
        only.iter()
            .for_each(|pattern| line.value("--only", pattern));
        if !cells.is_empty() {
            let cells: Vec<String> = cells.iter().map(usize::to_string).collect();
            line.value("--cells", &cells.join(","));
        }
        line.given("--shard", shard.as_ref());
        line.flag("--full", *full);
        line.given("--jobs", jobs.as_ref());
        instead.repeat(&mut line);
        fix.iter()
            .for_each(|(axis, value)| line.value("--fix", &format!("{axis}={value}")));
        line.given("--seed", seed.as_ref());
        line.choice("--backend", *backend, Backend::Netns);
        line.flag("--no-build", *no_build);
        line.choice("--player", *player, Player::Auto);
        line.flag("--awake", *awake);
        line.given(
            "--timing",
            timing.as_ref().map(|file| file.display()).as_ref(),
        );
        line.given("--tries", Some(tries).filter(|tries| **tries != Run::TRIES));
        line.flag("--no-report", *no_report);
        require
            .iter()
            .for_each(|clause| line.value("--require", &clause.to_string()));
        line.value("--out", &folder.display().to_string());
        line.flag("--failed", true);
        line.0
    }
}

impl Replacement {
    fn repeat(&self, line: &mut Line) {
        let Replacement {
            topology,
            client,
            system,
            h,
            duration,
            repeats,
        } = self;
        line.list("--topology", topology);
        line.list("--client", client);
        line.list("--system", system);
        let h: Vec<String> = h.iter().map(ToString::to_string).collect();
        line.list("--h", &h);
        line.given("--duration", duration.as_ref());
        line.given("--repeats", repeats.map(RepeatCount::get).as_ref());
    }
}

/// A command line as it grows.
struct Line(String);

impl Line {
    fn word(&mut self, word: &str) {
        self.0 += " ";
        self.0 += &quoted(word);
    }

    fn flag(&mut self, name: &str, is_given: bool) {
        if is_given {
            self.word(name);
        }
    }

    fn value(&mut self, name: &str, value: &str) {
        // One that begins with a dash would be an option of its own.
        if value.starts_with('-') {
            return self.word(&format!("{name}={value}"));
        }
        self.word(name);
        self.word(value);
    }

    fn given(&mut self, name: &str, value: Option<&impl ToString>) {
        if let Some(value) = value {
            self.value(name, &value.to_string());
        }
    }

    fn list(&mut self, name: &str, values: &[String]) {
        if !values.is_empty() {
            self.value(name, &values.join(","));
        }
    }

    fn choice<T: ValueEnum + PartialEq + Copy>(&mut self, name: &str, chosen: T, usual: T) {
        if chosen != usual {
            self.value(name, &word(&chosen));
        }
    }
}

/// A word as a shell reads it back.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-./:=,@%+".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use clap::Parser;

    use crate::argument::{Argument, Command, Run};

    fn run(words: &[&str]) -> Run {
        let argument = Argument::try_parse_from([&["webloop", "run"], words].concat());
        match argument.expect("a command line").command {
            Command::Run(run) => run,
            other => panic!("{other:?}"),
        }
    }

    fn again(words: &[&str]) -> String {
        run(words).again(Path::new("my results/x"))
    }

    #[test]
    fn what_is_usual_is_not_said() {
        assert_eq!(
            again(&["settling", "--progress", "quiet", "--live", "--tries", "3"]),
            "webloop run settling --out 'my results/x' --failed"
        );
        assert_eq!(
            again(&["--quick"]),
            "webloop run --quick --out 'my results/x' --failed"
        );
    }

    #[test]
    fn what_changes_the_outcome_is_repeated_and_read_back_by_a_shell() {
        let words = [
            "it's mine.toml",
            "--only",
            "couva*",
            "--only",
            "arima",
            "--shard",
            "2/7",
            "--full",
            "--jobs",
            "2",
            "--topology",
            "./my link.toml,couva",
            "--client",
            "python",
            "--system",
            "pendulum",
            "--h",
            "3ms,10ms",
            "--duration",
            "2s",
            "--repeats",
            "4",
            "--seed",
            "7",
            "--backend",
            "sim",
            "--no-build",
            "--player",
            "user",
            "--awake",
            "--timing",
            "timings.toml",
            "--tries",
            "1",
            "--no-report",
            "--require",
            "settling <= 400ms in 90% at 95%",
        ];
        let line = again(&words);
        let printed = std::process::Command::new("sh")
            .args([
                "-c",
                &format!("printf '%s\\n' {}", &line["webloop run".len()..]),
            ])
            .output()
            .expect("a shell");
        let printed = String::from_utf8(printed.stdout).expect("text");
        let read: Vec<&str> = printed.lines().collect();
        let expected = [&words[..], &["--out", "my results/x", "--failed"]].concat();
        assert_eq!(read, expected);
        // What is read back says the same.
        assert_eq!(again(&read[..words.len()]), line);
    }
}
