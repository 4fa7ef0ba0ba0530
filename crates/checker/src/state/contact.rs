//! Contact of two touching bodies: depth, normal and point.

use clearance_geometry::PointPair;
use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, Point, Vector};
use clearance_proximity::{
    DeepestContact, PenetrationDepth, Scratch, Separation, SolidBody, UnknownDepth, is_one_inside,
    penetration_depth,
};

use crate::pairs::PosedPair;

/// Point, normal and depth of a contact, paddings included; in the root frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Point of the contact (m), half way between the two bodies' points.
    pub point: Point,
    /// Unit vector along which the second body separates by a short translation; `None` where none was found.
    pub normal: Option<Vector>,
    /// Length (m) of that translation, after which the bodies are proven apart: the penetration depth, or an upper bound
    /// on it. `None` where no such translation was found.
    pub depth: Option<f64>,
    /// Lower bound (m) on the penetration depth: no shorter translation separates the bodies.
    pub depth_lower: f64,
    /// Reason why the depth may be much larger than its lower bound.
    pub unknown: Option<UnknownDepth>,
}

/// A contact as it was found: in the root frame, and in the frame of the first body.
pub(crate) struct FoundContact {
    pub contact: Contact,
    pub deepest: DeepestContact,
}

impl FoundContact {
    /// The deepest contact of a pair; `None` if the bodies are apart.
    pub fn of_pair<'s>(
        pair: &PosedPair,
        solids: impl FnOnce() -> [&'s SolidBody; 2],
        scratch: &mut Scratch,
    ) -> Option<Self> {
        let padding = pair.info.padding;
        let apart = pair.separation(padding + CONTACT_DISTANCE, scratch)?;
        let [a, b] = solids();
        let of_paddings_only = apart.distance > 0.0 && !is_one_inside(a, b, &pair.pose_ab, scratch);
        if of_paddings_only && pair.comes_apart(&apart, scratch) {
            return Some(Self::of_paddings(pair, &apart));
        }
        let depth = penetration_depth(a, b, pair.pose_ab, padding, scratch);
        // the distance changes at most as much as a body is moved; the depth of solids says nothing about surfaces that are apart
        let of_distance = (padding - apart.distance).greater(0.0);
        let depth = depth.map(|depth| PenetrationDepth {
            lower: if of_paddings_only { of_distance } else { depth.lower },
            ..depth
        });
        Some(match depth {
            Some(deepest) if deepest.upper.is_finite() => Self::of_depth(pair, &deepest),
            Some(deepest) => Self::at_common_point(pair, &apart).without_translation(&deepest),
            None => Self::at_common_point(pair, &apart),
        })
    }

    /// A common point of a pair, without a depth unless only the paddings overlap: cheaper than a contact with its
    /// depth.
    pub fn without_depth(pair: &PosedPair, scratch: &mut Scratch) -> Option<Self> {
        let apart = pair.separation(pair.info.padding + CONTACT_DISTANCE, scratch)?;
        let found = if apart.distance > 0.0 { Self::of_paddings } else { Self::at_common_point };
        Some(found(pair, &apart))
    }

    /// The contact of bodies whose paddings overlap, at a distance.
    fn of_paddings(pair: &PosedPair, apart: &Separation) -> Self {
        let [p, q] = apart.witness_points.map(|p| &pair.pose_ra * p);
        let depth = (pair.info.padding - apart.distance).greater(0.0);
        let contact = Contact {
            point: nalgebra::center(&p, &q),
            normal: (q - p).try_normalize(CONTACT_DISTANCE),
            depth: Some(depth),
            depth_lower: depth,
            unknown: None,
        };
        Self { contact, deepest: deepest_contact(pair, &contact, apart.witness_points) }
    }

    /// The contact of bodies of which only a common point is known.
    fn at_common_point(pair: &PosedPair, touching: &Separation) -> Self {
        let point = &pair.pose_ra * touching.witness_points[0];
        let contact = Contact { point, normal: None, depth: None, depth_lower: 0.0, unknown: None };
        Self { contact, deepest: deepest_contact(pair, &contact, touching.witness_points) }
    }

    /// Adds what is known on a depth without a translation that separates.
    fn without_translation(self, found: &PenetrationDepth) -> Self {
        let contact = Contact { depth_lower: found.lower, unknown: found.unknown, ..self.contact };
        Self { contact, ..self }
    }

    fn of_depth(pair: &PosedPair, deepest: &PenetrationDepth) -> Self {
        let [p, q] = deepest.witness_points.map(|p| &pair.pose_ra * p);
        let contact = Contact {
            point: nalgebra::center(&p, &q),
            normal: Some(pair.pose_ra.rotation * deepest.direction),
            depth: Some(deepest.upper),
            depth_lower: deepest.lower,
            unknown: deepest.unknown,
        };
        Self { contact, deepest: deepest_contact(pair, &contact, deepest.witness_points) }
    }
}

fn deepest_contact(pair: &PosedPair, contact: &Contact, witness_points: PointPair) -> DeepestContact {
    let normal = contact.normal.map(|n| pair.pose_ra.rotation.tr_mul(&n));
    DeepestContact { witness_points, normal, depth: contact.depth.unwrap_or(0.0) }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::CollisionChecker;
    use clearance_geometry::math::Pose;
    use clearance_geometry::{Primitive, Shape, TriangleMesh};
    use clearance_robot::{MeshFiles, RobotModel};
    use clearance_scene::Settings;
    use clearance_scene::{AttachedId, BodyId, Obstacle, ObstacleId, ObstacleShape, World};

    const URDF: &str = "<robot name='r'><link name='a'><collision><geometry><sphere radius='0.5'/></geometry></collision></link></robot>";

    fn contact_at(at: f64, padding: f64) -> Option<Contact> {
        contact_with(Shape::Primitive(Primitive::Box { half_extents: [0.1, 1.0, 1.0] }), at, padding)
    }

    fn contact_with(wall: Shape, at: f64, padding: f64) -> Option<Contact> {
        let robot = Arc::new(RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap());
        let mut world = World::default();
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
        assert!((contact.depth.unwrap() - 0.05).abs() < 1e-8, "{contact:?}");
        assert!((contact.normal.unwrap() - Vector::x()).norm() < 1e-8, "{contact:?}");
        assert!((contact.point - Point::new(0.475, 0.0, 0.0)).norm() < 1e-8, "{contact:?}");
    }

    /// A closed mesh counts as a solid; one without a face is a surface, of which the depth is an upper bound.
    #[test]
    fn meshes_have_depths_and_normals() {
        let corner = |i: usize| {
            let at = |k: usize, half: f64| if i >> k & 1 == 0 { -half } else { half };
            Point::new(at(0, 0.1), at(1, 1.0), at(2, 1.0))
        };
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces: Vec<[u32; 3]> =
            quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        for (faces, unknown) in [(&faces[..], None), (&faces[1..], Some(UnknownDepth::OpenMesh))] {
            let mesh = TriangleMesh::new((0..8).map(corner).collect(), faces.to_vec()).unwrap();
            let contact = contact_with(Shape::Mesh(Arc::new(mesh)), 0.55, 0.0).unwrap();
            assert!((contact.depth.unwrap() - 0.05).abs() < 1e-8, "{contact:?}");
            assert!((contact.normal.unwrap() - Vector::x()).norm() < 1e-6, "{contact:?}");
            assert!((contact.point - Point::new(0.475, 0.0, 0.0)).norm() < 1e-6, "{contact:?}");
            assert_eq!(contact.unknown, unknown, "{contact:?}");
        }
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
        assert!((contact.depth.unwrap() - 0.02).abs() < 1e-8, "{contact:?}");
        assert!((contact.normal.unwrap() - Vector::x()).norm() < 1e-8, "{contact:?}");
        assert_eq!(contact_at(0.64, 0.03), None);
    }

    /// The ball is between two plates: away from the nearer one, it comes nearer to the other.
    #[test]
    fn what_is_within_the_padding_on_two_sides_has_to_leave_the_slot() {
        let robot = Arc::new(RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap());
        let shape = Shape::Primitive(Primitive::Box { half_extents: [0.1, 0.3, 1.0] });
        let plate = |x| ObstacleShape { pose_os: Pose::translation(x, 0.0, 0.0), shape: shape.clone() };
        let checker = |at: Vector| {
            let mut world = World::default();
            let slot = Obstacle::new("slot", vec![plate(0.612), plate(-0.61)]);
            world.add(Obstacle { pose_ro: Pose::from(at), ..slot }).unwrap();
            let settings = Settings { padding: 0.03, ..Settings::default() };
            CollisionChecker::new(Arc::clone(&robot), &world, settings).unwrap()
        };
        let there = checker(Vector::zeros());
        let q = there.robot().default_configuration();
        let (link, slot) = there.pairs().world_pairs().next().unwrap();
        let pair = (link, BodyId::Obstacle(slot));
        let contact = there.contact(&q, pair, &mut there.workspace()).unwrap();
        assert!((contact.depth_lower - 0.02).abs() < 1e-8, "{contact:?}");
        let away = contact.normal.unwrap() * (contact.depth.unwrap() + 1e-9);
        let moved = checker(away);
        assert_eq!(moved.contact(&q, pair, &mut moved.workspace()), None, "{contact:?}");

        let found = there.clearance(&q, 0.1, &mut there.workspace());
        let bounds = [found.pairs[0].lower, found.pairs[0].upper];
        assert!(
            (bounds[0] + contact.depth.unwrap()).abs() < 1e-8 && (bounds[1] + 0.02).abs() < 1e-8,
            "{bounds:?}"
        );
    }
}
