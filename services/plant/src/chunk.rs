//! The order of a page's chunks of rows: each is taken once, in its turn.
//!
//! A page that received no answer sends its chunk again, since it cannot know whether it had arrived.
//! So chunks are numbered, and one that was taken before is acknowledged again and otherwise ignored.

/// Most rows of one session: a day at 1 kHz, or some 9 GB on disk.
const MAX_ROWS: u64 = 86_400_000;

/// The chunks and rows taken from one session.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Chunks {
    next: u64,
    rows: u64,
}

/// What to do with a chunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turn {
    /// It is the next one.
    New,
    /// It was already taken.
    Again,
}

/// Why a chunk is not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum OutOfTurn {
    #[error("chunk {chunk} is out of turn; send chunk {next} next")]
    Other { chunk: u64, next: u64 },
    #[error(
        "chunk {chunk} would make more than {MAX_ROWS} rows; end this session and begin another"
    )]
    Full { chunk: u64 },
}

impl Chunks {
    /// Whether this chunk is the next one or was already taken; a later one is rejected.
    pub(crate) fn turn(self, chunk: u64) -> Result<Turn, OutOfTurn> {
        let Self { next, .. } = self;
        match chunk.cmp(&next) {
            std::cmp::Ordering::Less => Ok(Turn::Again),
            std::cmp::Ordering::Equal => Ok(Turn::New),
            std::cmp::Ordering::Greater => Err(OutOfTurn::Other { chunk, next }),
        }
    }

    /// Takes the next chunk, with `rows` rows, if there is room.
    pub(crate) fn take(&mut self, rows: u64) -> Result<(), OutOfTurn> {
        let total = self.rows.saturating_add(rows);
        if total > MAX_ROWS {
            return Err(OutOfTurn::Full { chunk: self.next });
        }
        self.next += 1;
        self.rows = total;
        Ok(())
    }

    /// Number of rows accepted.
    pub(crate) fn rows(self) -> u64 {
        self.rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_chunk_is_taken_once_and_in_order() {
        let mut chunks = Chunks::default();
        for n in 0..5 {
            for chunk in 0..10 {
                let expected = match chunk {
                    _ if chunk < n => Ok(Turn::Again),
                    _ if chunk == n => Ok(Turn::New),
                    _ => Err(OutOfTurn::Other { chunk, next: n }),
                };
                assert_eq!(chunks.turn(chunk), expected);
            }
            assert_eq!(chunks.take(100), Ok(()));
        }
        assert_eq!(chunks.rows(), 500);
    }

    #[test]
    fn a_session_has_so_many_rows_and_no_more() {
        let mut chunks = Chunks::default();
        assert_eq!(chunks.take(MAX_ROWS), Ok(()));
        assert_eq!(chunks.take(0), Ok(()));
        assert_eq!(chunks.take(1), Err(OutOfTurn::Full { chunk: 2 }));
        assert_eq!((chunks.rows(), chunks.turn(2)), (MAX_ROWS, Ok(Turn::New)));
    }
}
