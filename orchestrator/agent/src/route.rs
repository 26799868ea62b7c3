//! What each request gets: who may ask, what for, and what is done about it.

use std::cell::{Cell, RefCell};
use std::path::PathBuf;
use std::rc::Rc;
use std::time::Duration;

use http_body_util::{BodyExt, Full, LengthLimitError, Limited};
use hyper::body::{Body, Bytes, Incoming};
use hyper::header::{self, HeaderValue};
use hyper::{Request, Response, StatusCode};
use serde::Serialize;
use tokio::sync::{Mutex, Notify};
use tokio::task::spawn_blocking;
use tokio::time::{Instant, timeout};

use crate::claim::Claim;
use crate::refusal::Refusal;
use crate::resource::Resource;
use crate::role::STOP_WITHIN;
use crate::run::Run;
use crate::wire::{FILE_BYTES, Health, SIZE_HEADER, StartRole, Started};
use crate::{Config, Name, Token, catalogue, shelf};

/// The largest body that is not a file.
const JSON_BYTES: usize = 64 << 10;

/// How long a body may take to come.
const BODY_WITHIN: Duration = Duration::from_secs(10);

type Answer = Response<Full<Bytes>>;

/// The agent as its requests see it. It belongs to one thread.
pub(crate) struct Handler {
    config: Config,
    /// Where the runs' folders are.
    scratch: PathBuf,
    claim: RefCell<Claim>,
    run: RefCell<Option<Rc<Run>>>,
    /// Held while runs change, so that one is gone before the next begins.
    change: Mutex<()>,
    /// Told of each claim: it may end the agent sooner than the lack of one would have.
    pub(crate) claimed: Notify,
    /// Told when the orchestrator wants the agent to end.
    pub(crate) ending: Notify,
    ended: Cell<bool>,
}

impl Handler {
    pub(crate) fn new(config: &Config, scratch: PathBuf) -> Handler {
        Handler {
            claim: RefCell::new(Claim::new(config, Instant::now())),
            config: config.clone(),
            scratch,
            run: RefCell::default(),
            change: Mutex::default(),
            claimed: Notify::new(),
            ending: Notify::new(),
            ended: Cell::new(false),
        }
    }

    pub(crate) fn claim(&self) -> std::cell::Ref<'_, Claim> {
        self.claim.borrow()
    }

    /// Ends the run that there is, for good: no other is begun after it.
    pub(crate) async fn close(&self, within: Duration) {
        self.ended.set(true);
        if let Some(run) = self.run.take() {
            run.end(within).await;
        }
    }

    /// The answer to a request, whatever it is.
    pub(crate) async fn answer(&self, request: Request<Incoming>) -> Answer {
        self.try_answer(request).await.unwrap_or_else(|refusal| {
            let mut response = json(refusal.status(), &refusal.problem());
            let headers = response.headers_mut();
            match refusal {
                Refusal::Method(_, allowed) => {
                    headers.insert(header::ALLOW, HeaderValue::from_static(allowed));
                }
                Refusal::Token | Refusal::Unclaimed => {
                    headers.insert(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"));
                }
                // The rest of the body is not waited for.
                Refusal::Large(_) | Refusal::Slow(_) | Refusal::Body(_) => {
                    headers.insert(header::CONNECTION, HeaderValue::from_static("close"));
                }
                _ => {}
            }
            response
        })
    }

    async fn try_answer(&self, request: Request<Incoming>) -> Result<Answer, Refusal> {
        let presented = request
            .headers()
            .get(header::AUTHORIZATION)
            .and_then(|value| Token::from_header(value.to_str().ok()?));
        match request.uri().path() {
            "/health" => {
                allow(&request, "GET")?;
                Ok(json(StatusCode::OK, &self.health()))
            }
            "/claim" => {
                allow(&request, "POST")?;
                self.claim.borrow_mut().claim(presented, Instant::now())?;
                self.claimed.notify_one();
                Ok(json(StatusCode::OK, &self.health()))
            }
            _ => {
                // Before anything else is said: who may not ask learns nothing.
                self.enter(presented.as_ref())?;
                let answer = self.serve(request).await;
                self.claim.borrow_mut().answered(Instant::now());
                answer
            }
        }
    }

    fn enter(&self, presented: Option<&Token>) -> Result<(), Refusal> {
        let mut claim = self.claim.borrow_mut();
        let claimed = claim.claimed();
        claim.enter(presented, Instant::now())?;
        if !claimed {
            self.claimed.notify_one();
        }
        Ok(())
    }

    async fn serve(&self, request: Request<Incoming>) -> Result<Answer, Refusal> {
        let resource: Resource = request.uri().path().parse()?;
        let from = resource.from(request.uri().query())?;
        let method = request.method().clone();
        match (resource, method.as_str()) {
            (Resource::End, "POST") => {
                self.ending.notify_one();
                Ok(empty(StatusCode::ACCEPTED))
            }
            (Resource::Run(id), "PUT") => {
                self.begin(id).await?;
                Ok(empty(StatusCode::CREATED))
            }
            (Resource::Run(id), "DELETE") => {
                self.finish(&id).await?;
                Ok(empty(StatusCode::NO_CONTENT))
            }
            (Resource::Files(id), "GET") => {
                let folder = self.run(&id)?.folder.clone();
                let files = off_thread(move || Ok(shelf::list(&folder)?)).await?;
                Ok(json(StatusCode::OK, &files))
            }
            (Resource::File(id, name), "GET") => {
                let folder = self.run(&id)?.folder.clone();
                let part = off_thread(move || shelf::read(&folder, &name, from)).await?;
                let mut response = respond(StatusCode::OK, "application/octet-stream", part.bytes);
                response.headers_mut().insert(SIZE_HEADER, part.size.into());
                Ok(response)
            }
            (Resource::File(id, name), "PUT") => {
                let run = self.run(&id)?;
                let content = body(request.into_body(), FILE_BYTES).await?;
                let folder = run.folder.clone();
                off_thread(move || Ok(shelf::put(&folder, &name, &content)?)).await?;
                Ok(empty(StatusCode::CREATED))
            }
            (Resource::Role(id, instance), "POST") => {
                let run = self.run(&id)?;
                let asked = body(request.into_body(), JSON_BYTES).await?;
                let asked: StartRole = serde_json::from_slice(&asked)
                    .map_err(|problem| Refusal::Body(problem.to_string()))?;
                let args = catalogue::arguments(&asked.role, &asked.settings, &run.folder)?;
                // The body took its time, in which the run may have been ended.
                self.run(&id)?;
                let ready = run
                    .start(&self.config.program, &instance, &asked.role, &args)
                    .await?;
                Ok(json(StatusCode::CREATED, &Started { ready }))
            }
            (Resource::Role(id, instance), "GET") => {
                Ok(json(StatusCode::OK, &self.run(&id)?.state(&instance)?))
            }
            (Resource::Seen(id, instance), "GET") => {
                Ok(json(StatusCode::OK, &self.run(&id)?.seen(&instance)?))
            }
            (Resource::Role(id, instance), "DELETE") => {
                let state = self.run(&id)?.stop(&instance, STOP_WITHIN).await?;
                Ok(json(StatusCode::OK, &state))
            }
            (resource, _) => Err(Refusal::Method(method, resource.methods())),
        }
    }

    /// Begins a run in an empty folder; the one before is ended and wiped.
    async fn begin(&self, id: Name) -> Result<(), Refusal> {
        let _change = self.change.lock().await;
        self.wipe_current().await?;
        let folder = self.scratch.join(id.as_str());
        let made = folder.clone();
        off_thread(move || Ok(shelf::make_empty(&made)?)).await?;
        if self.ended.get() {
            return Err(Refusal::Ending);
        }
        self.run.replace(Some(Rc::new(Run::new(id, folder))));
        Ok(())
    }

    /// Ends a run and wipes its folder.
    async fn finish(&self, id: &Name) -> Result<(), Refusal> {
        let _change = self.change.lock().await;
        self.run(id)?;
        self.wipe_current().await
    }

    async fn wipe_current(&self) -> Result<(), Refusal> {
        // Taken out first: from here on nobody starts another role in it.
        if let Some(run) = self.run.take() {
            run.end(STOP_WITHIN).await;
            let folder = run.folder.clone();
            off_thread(move || Ok(shelf::wipe(&folder)?)).await?;
        }
        Ok(())
    }

    fn run(&self, id: &Name) -> Result<Rc<Run>, Refusal> {
        self.run
            .borrow()
            .as_ref()
            .filter(|run| run.id == *id)
            .cloned()
            .ok_or_else(|| Refusal::Run(id.clone()))
    }

    fn health(&self) -> Health {
        Health {
            agent: self.config.name,
            webloop: env!("CARGO_PKG_VERSION").to_owned(),
            claimed: self.claim.borrow().claimed(),
        }
    }
}

fn allow(request: &Request<Incoming>, method: &'static str) -> Result<(), Refusal> {
    if request.method() == method {
        Ok(())
    } else {
        Err(Refusal::Method(request.method().clone(), method))
    }
}

/// A body of at most `limit` bytes that comes in time.
async fn body(body: Incoming, limit: usize) -> Result<Bytes, Refusal> {
    // One that says beforehand that it is too long is not read at all.
    if usize::try_from(body.size_hint().lower()).is_ok_and(|bytes| bytes > limit) {
        return Err(Refusal::Large(limit));
    }
    match timeout(BODY_WITHIN, Limited::new(body, limit).collect()).await {
        Ok(Ok(body)) => Ok(body.to_bytes()),
        Ok(Err(problem)) if problem.is::<LengthLimitError>() => Err(Refusal::Large(limit)),
        Ok(Err(problem)) => Err(Refusal::Body(problem.to_string())),
        Err(_) => Err(Refusal::Slow(BODY_WITHIN.as_secs())),
    }
}

/// Does what waits for the disk on a thread that may.
async fn off_thread<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Refusal> + Send + 'static,
) -> Result<T, Refusal> {
    spawn_blocking(work)
        .await
        .map_err(|problem| Refusal::Disk(std::io::Error::other(problem)))?
}

fn json(status: StatusCode, body: &impl Serialize) -> Answer {
    let text = serde_json::to_vec(body).expect("an answer is plain fields under fixed names");
    respond(status, "application/json", text)
}

fn empty(status: StatusCode) -> Answer {
    let mut response = Response::new(Full::default());
    *response.status_mut() = status;
    response
}

fn respond(status: StatusCode, kind: &'static str, body: Vec<u8>) -> Answer {
    let mut response = Response::new(Full::new(Bytes::from(body)));
    *response.status_mut() = status;
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(kind));
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    response
}
