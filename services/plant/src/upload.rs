//! Requests of a page with a body: to begin a session, to store rows, to end.
//!
//! `route` has checked the head and `connection` has read the body; this file executes the request and waits
//! for the filer's result. All of it runs beside the commands of the loop, never before them.

use std::{cell::RefCell, rc::Rc, time::Duration};

use clock::now::now_ns;
use hyper::{Response, StatusCode, body::Bytes};
use serde::{Deserialize, Serialize, de::Error};
use tokio::{task, time::sleep};

use crate::{
    answer::{JSON, as_json},
    handler::Handler,
    refusal::Refusal,
    session::Client,
    token::{Pass, Token},
};

/// The longest body. A second of rows at 1 kHz, some 100 bytes each, takes two chunks.
const BODY_BYTES: usize = 64 * 1024;

/// The longest claim, which anybody may send: a name and some punctuation.
const CLAIM_BYTES: usize = 1024;

/// What to do with a body.
#[derive(Clone, Debug)]
pub(crate) enum Upload {
    /// Begin a session.
    Claim,
    /// Take a chunk of rows.
    Rows {
        /// Number of the chunk, from 0.
        chunk: u64,
        /// The token of its session.
        pass: Pass,
    },
    /// Take the report and end the session.
    End {
        /// The token of its session.
        pass: Pass,
    },
}

impl Upload {
    /// The body's content type.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Claim | Self::End { .. } => JSON,
            Self::Rows { .. } => "text/csv",
        }
    }

    /// The greatest size of the body.
    pub(crate) fn limit(&self) -> usize {
        match self {
            Self::Claim => CLAIM_BYTES,
            Self::Rows { .. } | Self::End { .. } => BODY_BYTES,
        }
    }
}

/// The body of a claim.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Claim {
    client: String,
    /// Whether its rows are to be kept here. A controller that is no page keeps them itself.
    #[serde(default = "keeps")]
    rows: bool,
}

fn keeps() -> bool {
    true
}

impl Claim {
    /// Reads an object. serde would take a list of the fields' values for one, too.
    fn read(body: &[u8]) -> serde_json::Result<Self> {
        if !body.trim_ascii_start().starts_with(b"{") {
            return Err(serde_json::Error::custom("it is no JSON object"));
        }
        serde_json::from_slice(body)
    }
}

/// The answer to a claim.
#[derive(Serialize)]
struct Grant<'a> {
    session: String,
    h_ns: u64,
    late: endpoint::Late,
    /// The law, absent if it is the paper's.
    #[serde(skip_serializing_if = "Option::is_none")]
    law: Option<&'a serde_json::Value>,
    /// The reference, absent if it rests at the page's own r.
    #[serde(skip_serializing_if = "Option::is_none")]
    reference: Option<&'a endpoint::Reference>,
}

/// Runs an upload to its response.
pub(crate) async fn run(
    upload: Upload,
    body: Bytes,
    handler: Rc<RefCell<Handler>>,
) -> Response<Bytes> {
    let done = match upload {
        Upload::Claim => claim(body, &handler).await,
        Upload::Rows { chunk, pass } => rows(chunk, &pass, body, &handler).await,
        Upload::End { pass } => end(&pass, body, &handler).await,
    };
    done.unwrap_or_else(|refusal| {
        handler.borrow_mut().refuse(refusal.kind());
        refusal.response()
    })
}

async fn claim(body: Bytes, handler: &Rc<RefCell<Handler>>) -> Result<Response<Bytes>, Refusal> {
    let claim = Claim::read(&body)?;
    let client = Client::try_new(claim.client)?;
    let token = Token::random()?;
    let session = token.reveal();
    let (number, files) = {
        let mut handler = handler.borrow_mut();
        let number = handler.control.claim(token, client, now_ns())?;
        // An earlier session that fell silent may not have been noticed yet.
        handler.on_end_of(number - 1);
        handler.inbox.welcome();
        handler.filer.close(number - 1);
        (number, claim.rows.then(|| handler.filer.open(number)))
    };
    if let Some(files) = files
        && let Err(problem) = files.wait().await
    {
        handler.borrow_mut().control.withdraw(number);
        return Err(problem.into());
    }
    task::spawn_local(watch(number, Rc::clone(handler)));
    let handler = handler.borrow();
    Ok(as_json(&Grant {
        session,
        h_ns: handler.settings.h.ns(),
        late: handler.settings.late,
        law: handler.law.as_ref(),
        reference: handler.reference.as_ref(),
    }))
}

async fn rows(
    chunk: u64,
    pass: &Pass,
    text: Bytes,
    handler: &Rc<RefCell<Handler>>,
) -> Result<Response<Bytes>, Refusal> {
    let (number, filed) = {
        let mut handler = handler.borrow_mut();
        // Checked again, since reading the body took time.
        let number = handler.control.hear(pass, now_ns())?;
        (number, handler.filer.rows(chunk, text))
    };
    let rows = filed.wait().await?;
    handler.borrow_mut().control.count_rows(number, rows);
    Ok(done())
}

async fn end(
    pass: &Pass,
    json: Bytes,
    handler: &Rc<RefCell<Handler>>,
) -> Result<Response<Bytes>, Refusal> {
    let (number, filed) = {
        let mut handler = handler.borrow_mut();
        if handler.control.has_ended(pass) {
            return Ok(done());
        }
        let number = handler.control.hear(pass, now_ns())?;
        (number, handler.filer.report(json))
    };
    let ending = filed.wait().await?;
    let mut handler = handler.borrow_mut();
    handler.control.end(number, ending);
    handler.on_end_of(number);
    Ok(done())
}

/// Ends a session whose page is silent.
async fn watch(number: u64, handler: Rc<RefCell<Handler>>) {
    loop {
        let left_ns = handler.borrow_mut().control.left_ns(number, now_ns());
        let Some(left_ns) = left_ns else {
            break;
        };
        sleep(Duration::from_nanos(left_ns)).await;
    }
    let handler = handler.borrow();
    handler.on_end_of(number);
    handler.filer.close(number);
}

impl Handler {
    /// Tells the sockets of session `number` and of all earlier ones that it has ended.
    fn on_end_of(&self, number: u64) {
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
