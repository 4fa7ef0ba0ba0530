//! Point cloud filter: transform, crop, self-filter and voxel filter in sequence; the result is the cloud of obstacles.

use std::sync::Arc;

use clearance_geometry::PointCloud;
use clearance_geometry::constants::LARGEST_COORDINATE;
use clearance_geometry::math::{Extremes, Point, Pose};
use clearance_robot::LinkPoses;

use super::SelfFilter;

/// Error (m) of the points that is far below the noise of any sensor: points inside the robot are removed all the same.
const NEGLIGIBLE: f64 = 1e-4;

/// Filter settings for clouds. Lengths in metres, corners in the root frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CloudFilter {
    /// Radius of the ball around each point.
    pub point_radius: f64,
    /// Lower corner of the crop box: points outside are removed.
    pub crop_min: Option<[f64; 3]>,
    /// Upper corner of the crop box: points outside are removed.
    pub crop_max: Option<[f64; 3]>,
    /// Points nearer than this to the robot are removed as points of the robot.
    pub self_filter_padding: f64,
    /// Edge of the cubes of the voxel filter; 0 switches it off.
    pub voxel_size: f64,
}

/// Result of the filter.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FilteredCloud {
    /// Remaining points in the root frame; `None` when there are none.
    pub cloud: Option<Arc<PointCloud>>,
    /// Number of points outside the crop box.
    pub cropped: usize,
    /// Number of points of the robot itself.
    pub of_robot: usize,
}

impl CloudFilter {
    /// Balls that contain every point that is neither cropped nor part of the robot, each point with its radius.
    /// `pose_rc` is the pose of the cloud in the root frame; `rounding` (m) is the possible error of its points. Points
    /// that may, within that error, be inside the crop box or beside the robot remain.
    ///
    /// # Errors
    /// When a point is too far away for the computation.
    pub fn apply(
        &self,
        points: &[[f32; 3]],
        rounding: f64,
        pose_rc: &Pose,
        robot: (&SelfFilter, &LinkPoses),
    ) -> Result<FilteredCloud, String> {
        let all = points.iter().map(|p| pose_rc * Point::from(p.map(f64::from)));
        let mut kept: Vec<Point> = all.filter(|p| self.is_inside(p, rounding)).collect();
        let cropped = points.len() - kept.len();
        let (filter, poses) = robot;
        if self.self_filter_padding >= rounding || rounding <= NEGLIGIBLE {
            let padding = (self.self_filter_padding - rounding).greater(0.0);
            let mut is_robot = filter.is_robot(&kept, poses, padding).into_iter();
            kept.retain(|_| !is_robot.next().unwrap_or(false));
        }
        let of_robot = points.len() - cropped - kept.len();
        let mut radius = self.point_radius + rounding;
        if self.voxel_size > 0.0 {
            kept = voxel_centres(&kept, self.voxel_size);
            radius += 0.5 * 3.0_f64.sqrt() * self.voxel_size;
        }
        let cloud = cloud(&kept, radius)?;
        Ok(FilteredCloud { cloud, cropped, of_robot })
    }

    /// Whether a point of a cloud at this pose (root frame) is outside the crop box.
    #[must_use]
    pub fn crops(&self, point: [f32; 3], rounding: f64, pose_rc: &Pose) -> bool {
        !self.is_inside(&(pose_rc * Point::from(point.map(f64::from))), rounding)
    }

    /// Whether a point with this possible error may be inside the crop box.
    fn is_inside(&self, p: &Point, rounding: f64) -> bool {
        let above = self.crop_min.is_none_or(|min| (0..3).all(|i| p[i] + rounding >= min[i]));
        above && self.crop_max.is_none_or(|max| (0..3).all(|i| p[i] - rounding <= max[i]))
    }
}

/// Centres of all grid cubes that contain points, sorted, so that the order of the points has no effect.
fn voxel_centres(points: &[Point], edge: f64) -> Vec<Point> {
    let mut cubes: Vec<[f64; 3]> = points.iter().map(|p| (p / edge).coords.map(f64::floor).into()).collect();
    cubes.sort_unstable_by(|a, b| {
        a.iter()
            .zip(b)
            .map(|(a, b)| a.total_cmp(b))
            .find(|order| order.is_ne())
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    cubes.dedup();
    cubes.into_iter().map(|cube| Point::from(cube.map(|c| (c + 0.5) * edge))).collect()
}

/// Converts balls to 32-bit floats, with a radius that is enlarged so that they contain the 64-bit balls.
fn cloud(points: &[Point], radius: f64) -> Result<Option<Arc<PointCloud>>, String> {
    let mut moved: f64 = 0.0;
    let mut reach: f64 = 0.0;
    let mut rounded = Vec::with_capacity(points.len());
    for p in points {
        let usable = p.iter().all(|c| c.abs() <= LARGEST_COORDINATE);
        if !usable {
            return Err(format!(
                "a point lies at {p:?}, farther than the {LARGEST_COORDINATE:e} m that can be computed with"
            ));
        }
        #[expect(clippy::cast_possible_truncation, reason = "what is lost is added to the radius")]
        let near = p.coords.map(|c| c as f32);
        moved = moved.greater((near.map(f64::from) - p.coords).norm_squared());
        reach = reach.greater(p.coords.amax());
        rounded.push(near.into());
    }
    if rounded.is_empty() {
        return Ok(None);
    }
    // the transform and these measurements round too, by a few units in the last place of 64 bits
    let radius = radius + moved.sqrt() + 16.0 * f64::EPSILON * reach;
    PointCloud::new(rounded, radius).map(|cloud| Some(Arc::new(cloud))).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use clearance_geometry::{Plane, Primitive, Shape};
    use clearance_robot::{MeshFiles, RobotModel};
    use clearance_scene::{AttachedObject, ObstacleShape, World};

    const URDF: &str = r#"<robot name="ball">
      <link name="base"/>
      <link name="ball"><collision><geometry><sphere radius="0.5"/></geometry></collision></link>
      <joint name="slide" type="prismatic"><parent link="base"/><child link="ball"/><axis xyz="1 0 0"/>
        <limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
    </robot>"#;

    /// The robot at a pose where the centre of its ball is at x = 2.
    fn robot() -> (SelfFilter, LinkPoses) {
        let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
        let mut poses = LinkPoses::new(&robot);
        robot.forward_kinematics(&robot.configuration(&[2.0]).unwrap(), &mut poses);
        (SelfFilter::new(Arc::new(robot)), poses)
    }

    fn apply(cloud_filter: &CloudFilter, points: &[[f32; 3]], pose_rc: &Pose) -> FilteredCloud {
        let (filter, poses) = robot();
        cloud_filter.apply(points, 0.0, pose_rc, (&filter, &poses)).unwrap()
    }

    fn points(sieved: &FilteredCloud) -> Vec<[f32; 3]> {
        sieved.cloud.as_ref().map_or(Vec::new(), |cloud| cloud.points().to_vec())
    }

    #[test]
    fn points_of_the_robot_and_of_what_it_holds_are_left_out_and_counted() {
        let cloud_filter =
            CloudFilter { point_radius: 0.01, self_filter_padding: 0.1, ..CloudFilter::default() };
        let seen = [[2.0, 0.0, 0.0], [2.0, 0.59, 0.0], [2.0, 0.61, 0.0], [2.0, 0.0, 2.0], [0.0; 3]];
        let sieved = apply(&cloud_filter, &seen, &Pose::identity());
        assert_eq!((sieved.of_robot, sieved.cropped), (2, 0));
        assert_eq!(points(&sieved), [[2.0, 0.61, 0.0], [2.0, 0.0, 2.0], [0.0; 3]]);
        assert!((sieved.cloud.unwrap().radius() - 0.01).abs() < 1e-12);

        let (mut filter, poses) = robot();
        let shape = Shape::Primitive(Primitive::sphere(0.2).unwrap());
        let mut world = World::default();
        world
            .attach(AttachedObject {
                name: "part".to_owned(),
                link: "ball".to_owned(),
                pose_lo: Pose::translation(0.0, 0.0, 2.0),
                shapes: vec![ObstacleShape { pose_os: Pose::identity(), shape }].into(),
                subframes: Vec::new(),
                touch_links: Vec::new(),
            })
            .unwrap();
        filter.hold(&world);
        let sieved = cloud_filter.apply(&seen, 0.0, &Pose::identity(), (&filter, &poses)).unwrap();
        assert_eq!(sieved.of_robot, 3);
        // an attached plane hides no measured points
        let plane = Shape::Plane(Plane::from_coefficients([0.0, 0.0, 1.0, 0.0]).unwrap());
        let part = world.attached()[0].as_ref().clone();
        let shapes = [plane, part.shapes[0].shape.clone()];
        let shapes = shapes.map(|shape| ObstacleShape { pose_os: Pose::identity(), shape });
        world.attach(AttachedObject { shapes: shapes.into(), ..part }).unwrap();
        filter.hold(&world);
        let wall = [[9.0, 9.0, 2.0], [2.0, 0.0, 2.0]];
        let sieved = cloud_filter.apply(&wall, 0.0, &Pose::identity(), (&filter, &poses)).unwrap();
        assert_eq!((sieved.of_robot, points(&sieved)), (1, vec![[9.0, 9.0, 2.0]]));
        filter.hold(&World::default());
        let sieved = cloud_filter.apply(&seen, 0.0, &Pose::identity(), (&filter, &poses)).unwrap();
        assert_eq!(sieved.of_robot, 2);
    }

    #[test]
    fn points_that_may_be_obstacles_within_their_error_remain() {
        let (filter, poses) = robot();
        let cloud_filter =
            CloudFilter { self_filter_padding: 0.1, crop_max: Some([3.0; 3]), ..CloudFilter::default() };
        let near = [[2.0, 0.59, 0.0], [2.0, 0.0, 3.02], [2.0, 0.0, 0.0]];
        let kept = |rounding| {
            let filtered = cloud_filter.apply(&near, rounding, &Pose::identity(), (&filter, &poses)).unwrap();
            points(&filtered)
        };
        assert_eq!(kept(0.0), [[0.0_f32; 3]; 0]);
        assert_eq!(kept(0.03), near[..2]);
        assert_eq!(kept(0.2), near);
    }

    #[test]
    fn clouds_are_placed_and_cropped() {
        let cloud_filter = CloudFilter {
            crop_min: Some([-1.0; 3]),
            crop_max: Some([1.0, 1.0, 5.0]),
            ..CloudFilter::default()
        };
        let place = Pose::translation(0.0, 0.0, 4.0);
        let sieved =
            apply(&cloud_filter, &[[0.0; 3], [0.0, 0.0, 1.5], [0.0, -1.5, 0.0], [0.0, 0.0, -4.5]], &place);
        assert_eq!((points(&sieved), sieved.cropped), (vec![[0.0, 0.0, 4.0], [0.0, 0.0, -0.5]], 2));
        let nothing = apply(&cloud_filter, &[[9.0; 3]], &place);
        assert_eq!((nothing.cloud, nothing.cropped), (None, 1));
        let (filter, poses) = robot();
        let far = Pose::translation(1e9, 0.0, 0.0);
        assert!(CloudFilter::default().apply(&[[0.0; 3]], 0.0, &far, (&filter, &poses)).is_err());
    }

    proptest! {
        #[test]
        fn balls_hold_the_points_that_they_stand_for(
            seen in prop::collection::vec(prop::array::uniform3(-9.0..9.0f32), 1..60),
            turn in prop::array::uniform3(-3.0..3.0f64),
            voxel_size in prop_oneof![Just(0.0), 0.01..3.0f64],
        ) {
            let cloud_filter = CloudFilter { point_radius: 0.05, voxel_size, ..CloudFilter::default() };
            let pose_rc = Pose::new(turn.into(), turn.into());
            let sieved = apply(&cloud_filter, &seen, &pose_rc);
            let (filter, poses) = robot();
            let placed: Vec<Point> = seen.iter().map(|p| pose_rc * Point::from(p.map(f64::from))).collect();
            let is_robot = filter.is_robot(&placed, &poses, 0.0);
            let balls = points(&sieved);
            let radius = sieved.cloud.as_ref().map_or(0.0, |cloud| cloud.radius());
            let half_diagonal = 0.5 * 3.0_f64.sqrt() * voxel_size;
            prop_assert!(radius <= 0.05 + half_diagonal + 1e-4);
            for (p, _) in placed.iter().zip(is_robot).filter(|(_, is_robot)| !is_robot) {
                let held = balls.iter().any(|b| {
                    nalgebra::distance(p, &Point::from(b.map(f64::from))) + 0.05 <= radius + 1e-12
                });
                prop_assert!(held, "{p} is in none of {balls:?}");
            }
        }
    }
}
