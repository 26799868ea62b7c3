//! A limit of time for one wait after another, of which hardly any meets it.
//!
//! A timer of the runtime's is set when it is first waited for, and again only after it has gone off: a wait that
//! ends in time costs no more than a look at the clock.

use std::{
    future::poll_fn,
    pin::Pin,
    task::{Context, Poll, ready},
};

use tokio::time::{Instant, Sleep, sleep_until};

/// How long a connection waits, for one thing after another.
#[derive(Debug, Default)]
pub struct Patience(Option<Pin<Box<Sleep>>>);

impl Patience {
    /// What `poll` waits for; `None` if it has not come before `until`. Nothing is lost if this is dropped early.
    pub fn before<T>(
        &mut self,
        until: Instant,
        mut poll: impl FnMut(&mut Context<'_>) -> Poll<T>,
    ) -> impl Future<Output = Option<T>> {
        poll_fn(move |context| {
            if let Poll::Ready(came) = poll(context) {
                return Poll::Ready(Some(came));
            }
            self.poll(until, context).map(|()| None)
        })
    }

    fn poll(&mut self, until: Instant, context: &mut Context<'_>) -> Poll<()> {
        let timer = self.0.get_or_insert_with(|| Box::pin(sleep_until(until)));
        if timer.deadline() > until {
            timer.as_mut().reset(until);
        }
        loop {
            ready!(timer.as_mut().poll(context));
            if timer.deadline() >= until {
                return Poll::Ready(());
            }
            timer.as_mut().reset(until);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn each_wait_ends_at_its_own_limit_and_not_at_an_earlier_one() {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_time()
            .build()
            .expect("a runtime");
        runtime.block_on(async {
            let mut patience = Patience::default();
            let start = Instant::now();
            for (ms, comes) in [
                (10_000, true),
                (20, false),
                (60, false),
                (40, false),
                (90, true),
            ] {
                let until = start + Duration::from_millis(ms);
                let came = patience.before(until, |_| {
                    if comes {
                        Poll::Ready(ms)
                    } else {
                        Poll::Pending
                    }
                });
                assert_eq!(came.await, comes.then_some(ms));
                assert!(comes || Instant::now() >= until, "{ms}");
            }
            assert!(start.elapsed() < Duration::from_secs(9));
        });
    }
}
