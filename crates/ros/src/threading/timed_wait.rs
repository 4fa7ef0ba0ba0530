//! Waits with a timeout, without the timer thread of the async runtime: a thread with high priority must not depend on
//! one without.

use std::future::Future;
use std::pin::pin;
use std::sync::Arc;
use std::task::{Context, Poll, Wake, Waker};
use std::thread::{self, Thread};
use std::time::{Duration, Instant};

struct Sleeper(Thread);

impl Wake for Sleeper {
    fn wake(self: Arc<Self>) {
        self.0.unpark();
    }
}

/// Returns the result of `work`, or `None` after the timeout; the calling thread sleeps meanwhile.
pub fn wait_at_most<F: Future>(time: Duration, work: F) -> Option<F::Output> {
    // a timeout beyond the range of the clock never ends
    let end = Instant::now().checked_add(time);
    let waker = Waker::from(Arc::new(Sleeper(thread::current())));
    let mut context = Context::from_waker(&waker);
    let mut work = pin!(work);
    loop {
        if let Poll::Ready(output) = work.as_mut().poll(&mut context) {
            return Some(output);
        }
        match end.map(|end| end.saturating_duration_since(Instant::now())) {
            None => thread::park(),
            Some(Duration::ZERO) => return None,
            Some(left) => thread::park_timeout(left),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::future::pending;

    use super::*;
    use crate::threading::mailbox;

    #[test]
    fn what_never_comes_is_given_up() {
        let start = Instant::now();
        assert_eq!(wait_at_most(Duration::from_millis(20), pending::<()>()), None);
        assert!(start.elapsed() >= Duration::from_millis(20));
    }

    #[test]
    fn what_is_ready_needs_no_time() {
        assert_eq!(wait_at_most(Duration::ZERO, async { 7 }), Some(7));
    }

    #[test]
    fn what_another_thread_sends_wakes_for_ever() {
        let (send, receive) = mailbox::unbounded();
        let sender = thread::spawn(move || (0..1000).for_each(|number| send.send(number).unwrap()));
        for number in 0..1000 {
            assert_eq!(wait_at_most(Duration::MAX, receive.receive()), Some(Some(number)));
        }
        sender.join().unwrap();
    }
}
