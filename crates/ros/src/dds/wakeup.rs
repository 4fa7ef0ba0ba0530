//! Wakes the node's executor only for endpoints with data, and raises the thread priority while polling.
//!
//! A task of the node waits for two dozen endpoints at once. Without this, each wake-up would poll all of them. Polling
//! has a cost beside them, above all the change of thread priority; with this it is paid only once for each message.

use std::future::{Future, poll_fn};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, Wake, Waker};

use crate::dds::lock::lock;
use crate::threading::thread_priority::ThreadPriority;

/// Waker that also records whether it was woken.
struct Wakeup {
    is_woken: AtomicBool,
    waiting: Mutex<Option<Waker>>,
}

impl Wake for Wakeup {
    fn wake(self: Arc<Self>) {
        self.is_woken.store(true, Ordering::Release);
        if let Some(waiting) = lock(&self.waiting).take() {
            waiting.wake();
        }
    }
}

/// Waits for `work`. Its thread has the given priority during each poll.
pub fn wait<F: Future>(priority: ThreadPriority, work: F) -> impl Future<Output = F::Output> {
    let wakeup = Arc::new(Wakeup { is_woken: AtomicBool::new(true), waiting: Mutex::default() });
    let waker = Waker::from(Arc::clone(&wakeup));
    let mut work = Box::pin(work);
    poll_fn(move |context| {
        // order matters: a wake-up between the two statements makes this thread poll once more
        *lock(&wakeup.waiting) = Some(context.waker().clone());
        if !wakeup.is_woken.swap(false, Ordering::Acquire) {
            return Poll::Pending;
        }
        let _lent = priority.lend();
        work.as_mut().poll(&mut Context::from_waker(&waker))
    })
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use futures_lite::future::{block_on, yield_now, zip};

    use super::*;
    use crate::threading::mailbox;

    #[test]
    fn only_what_was_woken_is_polled() {
        let polls = Cell::new(0);
        let (ring, rung) = mailbox::bounded(1);
        let counted = poll_fn({
            let mut received = Box::pin(rung.receive());
            let polls = &polls;
            move |context| {
                polls.set(polls.get() + 1);
                received.as_mut().poll(context)
            }
        });
        let others = async {
            for _ in 0..10 {
                yield_now().await;
            }
            ring.send(7).unwrap();
        };
        let (received, ()) = block_on(zip(wait(ThreadPriority::Normal, counted), others));
        assert_eq!(received, Some(7));
        assert_eq!(polls.get(), 2);
    }

    #[test]
    fn what_is_woken_on_another_thread_is_not_missed() {
        let (ring, rung) = mailbox::unbounded();
        let ringer = std::thread::spawn(move || (0..10_000).for_each(|number| ring.send(number).unwrap()));
        for number in 0..10_000 {
            assert_eq!(block_on(wait(ThreadPriority::Normal, rung.receive())), Some(number));
        }
        ringer.join().unwrap();
    }
}
