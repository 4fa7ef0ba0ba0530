//! Runs the parts of the node, each on its own thread; they start and end together.

use std::collections::HashSet;
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use futures_lite::{Future, future};
use smol::channel::{Receiver, Sender};

use crate::monitor_events::monitor_event::MonitorEvent;
use crate::scene::loader_command::LoaderCommand;
use crate::threading::mailbox;

/// Time limit for all parts to end, after the first one has ended or the node was requested to end. A part that needs
/// longer, such as the loader with a large model, is abandoned.
const TIME_TO_END: Duration = Duration::from_millis(700);

/// Part of the node: its name and its work.
pub struct Part {
    pub name: &'static str,
    pub work: Box<dyn FnOnce() + Send>,
}

impl Part {
    pub fn new(name: &'static str, work: impl FnOnce() + Send + 'static) -> Self {
        Self { name, work: Box::new(work) }
    }
}

/// Requests the end of every part.
#[derive(Clone)]
pub struct StopSignal {
    pub events: mailbox::Sender<MonitorEvent>,
    pub commands: Sender<LoaderCommand>,
    /// Parts that wait for other things also wait until this channel is closed.
    pub stop: Sender<()>,
}

impl StopSignal {
    pub fn send(&self) {
        // an error means that this part has ended already
        let _ = self.events.send(MonitorEvent::Stop);
        self.commands.close();
        self.stop.close();
    }
}

/// When one part ends for any reason, all parts end: a node with only half of its parts would still look alive.
struct StopsOthers {
    end: StopSignal,
    name: &'static str,
    has_ended: mpsc::Sender<&'static str>,
}

impl Drop for StopsOthers {
    fn drop(&mut self) {
        self.end.send();
        // an error means that this part was abandoned
        let _ = self.has_ended.send(self.name);
    }
}

/// Runs all parts until they have ended or are abandoned. Returns an error with the name of the part that failed, if
/// any.
pub fn run_together(parts: Vec<Part>, end: &StopSignal) -> Result<(), String> {
    let mut running = Vec::new();
    let mut failed = None;
    let (has_ended, ended) = mpsc::channel();
    for Part { name, work } in parts {
        let guard = StopsOthers { end: end.clone(), name, has_ended: has_ended.clone() };
        let thread = thread::Builder::new().name(name.to_owned()).spawn(move || {
            let _guard = guard;
            work();
        });
        match thread {
            Ok(thread) => running.push((name, thread)),
            Err(error) => failed = Some(format!("the {name} thread did not start: {error}")),
        }
    }
    drop(has_ended);
    let at_their_end = await_end(&ended, TIME_TO_END);
    for (name, thread) in running {
        // a thread that has reported its end is about to finish, even if it has not finished yet
        if !at_their_end.contains(name) && !thread.is_finished() {
            log::warn!("the {name} thread is still busy and is abandoned");
        } else if thread.join().is_err() {
            failed = Some(format!("the {name} thread failed"));
        }
    }
    failed.map_or(Ok(()), Err)
}

/// Waits for the first end of a part without a time limit, and for the other parts with one. Returns the names of the
/// parts that have ended.
fn await_end(ended: &mpsc::Receiver<&'static str>, time_to_end: Duration) -> HashSet<&'static str> {
    let mut names: HashSet<_> = ended.recv().into_iter().collect();
    let deadline = Instant::now() + time_to_end;
    while let Ok(name) = ended.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
        names.insert(name);
    }
    names
}

/// Runs `work` until the stop channel is closed.
pub async fn until<T>(stopped: &Receiver<()>, work: impl Future<Output = T>) {
    let stop = async {
        // nothing is ever sent: only the closing of the channel matters
        let _ = stopped.recv().await;
    };
    let work = async {
        work.await;
    };
    future::or(stop, work).await;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_that_does_not_end_holds_up_no_other() {
        let (events, _events_in) = mailbox::unbounded();
        let (commands, _orders_in) = smol::channel::unbounded();
        let (stop, stopped) = smol::channel::bounded(1);
        let end = StopSignal { events, commands, stop };
        let (release, released) = mpsc::channel::<()>();
        let parts = vec![
            Part::new("stuck", move || {
                let _ = released.recv();
            }),
            Part::new("obedient", move || smol::block_on(until(&stopped, future::pending::<()>()))),
        ];
        end.send();
        assert_eq!(run_together(parts, &end), Ok(()));
        release.send(()).expect("the stuck part was abandoned, not ended");
    }

    #[test]
    fn a_part_that_fails_is_named_and_ends_the_others() {
        // repeated, as a failing thread reports its end shortly before it has finished
        for _ in 0..200 {
            assert_eq!(run_with_a_failing_part(), Err("the broken thread failed".to_owned()));
        }
    }

    fn run_with_a_failing_part() -> Result<(), String> {
        let (events, _events_in) = mailbox::unbounded();
        let (commands, _orders_in) = smol::channel::unbounded();
        let (stop, stopped) = smol::channel::bounded(1);
        let end = StopSignal { events, commands, stop };
        let parts = vec![
            // without the message of a panic on stderr
            Part::new("broken", || std::panic::resume_unwind(Box::new("as planned"))),
            Part::new("obedient", move || smol::block_on(until(&stopped, future::pending::<()>()))),
        ];
        run_together(parts, &end)
    }
}
