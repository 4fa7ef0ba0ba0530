//! Threads of different priorities: queues and waits that never spin or yield.

pub mod mailbox; // queue between threads of different priorities
pub mod thread_priority; // optional realtime priority
pub mod timed_wait; // wait for a future with a timeout
