//! Summary lines (counts, times) at the end of the text that `clearance check` and `clearance motion` print.

use super::timing::Timing;

/// Counts of a run over states or motions.
pub struct Summary<'a> {
    pub robot: &'a str,
    /// `state` or `motion`.
    pub item: &'static str,
    pub free: usize,
    pub count: usize,
    pub pairs_checked: usize,
    pub load_seconds: f64,
    pub timing: Option<Timing>,
}

impl Summary<'_> {
    /// One line, and another one about timed passes if there were any.
    pub fn lines(&self) -> impl Iterator<Item = String> {
        let Self { robot, item, free, count, pairs_checked, load_seconds, timing } = self;
        let counts = format!(
            "{robot}: {free} of {count} {item}s free; {pairs_checked} pairs checked; loaded in {load_seconds:.3} s"
        );
        let passes = timing.map(|Timing { passes, us_min, us_median }| {
            format!("{us_min:.3} µs a {item} (best of {passes} passes; median {us_median:.3} µs)")
        });
        std::iter::once(counts).chain(passes)
    }
}
