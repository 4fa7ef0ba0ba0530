//! Contact of two touching bodies: depth, normal and point.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, Point, Vector};
use clearance_proximity as query;
use clearance_proximity::{Scratch, Separation};

use crate::pairs::PosedPair;

/// Point, normal and depth of a contact, paddings included; in the root frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Point of the contact (m), half way between the two bodies' points.
    pub point: Point,
    /// Unit vector along which the second body separates by the shortest motion; `None` where it is not known.
    pub normal: Option<Vector>,
    /// Length (m) of that motion, the penetration depth; `None` where it is not known: for meshes that cross.
    pub depth: Option<f64>,
}

impl Contact {
    /// The contact of a pair; `None` if the bodies are apart.
    pub(crate) fn of_pair(pair: &PosedPair, scratch: &mut Scratch) -> Option<Self> {
        let apart = pair.separation(pair.info.padding + CONTACT_DISTANCE, scratch)?;
        if apart.distance > 0.0 {
            return Some(contact_of(pair, &apart));
        }
        let (a, b) = pair.bodies;
        Some(match query::deepest_overlap(a, b, pair.pose_ab) {
            Some(deepest) => contact_of(pair, &deepest),
            None => Self { point: &pair.pose_ra * apart.witness_points[0], normal: None, depth: None },
        })
    }
}

/// Contact of bodies with a given distance, negative where they overlap.
fn contact_of(pair: &PosedPair, found: &Separation) -> Contact {
    let [p, q] = found.witness_points.map(|p| &pair.pose_ra * p);
    let towards_b = if found.distance > 0.0 { q - p } else { p - q };
    Contact {
        point: nalgebra::center(&p, &q),
        normal: towards_b.try_normalize(CONTACT_DISTANCE),
        depth: Some((pair.info.padding - found.distance).greater(0.0)),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::CollisionChecker;
    use clearance_geometry::math::Pose;
    use clearance_geometry::{Primitive, Shape};
    use clearance_robot::{MeshFiles, RobotModel};
    use clearance_scene::Settings;
    use clearance_scene::{AttachedId, BodyId, Obstacle, ObstacleId, World};

    const URDF: &str = "<robot name='r'><link name='a'><collision><geometry><sphere radius='0.5'/></geometry></collision></link></robot>";

    fn contact_at(at: f64, padding: f64) -> Option<Contact> {
        let robot = Arc::new(RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap());
        let mut world = World::default();
        let wall = Shape::Primitive(Primitive::Box { half_extents: [0.1, 1.0, 1.0] });
        world.add(Obstacle::of_shape("wall", Pose::translation(at, 0.0, 0.0), wall)).unwrap();
        let settings = Settings { padding, ..Settings::default() };
        let checker = CollisionChecker::new(robot, &world, settings).unwrap();
        let q = checker.robot().default_configuration();
        let (link, wall) = checker.pairs().world_pairs().next().unwrap();
        checker.contact(&q, (link, BodyId::Obstacle(wall)), &mut checker.workspace())
    }

    #[test]
    fn a_ball_in_a_wall_is_as_deep_as_it_has_to_be_moved() {
        let contact = contact_at(0.55, 0.0).unwrap();
        assert!((contact.depth.unwrap() - 0.05).abs() < 1e-9, "{contact:?}");
        assert!((contact.normal.unwrap() - Vector::x()).norm() < 1e-9, "{contact:?}");
        assert!((contact.point - Point::new(0.475, 0.0, 0.0)).norm() < 1e-9, "{contact:?}");
    }

    #[test]
    fn what_is_no_pair_has_no_contact() {
        let robot = Arc::new(RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap());
        let checker = CollisionChecker::new(robot, &World::default(), Settings::default()).unwrap();
        let (q, link) = (checker.robot().default_configuration(), BodyId::Link(checker.robot().root()));
        for other in [link, BodyId::Obstacle(ObstacleId(0)), BodyId::Attached(AttachedId(0))] {
            assert_eq!(checker.contact(&q, (link, other), &mut checker.workspace()), None);
            assert_eq!(checker.contact(&q, (other, link), &mut checker.workspace()), None);
        }
    }

    #[test]
    fn what_is_within_the_padding_is_as_deep_as_the_padding_is_wider() {
        let contact = contact_at(0.61, 0.03).unwrap();
        assert!((contact.depth.unwrap() - 0.02).abs() < 1e-9, "{contact:?}");
        assert!((contact.normal.unwrap() - Vector::x()).norm() < 1e-9, "{contact:?}");
        assert_eq!(contact_at(0.64, 0.03), None);
    }
}
