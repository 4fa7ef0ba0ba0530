//! Estimated reach of the robot, a bounding box over sampled states, for the camera of the view.

use clearance_geometry::Shape;
use clearance_geometry::math::{Extremes, Point, Vector};
use clearance_robot::{Link, LinkId, LinkPoses, RobotModel};

/// Number of sampled configurations.
const SAMPLES: usize = 400;

/// Largest reach (m) from the root that is used: the limits of a prismatic joint may be arbitrarily large.
const FARTHEST: f64 = 20.0;

/// Bounding sphere of a shape, in the frame of its link.
struct Sphere {
    link: LinkId,
    centre: Point,
    radius: f64,
}

/// Lower and upper corner (root frame, m) of a box around the robot in many configurations within its joint limits.
/// Planar and floating joints keep their default positions. `None` without geometry.
///
/// For display only: the box comes from samples, so the robot may reach a little farther.
pub fn sampled_reach(robot: &RobotModel) -> Option<[Vector; 2]> {
    let links = robot.link_ids().zip(robot.links());
    let spheres: Vec<Sphere> = links.flat_map(|(id, link)| spheres(id, link)).collect();
    let mut random = fastrand::Rng::with_seed(0);
    let mut poses = LinkPoses::new(robot);
    let mut reach: Option<[Vector; 2]> = None;
    for _ in 0..SAMPLES {
        robot.forward_kinematics(&robot.random_configuration(&mut random), &mut poses);
        for Sphere { link, centre, radius } in &spheres {
            let middle = (poses.pose(*link) * centre).coords;
            let extent = Vector::repeat(*radius);
            let [low, high] = reach.unwrap_or([middle, middle]);
            reach = Some([low.inf(&(middle - extent)), high.sup(&(middle + extent))]);
        }
    }
    reach.map(|corners| corners.map(|corner| corner.map(|x| x.greater(-FARTHEST).lesser(FARTHEST))))
}

fn spheres(id: LinkId, link: &Link) -> impl Iterator<Item = Sphere> + '_ {
    link.collisions.iter().filter_map(move |collision| {
        let (centre, radius) = match &collision.shape {
            Shape::Primitive(primitive) => (Point::origin(), primitive.bounding_radius()),
            Shape::Mesh(mesh) => {
                let (low, high) = mesh.bounds();
                (nalgebra::center(&low, &high), 0.5 * nalgebra::distance(&low, &high))
            }
            // these shapes do not occur in a URDF
            Shape::Plane(_) | Shape::Points(_) | Shape::Voxels(_) => return None,
        };
        Some(Sphere { link: id, centre: collision.pose_ls * centre, radius })
    })
}
