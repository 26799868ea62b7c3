//! What a page asks for with a body: to begin a session, to take rows, to end.
//!
//! The head was judged in `route`; here the body is read, within limits of size
//! and time, and what comes of it is awaited from the clerk. All of it runs
//! beside the commands of the loop, never before them.

use std::{cell::RefCell, rc::Rc, time::Duration};

use http_body_util::{BodyExt, LengthLimitError, Limited};
use hyper::{
    Response, StatusCode,
    body::{Bytes, Incoming},
};
use pace::now_ns;
use serde::{Deserialize, Serialize};
use tokio::{
    task,
    time::{sleep, timeout},
};

use crate::{
    answer::{JSON, as_json},
    refusal::Refusal,
    route::Desk,
    session::Client,
    token::{Pass, Token},
};

/// The longest body. A second at 1 kHz has some 100 bytes a row: two chunks.
pub(crate) const BODY_BYTES: usize = 64 * 1024;

/// How long a body may take. The worst links stall for 5 s.
const BODY_TIMEOUT: Duration = Duration::from_secs(10);

/// What to do with a body.
#[derive(Clone, Debug)]
pub(crate) enum Errand {
    /// Begin a session.
    Claim,
    /// Take a chunk of rows.
    Rows {
        /// Its number.
        chunk: u64,
        /// Whose it is.
        pass: Pass,
    },
    /// Take the report and end the session.
    End {
        /// Whose it is.
        pass: Pass,
    },
}

impl Errand {
    /// The body's content type.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Claim | Self::End { .. } => JSON,
            Self::Rows { .. } => "text/csv",
        }
    }
}

/// What a claim says.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Claim {
    client: String,
}

/// What a claim gets.
#[derive(Serialize)]
struct Grant<'a> {
    session: String,
    h_ns: u64,
    late: endpoint::Late,
    /// Not there: the paper's.
    #[serde(skip_serializing_if = "Option::is_none")]
    law: Option<&'a serde_json::Value>,
}

/// Runs an errand to its response.
pub(crate) async fn run(
    errand: Errand,
    body: Incoming,
    desk: Rc<RefCell<Desk>>,
) -> Response<Bytes> {
    let done = match errand {
        Errand::Claim => claim(body, &desk).await,
        Errand::Rows { chunk, pass } => rows(chunk, &pass, body, &desk).await,
        Errand::End { pass } => end(&pass, body, &desk).await,
    };
    done.unwrap_or_else(|refusal| {
        desk.borrow_mut().refused += 1;
        refusal.response(false)
    })
}

async fn claim(body: Incoming, desk: &Rc<RefCell<Desk>>) -> Result<Response<Bytes>, Refusal> {
    let claim: Claim = serde_json::from_slice(&read(body).await?)?;
    let client = Client::try_new(claim.client)?;
    let token = Token::random()?;
    let session = token.reveal();
    let (number, files) = {
        let mut desk = desk.borrow_mut();
        let number = desk.control.claim(token, client, now_ns())?;
        // One that was silent may not have been noticed yet.
        desk.is_over(number - 1);
        desk.inbox.welcome();
        (number, desk.clerk.open(number))
    };
    if let Err(problem) = files.wait().await {
        desk.borrow_mut().control.withdraw(number);
        return Err(problem.into());
    }
    task::spawn_local(watch(number, Rc::clone(desk)));
    let desk = desk.borrow();
    Ok(as_json(&Grant {
        session,
        h_ns: desk.settings.h.ns(),
        late: desk.settings.late,
        law: desk.law.as_ref(),
    }))
}

async fn rows(
    chunk: u64,
    pass: &Pass,
    body: Incoming,
    desk: &Rc<RefCell<Desk>>,
) -> Result<Response<Bytes>, Refusal> {
    let text = read(body).await?;
    let (number, filed) = {
        let mut desk = desk.borrow_mut();
        // Asked again: the body took its time.
        let number = desk.control.hear(pass, now_ns())?;
        (number, desk.clerk.rows(chunk, text))
    };
    let rows = filed.wait().await?;
    desk.borrow_mut().control.count_rows(number, rows);
    Ok(done())
}

async fn end(
    pass: &Pass,
    body: Incoming,
    desk: &Rc<RefCell<Desk>>,
) -> Result<Response<Bytes>, Refusal> {
    let json = read(body).await?;
    let (number, filed) = {
        let mut desk = desk.borrow_mut();
        if desk.control.has_ended(pass) {
            return Ok(done());
        }
        let number = desk.control.hear(pass, now_ns())?;
        (number, desk.clerk.report(json))
    };
    let ending = filed.wait().await?;
    let mut desk = desk.borrow_mut();
    desk.control.end(number, ending);
    desk.is_over(number);
    Ok(done())
}

/// Sees to it that a session whose page is silent is over.
async fn watch(number: u64, desk: Rc<RefCell<Desk>>) {
    loop {
        let left_ns = desk.borrow_mut().control.left_ns(number, now_ns());
        let Some(left_ns) = left_ns else {
            break;
        };
        sleep(Duration::from_nanos(left_ns)).await;
    }
    let desk = desk.borrow();
    desk.is_over(number);
    desk.clerk.close(number);
}

impl Desk {
    /// Tells the sockets of session `number` and of all before it.
    fn is_over(&self, number: u64) {
        self.over.send_if_modified(|over| {
            let newer = number > *over;
            *over = number.max(*over);
            newer
        });
    }
}

fn done() -> Response<Bytes> {
    let mut response = Response::new(Bytes::new());
    *response.status_mut() = StatusCode::NO_CONTENT;
    response
}

async fn read(body: Incoming) -> Result<Bytes, Refusal> {
    let whole = Limited::new(body, BODY_BYTES).collect();
    match timeout(BODY_TIMEOUT, whole).await {
        Ok(Ok(whole)) => Ok(whole.to_bytes()),
        Ok(Err(error)) if error.is::<LengthLimitError>() => {
            Err(Refusal::Long { limit: BODY_BYTES })
        }
        Ok(Err(_)) => Err(Refusal::Broken),
        Err(_) => Err(Refusal::Slow {
            seconds: BODY_TIMEOUT.as_secs(),
        }),
    }
}
