//! Reads points from records, for all formats and messages with point clouds.

use std::sync::Arc;

use clearance_files::ply_format::{ByteOrder, NumberKind, PlyError};
use clearance_geometry::constants::LARGEST_COORDINATE;
use clearance_geometry::math::Extremes;
use clearance_geometry::{PointCloud, PointCloudError};

/// Points of a cloud, not yet enlarged to balls.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CloudPoints {
    /// Coordinates in the frame of the cloud (m); all finite.
    pub points: Vec<[f32; 3]>,
    /// Number of points that were skipped because a coordinate is NaN or infinite: sensors mark missing measurements this way.
    pub dropped: usize,
    /// True if points too far away for the computation are skipped as well.
    pub drops_far: bool,
    /// Largest displacement (m) of a point by rounding to 32-bit floats.
    pub rounding: f64,
    /// Warnings about unusual content, as complete clauses.
    pub remarks: Vec<String>,
}

/// Errors of point cloud reading.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CloudError(pub(super) String);

impl From<String> for CloudError {
    fn from(message: String) -> Self {
        Self(message)
    }
}

impl From<PlyError> for CloudError {
    fn from(error: PlyError) -> Self {
        Self(error.0)
    }
}

/// Location of one coordinate of all points: the coordinate of point `i` starts at byte `first + i * stride`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Column {
    /// Offset (bytes) of the first number.
    pub first: usize,
    /// Distance (bytes) between two numbers.
    pub stride: usize,
    /// Storage type of a number.
    pub kind: NumberKind,
}

/// The coordinates x, y and z of all points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Columns {
    /// The columns of the three coordinates (m).
    pub xyz: [Column; 3],
    /// Byte order of the numbers.
    pub order: ByteOrder,
}

impl CloudPoints {
    /// Adds one point; a point that is not finite is skipped and counted.
    ///
    /// # Errors
    /// If the point is farther than [`LARGEST_COORDINATE`], unless such points are skipped, too.
    #[allow(clippy::cast_possible_truncation)] // what is lost is counted
    pub fn push(&mut self, point: [f64; 3]) -> Result<(), CloudError> {
        let is_far = point.iter().any(|c| c.abs() > LARGEST_COORDINATE);
        if !point.iter().all(|c| c.is_finite()) || (is_far && self.drops_far) {
            self.dropped += 1;
            return Ok(());
        }
        if is_far {
            let index = self.points.len() + self.dropped;
            return Err(CloudError(format!(
                "point {index} at {point:?} is farther than {LARGEST_COORDINATE:e} m"
            )));
        }
        let rounded = point.map(|c| c as f32);
        let lost = [0, 1, 2].map(|k| point[k] - f64::from(rounded[k]));
        if lost != [0.0; 3] {
            self.rounding = self.rounding.greater(lost.iter().map(|l| l * l).sum::<f64>().sqrt());
        }
        self.points.push(rounded);
        Ok(())
    }

    /// Adds `count` points.
    ///
    /// # Errors
    /// If the bytes are too few for them, detected before any allocation; and as for [`Self::push`].
    pub fn read(&mut self, bytes: &[u8], columns: &Columns, count: usize) -> Result<(), CloudError> {
        let end = |c: &Column| {
            let last = count.checked_sub(1).map_or(Some(0), |last| last.checked_mul(c.stride))?;
            last.checked_add(c.first)?.checked_add(c.kind.size())
        };
        let fits = |c: &Column| end(c).is_some_and(|end| end <= bytes.len());
        if count > 0 && !columns.xyz.iter().all(fits) {
            return Err(CloudError(format!("{} bytes are too few for {count} points", bytes.len())));
        }
        self.points.reserve(count);
        for i in 0..count {
            let number = |c: Column| c.kind.read(&bytes[c.first + i * c.stride..], columns.order);
            let [Some(x), Some(y), Some(z)] = columns.xyz.map(number) else {
                return Err(CloudError(format!("the bytes end in point {i} of {count}")));
            };
            self.push([x, y, z])?;
        }
        Ok(())
    }

    /// The cloud of balls of this `radius` (m) around the points, enlarged by the rounding displacement; `None` without points.
    pub fn cloud(self, radius: f64) -> Result<Option<Arc<PointCloud>>, PointCloudError> {
        if self.points.is_empty() {
            return Ok(None);
        }
        PointCloud::new(self.points, radius + self.rounding).map(|cloud| Some(Arc::new(cloud)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_without_numbers_are_counted_and_far_ones_named() {
        let mut cloud = CloudPoints::default();
        cloud.push([1.0, 2.0, 3.0]).unwrap();
        cloud.push([f64::NAN, 2.0, 3.0]).unwrap();
        cloud.push([0.0, f64::INFINITY, 3.0]).unwrap();
        assert_eq!((cloud.points.len(), cloud.dropped, cloud.rounding), (1, 2, 0.0));
        assert!(cloud.push([0.0, 0.0, 1e9]).unwrap_err().to_string().contains("point 3"));
    }

    #[test]
    fn rounding_widens_the_balls() {
        let mut cloud = CloudPoints::default();
        let point = [0.1, 1000.3, -7.7];
        cloud.push(point).unwrap();
        let cloud = cloud.cloud(0.01).unwrap().unwrap();
        let moved: f64 = cloud.points()[0].iter().zip(point).map(|(&r, p)| (f64::from(r) - p).powi(2)).sum();
        assert!(moved > 0.0 && cloud.radius() >= 0.01 + moved.sqrt());
    }

    #[test]
    fn counts_that_the_bytes_do_not_hold_are_rejected_first() {
        let column = |first| Column { first, stride: 12, kind: NumberKind::F32 };
        let columns = Columns { xyz: [column(0), column(4), column(8)], order: ByteOrder::Little };
        for count in [2, usize::MAX / 12, usize::MAX] {
            let error = CloudPoints::default().read(&[0; 23], &columns, count).unwrap_err();
            assert!(error.to_string().contains("23 bytes"), "{error}");
        }
        let mut cloud = CloudPoints::default();
        cloud.read(&[0; 24], &columns, 2).unwrap();
        cloud.read(&[], &columns, 0).unwrap();
        assert_eq!(cloud.points, [[0.0; 3]; 2]);
    }
}
