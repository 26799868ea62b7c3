//! HTTP/1 for both ends of the loop, as bytes: what is read is a beginning of what will have come, and is read again
//! when there is more.
//!
//! * [`request`]: the head of a request, read strictly.
//! * [`body`]: a body, taken from its connection's bytes as they arrive.
//! * [`answer`]: a whole answer, read.
//! * [`written`]: an answer as it is sent.
//! * [`lines`], [`framing`]: what both kinds of heads have, and where what they begin ends.
//!
//! There is no socket, clock or runtime here. What a request asks for is judged by the plant, and the controller
//! writes its own. What a message passes through is `inline`, so that each end compiles it with its own.

pub mod answer;
pub mod body;
pub mod framing;
pub mod lines;
pub mod request;
pub mod written;

pub use hyper_http::StatusCode;
