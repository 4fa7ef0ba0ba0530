//! Measures the CPU time of repeated passes over the same inputs.

use cpu_time::ThreadTime;
use serde::Serialize;

/// Thread CPU time per work item: minimum and median over the passes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Timing {
    pub passes: u32,
    pub us_min: f64,
    pub us_median: f64,
}

/// Runs `pass`, which does `pieces` pieces of work, `passes` times on this thread; `None` for no passes or no work.
#[allow(clippy::cast_precision_loss)] // counts of work fit 52 bits
pub fn measure(passes: u32, pieces: usize, mut pass: impl FnMut()) -> Option<Timing> {
    let mut microseconds: Vec<f64> = (0..passes)
        .map(|_| {
            let start = ThreadTime::now();
            pass();
            start.elapsed().as_secs_f64() * 1e6 / pieces as f64
        })
        .collect();
    microseconds.sort_by(f64::total_cmp);
    (pieces > 0).then_some(())?;
    Some(Timing {
        passes,
        us_min: *microseconds.first()?,
        us_median: *microseconds.get(microseconds.len() / 2)?,
    })
}
