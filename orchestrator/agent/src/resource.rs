//! What the path of a request names, with the methods and the query that go with it.
//!
//! `/health` and `/claim` are not here: they are for those who do not have the token yet.

use std::str::FromStr;

use percent_encoding::percent_decode_str;

use crate::Name;
use crate::refusal::Refusal;

/// What a path names, of those that need the token.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Resource {
    /// The agent's end.
    End,
    /// A run.
    Run(Name),
    /// The list of a run's files.
    Files(Name),
    /// A file of a run.
    File(Name, Name),
    /// A role of a run, by the name it was started under.
    Role(Name, Name),
    /// What a role of a run has looked like.
    Seen(Name, Name),
}

impl Resource {
    /// What can be done with it, as the header `Allow` says it.
    pub(crate) fn methods(&self) -> &'static str {
        match self {
            Resource::Files(_) | Resource::Seen(..) => "GET",
            Resource::End => "POST",
            Resource::Run(_) => "PUT, DELETE",
            Resource::File(..) => "GET, PUT",
            Resource::Role(..) => "GET, POST, DELETE",
        }
    }

    /// The first byte that is asked for: `from=N` of a file's query; nothing else has a query.
    pub(crate) fn from(&self, query: Option<&str>) -> Result<u64, Refusal> {
        let Some(query) = query else {
            return Ok(0);
        };
        query
            .strip_prefix("from=")
            .filter(|_| matches!(self, Resource::File(..)))
            .and_then(|digits| digits.parse().ok())
            .ok_or_else(|| Refusal::Query(excerpt(query)))
    }
}

impl FromStr for Resource {
    type Err = Refusal;

    fn from_str(path: &str) -> Result<Self, Refusal> {
        // Each segment is decoded on its own, so that no `%2F` becomes a slash.
        let name = |segment: &str| -> Result<Name, Refusal> {
            let text = percent_decode_str(segment)
                .decode_utf8()
                .map_err(|_| Refusal::Path(excerpt(path)))?;
            Ok(text.parse()?)
        };
        let segments: Vec<&str> = path.split('/').skip(1).collect();
        match *segments.as_slice() {
            ["end"] => Ok(Resource::End),
            ["run", id] => Ok(Resource::Run(name(id)?)),
            ["run", id, "files"] => Ok(Resource::Files(name(id)?)),
            ["run", id, "file", file] => Ok(Resource::File(name(id)?, name(file)?)),
            ["run", id, "role", role] => Ok(Resource::Role(name(id)?, name(role)?)),
            ["run", id, "role", role, "seen"] => Ok(Resource::Seen(name(id)?, name(role)?)),
            _ => Err(Refusal::Path(excerpt(path))),
        }
    }
}

fn excerpt(text: &str) -> String {
    text.chars().take(40).collect()
}
