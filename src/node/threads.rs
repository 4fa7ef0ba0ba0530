//! The parts of the node, each on a thread, beginning and ending together.

use std::thread;

use futures_lite::{Future, future};
use smol::channel::{Receiver, Sender};

use super::loader::Order;
use super::mailbox;
use super::monitor_loop::Event;

/// A part of the node: its name and its work.
pub struct Part {
    pub name: &'static str,
    pub work: Box<dyn FnOnce() + Send>,
}

impl Part {
    pub fn new(name: &'static str, work: impl FnOnce() + Send + 'static) -> Self {
        Self { name, work: Box::new(work) }
    }
}

/// Tells every part to end.
#[derive(Clone)]
pub struct End {
    pub events: mailbox::Sender<Event>,
    pub orders: Sender<Order>,
    /// Parts that wait for other things wait for this channel to be closed too.
    pub stop: Sender<()>,
}

impl End {
    pub fn tell(&self) {
        // a closed channel belongs to a part that has ended already
        let _ = self.events.send(Event::Stop);
        self.orders.close();
        self.stop.close();
    }
}

/// When one part ends, for whatever reason, all do: a node that does half its work looks alive.
struct EndsOthers(End);

impl Drop for EndsOthers {
    fn drop(&mut self) {
        self.0.tell();
    }
}

/// Runs all parts until they have ended. Says which one failed, if one did.
pub fn run_together(parts: Vec<Part>, end: &End) -> Result<(), String> {
    let mut running = Vec::new();
    let mut failed = None;
    for Part { name, work } in parts {
        let guard = EndsOthers(end.clone());
        let thread = thread::Builder::new().name(name.to_owned()).spawn(move || {
            let _guard = guard;
            work();
        });
        match thread {
            Ok(thread) => running.push((name, thread)),
            Err(error) => failed = Some(format!("the {name} thread did not start: {error}")),
        }
    }
    for (name, thread) in running {
        if thread.join().is_err() {
            failed = Some(format!("the {name} thread failed"));
        }
    }
    failed.map_or(Ok(()), Err)
}

/// Works until told to stop.
pub async fn until<T>(stopped: &Receiver<()>, work: impl Future<Output = T>) {
    let stop = async {
        // nothing is ever sent: closing the channel is the sign
        let _ = stopped.recv().await;
    };
    let work = async {
        work.await;
    };
    future::or(stop, work).await;
}
