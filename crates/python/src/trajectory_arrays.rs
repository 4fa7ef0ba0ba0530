//! Conversion of arrays (times, positions, velocities, accelerations) to a trajectory.

use clearance::motion::ContinuousDirection;
use clearance::{Trajectory, TrajectoryPoint};
use clearance_bindings::JointSpace;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{Numbers, Rows, wrong_shape};
use crate::error::error;
use crate::memory::filled;

/// Points of a trajectory, as arguments.
pub struct TrajectoryArrays<'a, 'py> {
    /// Seconds from the start, shape (N,); none for a path without times.
    pub times: Option<&'a Bound<'py, PyAny>>,
    /// Shape (N, n).
    pub positions: &'a Bound<'py, PyAny>,
    pub velocities: Option<&'a Bound<'py, PyAny>>,
    pub accelerations: Option<&'a Bound<'py, PyAny>>,
    pub shortest: bool,
}

impl TrajectoryArrays<'_, '_> {
    /// The trajectory, with fixed positions of the joints outside of the group.
    pub fn trajectory(&self, space: &JointSpace) -> PyResult<Trajectory> {
        if self.accelerations.is_some() && self.velocities.is_none() {
            return Err(PyValueError::new_err(
                "accelerations need velocities: give both, or only velocities, or none of them",
            ));
        }
        let names = space.names();
        let positions = Rows::new(self.positions, "positions", names)?;
        let &[count] = positions.leading() else {
            let form = format!("must be (N, {}): one row for each point", names.len());
            return Err(wrong_shape("positions", &[positions.leading(), &[names.len()]].concat(), &form));
        };
        let rates = |given: Option<&Bound<'_, PyAny>>, what: &str| match given {
            None => filled(Vec::new(), count),
            Some(given) => {
                let rows = Rows::new(given, what, names)?;
                let is_same = rows.leading() == [count];
                let rows = is_same.then(|| (0..count).map(|i| rows.table().row(i).to_vec()).collect());
                rows.ok_or_else(|| PyValueError::new_err(format!("{what} must have the shape of positions")))
            }
        };
        let (velocities, accelerations): (Vec<Vec<f64>>, Vec<Vec<f64>>) =
            (rates(self.velocities, "velocities")?, rates(self.accelerations, "accelerations")?);
        let times = self.times(count)?;
        let points =
            velocities.into_iter().zip(accelerations).enumerate().map(|(i, (velocities, accelerations))| {
                let positions = positions.table().row(i).to_vec();
                TrajectoryPoint { positions, velocities, accelerations, time_from_start: times[i] }
            });
        let points: Vec<_> = points.collect();
        let direction =
            if self.shortest { ContinuousDirection::Shortest } else { ContinuousDirection::AsGiven };
        Trajectory::from_points_with_direction(space.robot(), names, &points, space.rest(), direction)
            .map_err(error)
    }

    fn times(&self, count: usize) -> PyResult<Vec<f64>> {
        let Some(times) = self.times else { return filled(0.0, count) };
        let times = Numbers::new(times, "times")?;
        if times.shape() != [count] {
            let form = format!("must be ({count},): one time for each row of positions");
            return Err(wrong_shape("times", times.shape(), &form));
        }
        check_times(times.values())?;
        Ok(times.values().to_vec())
    }
}

/// Rejects times that do not increase from zero or later. To the library, times that are all zero are no times.
fn check_times(times: &[f64]) -> PyResult<()> {
    let bad =
        |i: usize, why: &str| Err(PyValueError::new_err(format!("times[{i}] is {} s, {why}", times[i])));
    if let Some(i) = times.iter().position(|time| !time.is_finite()) {
        return bad(i, "but times must be finite");
    }
    if times.first().is_some_and(|first| *first < 0.0) {
        return bad(0, "but times are from the start of the trajectory, zero or more");
    }
    match times.windows(2).position(|pair| pair[1] <= pair[0]) {
        Some(i) => bad(i + 1, &format!("which does not come after times[{i}], {} s", times[i])),
        None => Ok(()),
    }
}
