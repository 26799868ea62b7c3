//! The routes: what each request does, who may send it, and its answer.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::{FromRequestParts, RawPathParams, RawQuery, Request, State};
use axum::http::request::Parts;
use axum::http::{HeaderMap, StatusCode, Uri, Version, header};
use axum::middleware::{Next, from_fn, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::{MethodRouter, get, post, put};
use endpoint::NotServed;
use http_body_util::{BodyExt, LengthLimitError, Limited};
use hyper::body::Body as _;
use text::excerpt;
use tokio::time::{Instant, timeout};

use crate::agent::answer::{json, respond};
use crate::agent::refusal::Refusal;
use crate::agent::shelf;
use crate::agent::{Agent, off_thread};
use crate::name::Name;
use crate::token::Token;
use crate::wire::{SIZE_HEADER, StartRole, Started};
use process::STOP_WITHIN;
use process::Stop;
use process::program::OWN;

/// Maximum size of a body.
const BODY_BYTES: usize = 16 << 20;

/// How long a body may take to arrive.
const BODY_WITHIN: Duration = Duration::from_secs(5);

/// Number of characters that a refusal quotes of a path or a query.
const EXCERPT_CHARS: usize = 40;

type Shared = State<Arc<Agent>>;
type Answered = Result<Response, Refusal>;

/// All routes of an agent.
pub(crate) fn router(agent: Arc<Agent>) -> Router {
    let anyones = Router::new()
        .route("/health", only("GET", get(health)))
        .route("/claim", only("POST", post(claim)));
    let masters = Router::new()
        .route("/end", only("POST", post(end)))
        .route("/run/{id}", only("PUT, DELETE", put(begin).delete(finish)))
        .route("/run/{id}/files", only("GET", get(files)))
        .route("/run/{id}/own/files", only("GET", get(own_files)))
        .route(
            "/run/{id}/role/{instance}",
            only("GET, POST, DELETE", get(state).post(start).delete(stop)),
        )
        .route("/run/{id}/role/{instance}/seen", only("GET", get(seen)))
        .route(
            "/run/{id}/role/{instance}/freeze",
            only("POST", post(freeze)),
        )
        .route("/run/{id}/role/{instance}/kill", only("POST", post(kill)))
        // Applies to the routes above; a file, below, takes a query.
        .route_layer(from_fn(refuse_query))
        .route("/run/{id}/file/{name}", only("GET", get(read_file)))
        .route("/run/{id}/own/file/{name}", only("GET", get(read_own_file)))
        .fallback(nowhere)
        // Runs before all of these: a caller without the token learns nothing.
        .layer(from_fn_with_state(Arc::clone(&agent), enter));
    anyones
        .merge(masters)
        // Outermost, so that what is not for the agent is not judged any further.
        .layer(from_fn_with_state(Arc::clone(&agent), refuse_foreign))
        .with_state(agent)
}

/// Refuses requests to a name that is not the agent's, and those that a page in a browser sent: the agent has
/// none of its own.
async fn refuse_foreign(State(agent): Shared, request: Request, next: Next) -> Answered {
    let (headers, uri) = (request.headers(), request.uri());
    let hosts = headers.get_all(header::HOST);
    let count = hosts.iter().count();
    // HTTP/1.0 is older than this header. It may look, as a health check does.
    let may_lack = request.version() == Version::HTTP_10 && uri.path() == "/health";
    if count > 1 || (count == 0 && !may_lack) {
        return Err(Refusal::Host(count));
    }
    // Where the target names a host, that counts in place of `Host` (RFC 9112, 3.2.2).
    if let Some(named) = uri.authority() {
        let is_own = agent.hosts.check(named.as_str().as_bytes()).is_ok();
        if !is_own || uri.scheme_str() != Some("http") {
            return Err(Refusal::Host(count));
        }
    }
    for host in hosts {
        match agent.hosts.check(host.as_bytes()) {
            Err(problem @ NotServed::Foreign(_)) if uri.authority().is_none() => {
                return Err(Refusal::Misdirected(problem));
            }
            Err(problem @ NotServed::Malformed) => return Err(Refusal::NoHost(problem)),
            Ok(()) | Err(NotServed::Foreign(_)) => {}
        }
    }
    for name in PAGES {
        if headers.contains_key(name) {
            return Err(Refusal::Page(name));
        }
    }
    Ok(next.run(request).await)
}

/// What only a browser sends, and with every request of a page.
const PAGES: [&str; 3] = ["origin", "referer", "sec-fetch-site"];

/// Refuses all methods but these; `allowed` is the value of the header `Allow`.
fn only(allowed: &'static str, methods: MethodRouter<Arc<Agent>>) -> MethodRouter<Arc<Agent>> {
    let refuse = move |method| async move { Refusal::Method(method, allowed) };
    // By default the router serves HEAD as GET.
    methods.head(refuse).fallback(refuse)
}

/// Admits requests of the agent's own orchestrator. Each is completed even if the client goes away
/// meanwhile: a run must not stay half ended.
async fn enter(State(agent): Shared, request: Request, next: Next) -> Answered {
    agent.enter(presented(request.headers())?.as_ref())?;
    let answer = tokio::spawn(async move {
        let answer = next.run(request).await;
        agent.claim().answered(Instant::now());
        answer
    });
    Ok(answer
        .await
        .unwrap_or_else(|_| StatusCode::INTERNAL_SERVER_ERROR.into_response()))
}

/// The token of a request. With two it is not clear who asks.
fn presented(headers: &HeaderMap) -> Result<Option<Token>, Refusal> {
    let mut values = headers.get_all(header::AUTHORIZATION).iter();
    match (values.next(), values.next()) {
        (_, Some(_)) => Err(Refusal::Tokens),
        (value, None) => {
            let text = value.and_then(|value| value.to_str().ok());
            Ok(text.and_then(Token::from_header))
        }
    }
}

async fn refuse_query(RawQuery(query): RawQuery, request: Request, next: Next) -> Answered {
    match query {
        None => Ok(next.run(request).await),
        Some(query) => Err(Refusal::Query(excerpt(&query, EXCERPT_CHARS))),
    }
}

async fn nowhere(uri: Uri) -> Refusal {
    Refusal::Path(excerpt(uri.path(), EXCERPT_CHARS))
}

async fn health(State(agent): Shared) -> Response {
    json(StatusCode::OK, &agent.health())
}

async fn claim(State(agent): Shared, headers: HeaderMap) -> Answered {
    let presented = presented(&headers)?;
    agent.claim().claim(presented, Instant::now())?;
    agent.claimed.notify_one();
    Ok(json(StatusCode::OK, &agent.health()))
}

async fn end(State(agent): Shared) -> StatusCode {
    agent.ending.notify_one();
    StatusCode::ACCEPTED
}

async fn begin(State(agent): Shared, Names([id]): Names<1>) -> Result<StatusCode, Refusal> {
    agent.begin(id).await?;
    Ok(StatusCode::CREATED)
}

async fn finish(State(agent): Shared, Names([id]): Names<1>) -> Result<StatusCode, Refusal> {
    agent.finish(&id).await?;
    Ok(StatusCode::NO_CONTENT)
}

async fn files(State(agent): Shared, Names([id]): Names<1>) -> Answered {
    let folder = agent.run(&id)?.folder.clone();
    let files = off_thread(move || Ok(shelf::list(&folder)?)).await?;
    Ok(json(StatusCode::OK, &files))
}

/// What a program of somebody's own left in its folder; nothing, if it has none.
async fn own_files(State(agent): Shared, Names([id]): Names<1>) -> Answered {
    let folder = agent.run(&id)?.folder.join(OWN);
    let files = off_thread(move || match shelf::list(&folder) {
        Err(problem) if problem.kind() == ErrorKind::NotFound => Ok(BTreeMap::new()),
        listed => Ok(listed?),
    });
    Ok(json(StatusCode::OK, &files.await?))
}

async fn read_file(State(agent): Shared, Names([id, name]): Names<2>, query: RawQuery) -> Answered {
    let folder = agent.run(&id)?.folder.clone();
    part(folder, name, query).await
}

async fn read_own_file(
    State(agent): Shared,
    Names([id, name]): Names<2>,
    query: RawQuery,
) -> Answered {
    let folder = agent.run(&id)?.folder.join(OWN);
    part(folder, name, query).await
}

async fn part(folder: PathBuf, name: Name, RawQuery(query): RawQuery) -> Answered {
    let from = from(query)?;
    let part = off_thread(move || shelf::read(&folder, &name, from)).await?;
    let mut response = respond(StatusCode::OK, "application/octet-stream", part.bytes);
    response.headers_mut().insert(SIZE_HEADER, part.size.into());
    Ok(response)
}

async fn start(State(agent): Shared, Names([id, instance]): Names<2>, body: Body) -> Answered {
    let run = agent.run(&id)?;
    let asked = content(body).await?;
    let asked: StartRole =
        serde_json::from_slice(&asked).map_err(|problem| Refusal::Body(problem.to_string()))?;
    // The run may have ended while the body arrived.
    agent.run(&id)?;
    let ready = run.start(&agent.config.program, &instance, &asked).await?;
    Ok(json(StatusCode::CREATED, &Started { ready }))
}

async fn state(State(agent): Shared, Names([id, instance]): Names<2>) -> Answered {
    Ok(json(StatusCode::OK, &agent.run(&id)?.state(&instance)?))
}

async fn seen(State(agent): Shared, Names([id, instance]): Names<2>) -> Answered {
    Ok(json(StatusCode::OK, &agent.run(&id)?.seen(&instance)?))
}

async fn freeze(
    State(agent): Shared,
    Names([id, instance]): Names<2>,
    body: Body,
) -> Result<StatusCode, Refusal> {
    let stops = content(body).await?;
    let stops: Vec<Stop> =
        serde_json::from_slice(&stops).map_err(|problem| Refusal::Body(problem.to_string()))?;
    agent.run(&id)?.freeze(&instance, stops)?;
    Ok(StatusCode::NO_CONTENT)
}

async fn kill(State(agent): Shared, Names([id, instance]): Names<2>) -> Answered {
    Ok(json(StatusCode::OK, &agent.run(&id)?.kill(&instance)?))
}

async fn stop(State(agent): Shared, Names([id, instance]): Names<2>) -> Answered {
    let state = agent.run(&id)?.stop(&instance, STOP_WITHIN).await?;
    Ok(json(StatusCode::OK, &state))
}

/// The names in a path. Each is decoded on its own, so that no `%2F` becomes a slash.
struct Names<const N: usize>([Name; N]);

impl<S: Send + Sync, const N: usize> FromRequestParts<S> for Names<N> {
    type Rejection = Refusal;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Refusal> {
        let texts = RawPathParams::from_request_parts(parts, state).await;
        let nowhere = || Refusal::Path(excerpt(parts.uri.path(), EXCERPT_CHARS));
        let texts = texts.map_err(|_| nowhere())?;
        let names: Result<Vec<Name>, _> = texts.iter().map(|(_, text)| text.parse()).collect();
        names?.try_into().map(Names).map_err(|_| nowhere())
    }
}

/// The first requested byte of a file: `from=N`. Refuses any other query.
fn from(query: Option<String>) -> Result<u64, Refusal> {
    let Some(query) = query else {
        return Ok(0);
    };
    let digits = query.strip_prefix("from=");
    let from = digits.and_then(|digits| digits.parse().ok());
    from.ok_or_else(|| Refusal::Query(excerpt(&query, EXCERPT_CHARS)))
}

/// Reads a body, unless it is too long or too slow.
async fn content(body: Body) -> Result<Bytes, Refusal> {
    // A body that announces that it is too long is not read at all.
    if usize::try_from(body.size_hint().lower()).is_ok_and(|bytes| bytes > BODY_BYTES) {
        return Err(Refusal::Large(BODY_BYTES));
    }
    match timeout(BODY_WITHIN, Limited::new(body, BODY_BYTES).collect()).await {
        Ok(Ok(body)) => Ok(body.to_bytes()),
        Ok(Err(problem)) if problem.is::<LengthLimitError>() => Err(Refusal::Large(BODY_BYTES)),
        Ok(Err(problem)) => Err(Refusal::Body(problem.to_string())),
        Err(_) => Err(Refusal::Slow(BODY_WITHIN.as_secs())),
    }
}
