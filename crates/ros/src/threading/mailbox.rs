//! Queue between threads of different priorities. A thread that finds the queue locked sleeps. It never waits by
//! yielding or spinning: with realtime priority it would keep the processor from the thread that holds the lock
//! ([`crate::threading::thread_priority`]).

use std::collections::VecDeque;
use std::fmt;
use std::future::poll_fn;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Poll, Waker};

/// Creates a queue with a maximum number of items.
pub fn bounded<T>(capacity: usize) -> (Sender<T>, Receiver<T>) {
    let state = State { waiting: VecDeque::new(), capacity, senders: 1, is_read: true, reader: None };
    let shared = Arc::new(Mutex::new(state));
    (Sender(Arc::clone(&shared)), Receiver(shared))
}

/// Creates a queue without a maximum number of items.
pub fn unbounded<T>() -> (Sender<T>, Receiver<T>) {
    bounded(usize::MAX)
}

struct State<T> {
    waiting: VecDeque<T>,
    capacity: usize,
    senders: usize,
    is_read: bool,
    reader: Option<Waker>,
}

type Shared<T> = Arc<Mutex<State<T>>>;

fn lock<T>(shared: &Shared<T>) -> MutexGuard<'_, State<T>> {
    // the state is valid between any two statements, so a poisoned lock is safe to use
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Error of an item that was not queued.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SendError {
    Full,
    /// The receiver was dropped.
    Closed,
}

/// Sending end of a queue.
pub struct Sender<T>(Shared<T>);

impl<T> Sender<T> {
    /// Queues an item. Never waits for free space.
    pub fn send(&self, item: T) -> Result<(), SendError> {
        let mut state = lock(&self.0);
        if !state.is_read {
            return Err(SendError::Closed);
        }
        if state.waiting.len() >= state.capacity {
            return Err(SendError::Full);
        }
        state.waiting.push_back(item);
        let reader = state.reader.take();
        drop(state);
        if let Some(reader) = reader {
            reader.wake();
        }
        Ok(())
    }
}

impl<T> fmt::Debug for Sender<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Sender").finish_non_exhaustive()
    }
}

impl<T> Clone for Sender<T> {
    fn clone(&self) -> Self {
        lock(&self.0).senders += 1;
        Self(Arc::clone(&self.0))
    }
}

impl<T> Drop for Sender<T> {
    fn drop(&mut self) {
        let mut state = lock(&self.0);
        state.senders -= 1;
        let reader = state.reader.take().filter(|_| state.senders == 0);
        drop(state);
        if let Some(reader) = reader {
            reader.wake();
        }
    }
}

/// Receiving end of a queue, for a single task.
pub struct Receiver<T>(Shared<T>);

impl<T> fmt::Debug for Receiver<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Receiver").finish_non_exhaustive()
    }
}

impl<T> Receiver<T> {
    /// Waits for the next item; `None` when the queue is empty and all senders were dropped.
    pub async fn receive(&self) -> Option<T> {
        poll_fn(|context| {
            let mut state = lock(&self.0);
            match state.waiting.pop_front() {
                Some(item) => Poll::Ready(Some(item)),
                None if state.senders == 0 => Poll::Ready(None),
                None => {
                    state.reader = Some(context.waker().clone());
                    Poll::Pending
                }
            }
        })
        .await
    }
}

impl<T> Drop for Receiver<T> {
    /// Drops the unread items: a sender that waits for the response to one of them is informed that there is none.
    fn drop(&mut self) {
        let mut state = lock(&self.0);
        state.is_read = false;
        let unread = std::mem::take(&mut state.waiting);
        drop(state);
        drop(unread);
    }
}

#[cfg(test)]
mod tests {
    use std::thread;

    use futures_lite::future::{block_on, or, ready};

    use super::*;

    #[test]
    fn items_of_many_threads_come_each_in_its_order() {
        let (sender, receiver) = unbounded();
        let senders: Vec<_> = (0..4)
            .map(|thread| {
                let sender = sender.clone();
                thread::spawn(move || (0..2500).for_each(|number| sender.send((thread, number)).unwrap()))
            })
            .collect();
        drop(sender);
        let mut next = [0; 4];
        while let Some((thread, number)) = block_on(receiver.receive()) {
            assert_eq!(number, next[thread]);
            next[thread] += 1;
        }
        assert_eq!(next, [2500; 4]);
        for sender in senders {
            sender.join().unwrap();
        }
    }

    #[test]
    fn a_full_queue_takes_nothing_and_nobody_waits() {
        let (sender, receiver) = bounded(1);
        assert_eq!((sender.send(1), sender.send(2)), (Ok(()), Err(SendError::Full)));
        assert_eq!(block_on(receiver.receive()), Some(1));
        assert_eq!(block_on(or(receiver.receive(), ready(None))), None);
        assert_eq!(sender.send(3), Ok(()));
    }

    #[test]
    fn what_was_not_read_is_dropped_with_its_reader() {
        let (sender, receiver) = unbounded();
        let answer = Arc::new(());
        sender.send(Arc::clone(&answer)).unwrap();
        drop(receiver);
        assert_eq!(Arc::strong_count(&answer), 1);
        assert_eq!(sender.send(answer), Err(SendError::Closed));
    }
}
