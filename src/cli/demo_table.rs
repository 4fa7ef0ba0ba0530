//! Live table of the demo: shows the results of the node in the terminal.

use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use clearance::checker::PairKind;
use clearance::monitor::Evaluation;
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Refresh period of the table.
const REFRESH: Duration = Duration::from_millis(100);

/// The last evaluation, and the number of evaluations.
#[derive(Clone, Default)]
pub struct Latest(Arc<Mutex<Seen>>);

#[derive(Clone, Default)]
struct Seen {
    evaluation: Option<Evaluation>,
    /// Number of checks since the start, and their total time.
    checks: u32,
    compute_time: Duration,
}

impl Latest {
    pub fn note(&self, evaluation: &Evaluation) {
        let mut seen = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let stamp = |evaluation: &Evaluation| evaluation.stamp;
        if let Some(checked_state) = &evaluation.checked_state
            && seen.evaluation.as_ref().and_then(stamp) != evaluation.stamp
        {
            seen.checks += 1;
            seen.compute_time += checked_state.compute_time;
        }
        seen.evaluation = Some(evaluation.clone());
    }

    fn read(&self) -> Seen {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// Content of the table at one time.
struct Row {
    status: &'static str,
    /// Reason for the status UNKNOWN.
    reason: String,
    nearest: String,
    distance: String,
    /// By kind of pairs: the least distance and its pair.
    by_kind: [String; 2],
    /// Joint states evaluated per second.
    rate: f64,
    /// Mean time of a check (µs).
    microseconds: f64,
    pairs: usize,
}

impl Row {
    /// Difference between `before` and `now`, `interval` apart.
    fn new(before: &Seen, now: &Seen, interval: Duration) -> Self {
        let checks = f64::from(now.checks.wrapping_sub(before.checks));
        let compute_time = now.compute_time.saturating_sub(before.compute_time);
        let evaluation = now.evaluation.as_ref();
        let revision = evaluation.and_then(|j| j.revision.as_ref());
        let nearest = evaluation.and_then(|j| j.checked_state.as_ref()?.report.nearest);
        let (nearest, distance) = match (nearest, revision) {
            (Some(nearest), Some(revision)) => {
                let name = |body| revision.checker.body_name(body);
                let pair = format!("{} and {}", name(nearest.a), name(nearest.b));
                (pair, format!("{:.4} m", nearest.distance))
            }
            _ => ("-".to_owned(), "-".to_owned()),
        };
        let of_kind = |kind| evaluation.and_then(|j| j.least_distance(kind));
        Self {
            by_kind: PairKind::ALL.map(|kind| of_kind(kind).unwrap_or_else(|| "-".to_owned())),
            status: evaluation.map_or("UNKNOWN", |j| j.status.word()),
            reason: (evaluation.and_then(|j| j.status.reason()))
                .map_or_else(String::new, ToString::to_string),
            nearest,
            distance,
            rate: checks / interval.as_secs_f64().max(1e-3),
            microseconds: compute_time.as_secs_f64() * 1e6 / checks.max(1.0),
            pairs: revision.map_or(0, |r| r.checker.pairs().len()),
        }
    }
}

/// Thread that draws the table.
pub struct Table(JoinHandle<()>);

impl Table {
    pub fn start(latest: Latest, ended: Arc<AtomicBool>, domain: u16) -> Self {
        Self(thread::spawn(move || {
            let hints = hints(domain);
            if std::io::stdout().is_terminal() {
                let _undisturbed = UndisturbedOutput::on_terminal();
                draw(&latest, &ended, &hints);
            } else {
                print_lines(&latest, &ended, &hints);
            }
        }))
    }

    /// Waits until the last line is printed.
    pub fn finish(self) {
        // a panic of the table's thread is ignored
        let _ = self.0.join();
    }
}

/// Terminal settings that keep the table whole on Ctrl-C, during its lifetime: control keys are not echoed, since `^C` at the end of a line
/// would start a new line below the table, and do not discard output that the terminal has not shown yet.
struct UndisturbedOutput {
    #[cfg(unix)]
    before: Option<nix::sys::termios::Termios>,
}

#[cfg(unix)]
impl UndisturbedOutput {
    fn on_terminal() -> Self {
        use nix::sys::termios::{LocalFlags, tcgetattr};
        let before = tcgetattr(std::io::stdout()).ok();
        if let Some(before) = &before {
            let mut undisturbed = before.clone();
            undisturbed.local_flags.remove(LocalFlags::ECHOCTL);
            undisturbed.local_flags.insert(LocalFlags::NOFLSH);
            Self::set(&undisturbed);
        }
        Self { before }
    }

    /// Only in the foreground: in the background, the change would stop the process (`SIGTTOU`). Without the change, only the display
    /// suffers.
    fn set(settings: &nix::sys::termios::Termios) {
        use nix::sys::termios::{SetArg, tcsetattr};
        if nix::unistd::tcgetpgrp(std::io::stdout()) == Ok(nix::unistd::getpgrp()) {
            let _ = tcsetattr(std::io::stdout(), SetArg::TCSANOW, settings);
        }
    }
}

#[cfg(unix)]
impl Drop for UndisturbedOutput {
    fn drop(&mut self) {
        if let Some(before) = &self.before {
            Self::set(before);
        }
    }
}

#[cfg(not(unix))]
impl UndisturbedOutput {
    fn on_terminal() -> Self {
        Self {}
    }
}

fn hints(domain: u16) -> Vec<String> {
    let mut hints = vec![
        "The demo arm in its world, on this machine only. From another terminal:".to_owned(),
        "  ros2 topic echo /clearance/is_free        true only when proven".to_owned(),
        "  ros2 topic echo /clearance/distance       the least distance, in metres".to_owned(),
        "  ros2 topic echo /clearance/state          everything (needs clearance_msgs)".to_owned(),
        "  rviz2                                     /clearance/markers, fixed frame base".to_owned(),
        "In a web browser: clearance --view. Your own robot: clearance node --urdf robot.urdf. Ctrl-C ends."
            .to_owned(),
    ];
    if domain != 0 {
        hints.push(format!("ROS_DOMAIN_ID is {domain}; it must be so there too."));
    }
    hints
}

/// Sliding window over the last second, from which the rates are computed.
struct Window {
    begin: (Instant, Seen),
    next: (Instant, Seen),
}

impl Window {
    const LENGTH: Duration = Duration::from_secs(1);

    fn new(seen: Seen) -> Self {
        let now = (Instant::now(), seen);
        Self { begin: now.clone(), next: now }
    }

    fn row(&mut self, seen: &Seen) -> Row {
        if self.next.0.elapsed() > Self::LENGTH {
            self.begin = std::mem::replace(&mut self.next, (Instant::now(), seen.clone()));
        }
        Row::new(&self.begin.1, seen, self.begin.0.elapsed())
    }
}

fn draw(latest: &Latest, ended: &AtomicBool, hints: &[String]) {
    let table = MultiProgress::with_draw_target(ProgressDrawTarget::stdout());
    let labelled = |label: &'static str| {
        let line = table.add(ProgressBar::no_length());
        line.set_style(style("{prefix:>9.dim}  {msg}"));
        line.with_prefix(label)
    };
    for hint in hints {
        // a terminal that cannot be written to must not end the demo
        drop(table.println(hint));
    }
    drop(table.println(""));
    let labels = ["status", "nearest", "distance", "self", "world", "rate", "a check"];
    let lines = labels.map(labelled);
    let [status, nearest, distance, of_self, of_world, rate, check] = &lines;
    let mut window = Window::new(latest.read());
    while !ended.load(Ordering::Relaxed) && !clearance_ros::is_ending() {
        let row = window.row(&latest.read());
        let colour = match row.status {
            "FREE" => "green",
            "COLLIDING" => "red",
            _ => "yellow",
        };
        status.set_style(style(&format!("{{prefix:>9.dim}}  {{msg:.{colour}.bold}}")));
        status.set_message(format!("{} {}", row.status, row.reason).trim_end().to_owned());
        nearest.set_message(row.nearest);
        distance.set_message(row.distance);
        for (line, text) in [of_self, of_world].into_iter().zip(row.by_kind) {
            line.set_message(text);
        }
        rate.set_message(format!("{:.0} joint states per second", row.rate));
        check.set_message(format!("{:.0} µs, {} pairs", row.microseconds, row.pairs));
        thread::sleep(REFRESH);
    }
    // the last state stays visible
    table.set_draw_target(ProgressDrawTarget::hidden());
    for line in &lines {
        line.abandon();
    }
    println!();
}

fn style(template: &str) -> ProgressStyle {
    // the templates are constants in this file; an invalid one would show the plain message
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_spinner())
}

fn print_lines(latest: &Latest, ended: &AtomicBool, hints: &[String]) {
    let mut out = std::io::stdout();
    let mut print = |line: &str| {
        if writeln!(out, "{line}").and_then(|()| out.flush()).is_err() {
            // the reader of the output has gone
            std::process::exit(0);
        }
    };
    for hint in hints {
        print(hint);
    }
    let mut before = (Instant::now(), latest.read());
    while !ended.load(Ordering::Relaxed) {
        thread::sleep(REFRESH);
        if before.0.elapsed() < Duration::from_secs(1) {
            continue;
        }
        let seen = latest.read();
        let row = Row::new(&before.1, &seen, before.0.elapsed());
        before = (Instant::now(), seen);
        print(&format!(
            "{:9} nearest: {}, {}; {:.0} joint states per second, {:.0} µs a check, {} pairs; self: {}; world: {} {}",
            row.status,
            row.nearest,
            row.distance,
            row.rate,
            row.microseconds,
            row.pairs,
            row.by_kind[0],
            row.by_kind[1],
            row.reason
        ));
    }
}
