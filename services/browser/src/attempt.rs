//! One start of the browser: from its fresh folder until nothing is left of it.
//!
//! [`crate::visit()`] decides whether there is another start.

use std::{future::Future, io, pin::Pin, time::Duration};

use clock::now::now_ns;
use endpoint::report::{self, Confinement, Engine};
use tokio::time::{MissedTickBehavior, interval, sleep};

use crate::{
    address::{Times, url},
    argument::{Circumstance, arguments},
    clock::clock_ns,
    config::{Config, VisitError, refused},
    engine::Browser,
    plant::{Plant, Status},
    preference::user_js,
    process::{Process, has_shared_memory},
    profile::Profile,
    sandbox::confinement,
    watch::{Course, Step, Trouble, Watch},
};

/// Interval at which the browser's process is checked.
const LOOK: Duration = Duration::from_millis(100);

/// A Chromium that cannot use its sandbox ends within this time.
const REFUSAL_WITHIN: Duration = Duration::from_secs(10);

/// `nobody`. Root's browser runs as that user, since Chromium does not sandbox root, and Firefox
/// would keep root's rights.
const NOBODY: u32 = 65534;

/// The data of one start of the browser.
#[derive(Default)]
pub(crate) struct Attempt {
    pub(crate) arguments: Vec<String>,
    pub(crate) user: Option<u32>,
    pub(crate) kind: Option<Confinement>,
    pub(crate) watch: Option<Watch>,
    pub(crate) interrupted: bool,
}

/// The state of a visit of a browser to a plant.
pub(crate) struct Visit<'a> {
    pub(crate) config: &'a Config,
    pub(crate) program: Browser,
    pub(crate) plant: Plant,
    /// Whether Chromium should use its own sandbox.
    pub(crate) sandbox: bool,
    /// Chromium's output when it could not.
    pub(crate) reason: Option<String>,
}

impl Visit<'_> {
    /// Starts the browser once and waits for the page's end; returns `None` if Chromium could not use
    /// its sandbox and should be started without it.
    pub(crate) async fn attempt(
        &mut self,
        stop: Pin<&mut impl Future<Output = io::Result<()>>>,
        ready: &mut Option<impl FnOnce()>,
    ) -> Result<Option<report::Visit>, VisitError> {
        let Config {
            engine,
            plant,
            ref limits,
            ..
        } = *self.config;
        let profile = self.profile()?;
        let circumstance = Circumstance {
            sandbox: self.sandbox,
            shared_memory: has_shared_memory(),
        };
        let times = Times {
            start_ns: self.config.start_ns,
            duration_ns: self.config.duration_ns,
            clock_ns: clock_ns(),
        };
        let url = url(plant, &self.config.settings, self.config.page, times);
        let mut attempt = Attempt {
            arguments: arguments(engine, &profile.home(), plant, &url, circumstance),
            ..Attempt::default()
        };
        let mut process = self.start(&profile, &mut attempt)?;
        let mut watch = Watch::new(self.course());
        let watched = self
            .watch(&mut process, &mut watch, &mut attempt, stop, ready)
            .await;

        // Whatever the result, nothing may be left of the browser.
        let status = process.ended().ok().flatten();
        let lived = process.started().elapsed();
        process.end(limits.end).map_err(refused(engine, "end it"))?;
        let words = process.last_words();
        drop(process);
        if let Err(error) = profile.remove() {
            tracing::warn!("cannot remove the folder of {engine}: {error}");
        }

        let version = self.program.version.clone();
        let trouble = match (watched?, status) {
            (Ok(()), _) => {
                attempt.watch = Some(watch);
                return Ok(Some(self.report(attempt)));
            }
            (Err(None), Some(status)) => {
                let refused = watch.opened().is_none() && lived < REFUSAL_WITHIN;
                if engine == Engine::Chromium && self.sandbox && refused {
                    self.sandbox = false;
                    self.reason = Some(words);
                    return Ok(None);
                }
                return Err(VisitError::Crashed {
                    version,
                    program: self.program.path.display().to_string(),
                    status,
                    words,
                });
            }
            (Err(None), None) => Trouble::NeverOpened,
            (Err(Some(trouble)), _) => trouble,
        };
        Err(self.named(trouble, &watch, words, url))
    }

    /// A fresh folder for the browser's own files, with Firefox's preferences.
    fn profile(&self) -> Result<Profile, VisitError> {
        let Config { engine, plant, .. } = *self.config;
        let no_folder = refused(engine, "make its folder");
        let profile = Profile::make(&self.config.scratch).map_err(&no_folder)?;
        if engine == Engine::Firefox {
            let text = user_js(plant);
            profile.write("user.js", &text).map_err(no_folder)?;
        }
        Ok(profile)
    }

    /// Starts the browser; root's runs as nobody if the system permits it.
    fn start(&self, profile: &Profile, attempt: &mut Attempt) -> Result<Process, VisitError> {
        let home = profile.home();
        let start = |user| {
            let leash = self.config.leash;
            Process::start(&self.program, &attempt.arguments, &home, user, leash)
        };
        if rustix::process::geteuid().is_root() && profile.give_to(NOBODY).is_ok() {
            match start(Some(NOBODY)) {
                Ok(process) => {
                    attempt.user = Some(NOBODY);
                    return Ok(process);
                }
                Err(error) => tracing::warn!("cannot start the browser as user {NOBODY}: {error}"),
            }
            let own = rustix::process::geteuid().as_raw();
            let own = profile.give_to(own);
            own.map_err(refused(self.config.engine, "take back its folder"))?;
        }
        start(None).map_err(refused(self.config.engine, "start it"))
    }

    /// Watches the page until its end. An error without trouble means that the browser's process has ended.
    async fn watch(
        &self,
        process: &mut Process,
        watch: &mut Watch,
        attempt: &mut Attempt,
        mut stop: Pin<&mut impl Future<Output = io::Result<()>>>,
        ready: &mut Option<impl FnOnce()>,
    ) -> Result<Result<(), Option<Trouble>>, VisitError> {
        let started = process.started();
        let engine = self.config.engine;
        let mut looks = interval(LOOK);
        looks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut asking = Box::pin(self.ask());
        loop {
            let status = tokio::select! {
                status = &mut asking => status,
                _ = looks.tick() => {
                    let ended = process.ended().map_err(refused(engine, "check its process"))?;
                    if ended.is_some() {
                        // The page may have ended before the browser.
                        let last = self.plant.status().await;
                        let step = last.ok().map(|last| watch.saw(started.elapsed(), &last));
                        return Ok(match step {
                            Some(Ok(Step::Ended)) => Ok(()),
                            Some(Err(trouble @ Trouble::Page { .. })) => Err(Some(trouble)),
                            _ => Err(None),
                        });
                    }
                    if let Err(trouble) = watch.passed(started.elapsed()) {
                        return Ok(Err(Some(trouble)));
                    }
                    continue;
                }
                told = &mut stop => {
                    told.map_err(refused(engine, "hear signals"))?;
                    attempt.interrupted = true;
                    return Ok(Ok(()));
                }
            };
            match status.map(|status| watch.saw(started.elapsed(), &status)) {
                Some(Ok(Step::Opened)) => {
                    attempt.kind = Some(confinement(engine, &process.members()));
                    if let Some(ready) = ready.take() {
                        ready();
                    }
                }
                Some(Ok(Step::Ended)) => return Ok(Ok(())),
                Some(Err(trouble)) => return Ok(Err(Some(trouble))),
                Some(Ok(Step::Wait)) | None => {}
            }
            asking = Box::pin(self.ask());
        }
    }

    /// The next status of the plant's session; `None` if the plant does not answer.
    async fn ask(&self) -> Option<Status> {
        sleep(self.config.limits.look).await;
        match self.plant.status().await {
            Ok(status) => Some(status),
            Err(why) => {
                tracing::debug!("the plant does not report the session: {why}");
                None
            }
        }
    }

    /// The error for a trouble, with all that is known of it.
    fn named(&self, trouble: Trouble, watch: &Watch, words: String, url: String) -> VisitError {
        let limits = self.config.limits;
        let version = self.program.version.clone();
        match trouble {
            Trouble::NeverOpened => VisitError::NeverOpened {
                version,
                waited_s: limits.open.as_secs(),
                words,
                url,
            },
            Trouble::Hung { silent_s } => VisitError::Hung {
                version,
                silent_s,
                commands: watch.session().map_or(0, |session| session.commands),
            },
            Trouble::Unfinished => VisitError::Unfinished {
                version,
                late_s: (limits.finish + self.timeout()).as_secs(),
                seen: watch.session().map_or_else(String::new, |session| {
                    let (commands, rows) = (session.commands, session.rows);
                    format!("the plant had {commands} commands and {rows} rows from it")
                }),
            },
            Trouble::Page { outcome, reason } => VisitError::Page {
                version,
                outcome,
                reason,
            },
        }
    }

    fn course(&self) -> Course {
        let start = self.config.start_ns;
        Course {
            start: start.map(|t_ns| Duration::from_nanos(t_ns.saturating_sub(now_ns()))),
            length: Duration::from_nanos(self.config.duration_ns),
            timeout: self.timeout(),
            limits: self.config.limits,
        }
    }

    fn timeout(&self) -> Duration {
        Duration::from_nanos(self.config.settings.timeout_ns)
    }
}
