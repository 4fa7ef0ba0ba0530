//! Points of a cloud, read from the records of any format or message: invalid ones are skipped and counted.

use std::sync::Arc;

use clearance_files::ply_format::{ByteOrder, NumberKind, PlyError};
use clearance_geometry::constants::LARGEST_COORDINATE;
use clearance_geometry::math::Extremes;
use clearance_geometry::{PointCloud, PointCloudError};

/// Distance (m) from the origin of a frame beyond which 32-bit floats are coarser than 0.03 mm.
const FAR: f64 = 500.0;

/// Largest coordinate (m) at which a point means "no return": many drivers write zeros there.
const AT_ORIGIN: f64 = 1e-6;

/// Whether a point is at the origin of the cloud's frame, the position of the sensor.
#[must_use]
pub fn is_at_origin(point: &[f64; 3]) -> bool {
    point.iter().all(|coordinate| coordinate.abs() <= AT_ORIGIN)
}

/// Points of a cloud, not yet enlarged to balls.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CloudPoints {
    /// Coordinates (m), relative to `origin`; all finite.
    pub points: Vec<[f32; 3]>,
    /// Position in the frame of the cloud (m) that the points are relative to. Zero, unless `moves_origin`.
    pub origin: [f64; 3],
    /// True if `origin` may be moved to points that are far from that of the frame, where 32-bit floats are coarse, and points at the
    /// frame's origin are left to [`Self::take_origin_points`].
    is_sensed: bool,
    /// Number of points at the origin of the frame.
    at_origin: usize,
    /// The first of them, and the number of points before it.
    first_at_origin: ([f64; 3], usize),
    /// Number of points that were skipped because a coordinate is NaN or infinite: sensors mark missing measurements this way.
    pub dropped: usize,
    /// True if points too far away for the computation are skipped as well.
    drops_far: bool,
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
    /// For the points of a sensor's message: what is too far away is skipped, and the origin may move.
    #[must_use]
    pub fn of_sensor() -> Self {
        Self { drops_far: true, is_sensed: true, ..Self::default() }
    }

    /// Adds one point; a point that is not finite is skipped and counted.
    ///
    /// # Errors
    /// If the point is farther than [`LARGEST_COORDINATE`], unless such points are skipped, too.
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
        if self.is_sensed && is_at_origin(&point) {
            if self.at_origin == 0 {
                self.first_at_origin = (point, self.points.len());
            }
            self.at_origin += 1;
            return Ok(());
        }
        if self.is_sensed && self.points.is_empty() && point.iter().any(|c| c.abs() > FAR) {
            self.origin = point.map(f64::round);
        }
        let rounded = self.rounded(point);
        self.points.push(rounded);
        Ok(())
    }

    /// Adds the point at the origin of the frame, if it is the only one: in a map it may be a cell. Several mean "no
    /// return", and are skipped.
    pub fn take_origin_points(&mut self) {
        let (first, before) = self.first_at_origin;
        if self.at_origin == 1 {
            let point = self.rounded(first);
            self.points.insert(before, point);
        } else {
            self.dropped += self.at_origin;
        }
        self.at_origin = 0;
    }

    /// A point relative to the origin; what is lost is counted.
    #[allow(clippy::cast_possible_truncation)]
    fn rounded(&mut self, point: [f64; 3]) -> [f32; 3] {
        let relative = [0, 1, 2].map(|k| point[k] - self.origin[k]);
        let rounded = relative.map(|c| c as f32);
        let lost = [0, 1, 2].map(|k| relative[k] - f64::from(rounded[k]));
        if lost != [0.0; 3] {
            self.rounding = self.rounding.greater(lost.iter().map(|l| l * l).sum::<f64>().sqrt());
        }
        rounded
    }

    /// The points in the frame of the cloud (m).
    pub fn positions(&self) -> impl Iterator<Item = [f64; 3]> {
        let origin = self.origin;
        self.points.iter().map(move |point| [0, 1, 2].map(|k| origin[k] + f64::from(point[k])))
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

    /// The cloud of balls in the frame of the points' origin, of this `radius` (m) around the points, enlarged by the rounding displacement; `None` without points.
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
    fn sensed_points_far_from_their_frame_keep_their_places() {
        let mut cloud = CloudPoints::of_sensor();
        let far =
            [[0.0; 3], [500_123.417, 5_400_321.733, 41.2], [500_125.031, 5_400_320.899, 43.0], [0.0; 3]];
        for point in far {
            cloud.push(point).unwrap();
        }
        cloud.take_origin_points();
        assert!(cloud.dropped == 2 && cloud.rounding < 1e-6, "{cloud:?}");
        for (place, point) in cloud.positions().zip(&far[1..]) {
            assert!((0..3).all(|k| (place[k] - point[k]).abs() < 1e-6), "{place:?} is not {point:?}");
        }
        // a single cell at the origin remains, and its error counts
        let mut cloud = CloudPoints::of_sensor();
        for point in &far[..2] {
            cloud.push(*point).unwrap();
        }
        cloud.take_origin_points();
        let first = cloud.positions().next().unwrap();
        assert!(first.iter().all(|c| c.abs() <= cloud.rounding), "{cloud:?}");
        assert_eq!((cloud.points.len(), cloud.dropped), (2, 0));
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
