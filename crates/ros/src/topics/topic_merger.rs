//! Merges the messages of several topics in the order in which they were received.
//!
//! A publisher that adds an object on one topic and attaches it on another sends both in an order that matters. Each subscription
//! has a queue of its own; its messages are complete as soon as the middleware's thread has received them.

use std::future::Future;
use std::pin::Pin;

use futures_lite::future;

/// Number of passes over all topics after which messages are returned although further ones keep coming.
const MOST_PASSES: usize = 8;

/// Number of messages that a pass takes from a topic.
const MOST_IN_A_PASS: usize = 128;

/// Time (ns) by which a message that is sent again may be received before the one that follows it.
const LARGEST_STEP_BACK: u64 = 10_000_000_000;

/// The next message of a topic.
pub type Next<'s, T> = Pin<Box<dyn Future<Output = Arrival<T>> + 's>>;

/// A message with the time of its reception.
pub struct Arrival<T> {
    /// Time of reception (ns, system clock).
    pub received: u64,
    pub item: T,
}

/// A topic whose messages are merged with those of others.
pub trait MergedTopic<T> {
    /// Waits for the next message.
    fn next(&self) -> Next<'_, T>;

    /// The next message, if one was received already.
    fn try_next(&self) -> Option<Arrival<T>>;
}

/// Several topics, and the messages that were taken from them.
pub struct TopicMerger<'t, T> {
    topics: Vec<Box<dyn MergedTopic<T> + 't>>,
    /// By topic: the latest time of reception. Messages of one topic stay in their order.
    latest: Vec<u64>,
    waiting: Vec<Arrival<T>>,
}

impl<'t, T> TopicMerger<'t, T> {
    pub fn new(topics: Vec<Box<dyn MergedTopic<T> + 't>>) -> Self {
        Self { latest: vec![0; topics.len()], topics, waiting: Vec::new() }
    }

    /// Waits for messages. Returns all that no message of another topic precedes.
    pub async fn next(&mut self) -> Vec<T> {
        // topics with continuous traffic must not starve the futures beside them
        future::yield_now().await;
        if self.waiting.is_empty() {
            let (topic, arrival) = self.first().await;
            self.add(topic, arrival);
        }
        let mut last = u64::MAX;
        for _ in 0..MOST_PASSES {
            let taken = self.waiting.len();
            self.take_received();
            if self.waiting.len() == taken {
                // what came before any of them would have been found
                last = u64::MAX;
                break;
            }
            last = self.waiting[..taken].iter().map(|arrival| arrival.received).max().unwrap_or(u64::MAX);
        }
        self.take_until(last)
    }

    /// The next message of any topic.
    async fn first(&self) -> (usize, Arrival<T>) {
        let mut first: Pin<Box<dyn Future<Output = (usize, Arrival<T>)> + '_>> = Box::pin(future::pending());
        for (number, topic) in self.topics.iter().enumerate() {
            let next = topic.next();
            first = Box::pin(future::or(first, async move { (number, next.await) }));
        }
        first.await
    }

    /// Takes what was received.
    fn take_received(&mut self) {
        for topic in 0..self.topics.len() {
            for _ in 0..MOST_IN_A_PASS {
                let Some(arrival) = self.topics[topic].try_next() else { break };
                self.add(topic, arrival);
            }
        }
    }

    fn add(&mut self, topic: usize, Arrival { received, item }: Arrival<T>) {
        if received.saturating_add(LARGEST_STEP_BACK) < self.latest[topic] {
            // the system clock was set back
            self.latest.fill(0);
        }
        let latest = &mut self.latest[topic];
        *latest = received.max(*latest);
        self.waiting.push(Arrival { received: *latest, item });
    }

    /// The messages received until then, in this order.
    fn take_until(&mut self, last: u64) -> Vec<T> {
        self.waiting.sort_by_key(|arrival| arrival.received);
        let count = self.waiting.partition_point(|arrival| arrival.received <= last);
        self.waiting.drain(..count).map(|arrival| arrival.item).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::collections::VecDeque;
    use std::rc::Rc;

    use futures_lite::future::block_on;

    use super::*;

    /// Messages that the network has not delivered yet, with their topics, and the queues of the topics.
    struct Network {
        coming: VecDeque<(usize, u64)>,
        queues: Vec<VecDeque<u64>>,
    }

    impl Network {
        fn deliver(&mut self) {
            if let Some((topic, time)) = self.coming.pop_front() {
                self.queues[topic].push_back(time);
            }
        }
    }

    /// A topic during each look at which one more message is received, by any topic.
    struct Topic(usize, Rc<RefCell<Network>>);

    impl MergedTopic<u64> for Topic {
        fn next(&self) -> Next<'_, u64> {
            Box::pin(async {
                match self.try_next() {
                    Some(arrival) => arrival,
                    None => future::pending().await,
                }
            })
        }

        fn try_next(&self) -> Option<Arrival<u64>> {
            let mut network = self.1.borrow_mut();
            let taken = network.queues[self.0].pop_front();
            network.deliver();
            taken.map(|received| Arrival { received, item: received })
        }
    }

    fn merged(messages: &[usize]) -> Vec<u64> {
        let coming: VecDeque<_> = messages.iter().copied().zip(1..).collect();
        let network = Rc::new(RefCell::new(Network { coming, queues: vec![VecDeque::new(); 3] }));
        network.borrow_mut().deliver();
        let topics = (0..3).map(|number| Box::new(Topic(number, Rc::clone(&network))) as Box<_>).collect();
        let mut merger = TopicMerger::new(topics);
        let mut all = Vec::new();
        while all.len() < messages.len() {
            all.extend(block_on(merger.next()));
        }
        all
    }

    #[test]
    fn messages_of_several_topics_keep_the_order_of_their_reception() {
        for number in 0..3_usize.pow(7) {
            let messages: Vec<usize> = (0..7).map(|digit| number / 3_usize.pow(digit) % 3).collect();
            assert_eq!(merged(&messages), (1..=7).collect::<Vec<u64>>(), "{messages:?}");
        }
    }

    #[test]
    fn continuous_traffic_does_not_stop_messages() {
        let messages: Vec<usize> = (0..2000).map(|i| i * i % 3).collect();
        assert_eq!(merged(&messages), (1..=2000).collect::<Vec<u64>>());
    }

    /// A message that was sent again after it was lost.
    #[test]
    fn messages_of_one_topic_stay_in_their_order() {
        let mut merger = TopicMerger::<u64> { topics: Vec::new(), latest: vec![0], waiting: Vec::new() };
        for received in [5, 2, 7] {
            merger.add(0, Arrival { received, item: received });
        }
        assert_eq!(merger.take_until(6), [5, 2]);
        assert_eq!(merger.take_until(u64::MAX), [7]);
    }

    #[test]
    fn a_system_clock_that_is_set_back_changes_no_later_order() {
        let mut merger = TopicMerger::<u64> { topics: Vec::new(), latest: vec![0; 2], waiting: Vec::new() };
        let mut taken = |messages: &[(usize, u64)]| {
            for &(topic, received) in messages {
                merger.add(topic, Arrival { received, item: received });
            }
            merger.take_until(u64::MAX)
        };
        let hour = 3_600_000_000_000;
        assert_eq!(taken(&[(0, hour + 1)]), [hour + 1]);
        assert_eq!(taken(&[(0, 5), (1, 6), (0, 7)]), [5, 6, 7]);
    }
}
