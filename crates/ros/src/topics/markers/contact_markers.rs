//! Markers of contacts: a ball at each point, and an arrow along its normal whose length is the depth.

use clearance_geometry::math::{Extremes, Point, Vector};
use clearance_monitor::CheckedState;
use ros2_interfaces_jazzy_serde::visualization_msgs::msg::Marker;

use super::Scene;
use crate::messages::time_and_geometry::{point_message, vector_message};

const CONTACTS: &str = "contacts";
const MAGENTA: [f32; 4] = [0.85, 0.1, 0.75, 1.0];

/// Diameter of the ball at a contact point (m).
const BALL: f64 = 0.008;
/// Diameters of an arrow's shaft and head (m).
const SHAFT: f64 = 0.003;
const HEAD: f64 = 0.008;
/// Least length of an arrow (m), so that it can be seen.
const SHORTEST_ARROW: f64 = 0.03;
/// Maximum number of arrows (about 350 bytes each). The points of all contacts are shown.
const ARROWS_SHOWN: usize = 200;

/// Position, normal and depth of a contact, as they are drawn.
struct ShownContact {
    point: Point,
    normal: Option<Vector>,
    depth: f64,
}

impl Scene {
    /// Adds the contacts of an evaluation, in their order: one marker with all points, and one with an arrow for each normal.
    pub(super) fn add_contacts(&mut self, checked_state: &CheckedState) {
        let contacts = shown_contacts(checked_state);
        if contacts.is_empty() {
            return;
        }
        self.add(CONTACTS, 0, Marker::SPHERE_LIST, MAGENTA, |marker| {
            marker.scale = vector_message(&Vector::repeat(BALL));
            marker.points = contacts.iter().map(|contact| point_message(&contact.point)).collect();
        });
        let with_normal = contacts.iter().filter_map(|contact| Some((contact, contact.normal?)));
        for (index, (contact, normal)) in with_normal.take(ARROWS_SHOWN).enumerate() {
            let tip = contact.point + normal * contact.depth.greater(SHORTEST_ARROW);
            self.add(CONTACTS, 1 + index, Marker::ARROW, MAGENTA, |marker| {
                // with two points: diameters of shaft and head; RViz chooses the length of the head
                marker.scale = vector_message(&Vector::new(SHAFT, HEAD, 0.0));
                marker.points = [contact.point, tip].iter().map(point_message).collect();
            });
        }
    }
}

fn shown_contacts(checked_state: &CheckedState) -> Vec<ShownContact> {
    let of_pairs = checked_state.contacts.iter().flat_map(|of_pair| {
        let deepest = &of_pair.contacts.deepest;
        let first = ShownContact {
            point: deepest.point,
            normal: deepest.normal,
            depth: deepest.depth.unwrap_or_default(),
        };
        let others = of_pair.contacts.others.iter().map(|contact| ShownContact {
            point: contact.point,
            normal: Some(contact.normal),
            depth: contact.depth.unwrap_or_default(),
        });
        std::iter::once(first).chain(others)
    });
    of_pairs.collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::time::Duration;

    use clearance_checker::CollisionChecker;
    use clearance_geometry::math::Pose;
    use clearance_geometry::{Primitive, Shape};
    use clearance_monitor::{JointStateInput, Monitor, MonitorSettings, Now, Revision, Time};
    use clearance_robot::{MeshFiles, RobotModel};
    use clearance_scene::{Obstacle, Settings, World};

    use super::*;
    use crate::topics::markers::MarkerDisplay;

    const URDF: &str = include_str!("../../../../../urdf/two_link/two_link.urdf");

    /// Markers, by id, of the stretched arm whose tip, a ball of radius 0.1 m at (2, 0, 0), is this deep (m) in a box above it.
    fn contact_markers(depth: f64, contacts_per_pair: usize, display: &mut MarkerDisplay) -> Vec<Marker> {
        let mut world = World::default();
        let board = Shape::Primitive(Primitive::Box { half_extents: [1.0, 1.0, 0.5] });
        world.add(Obstacle::of_shape("board", Pose::translation(2.5, 0.0, 0.6 - depth), board)).unwrap();
        let robot = Arc::new(RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap());
        let checker = CollisionChecker::new(robot, &world, Settings::default()).unwrap();
        let settings = MonitorSettings { contacts_per_pair, ..MonitorSettings::default() };
        let mut monitor = Monitor::new(settings, || Duration::ZERO);
        monitor.set_checker(Arc::new(Revision::new(checker, 1, 1)));
        let input = JointStateInput {
            names: vec!["joint1".to_owned(), "joint2".to_owned()],
            positions: vec![0.0, 0.0],
            ..JointStateInput::default()
        };
        let now = Now { ros: Some(Time::from_nanoseconds(5)), steady: Duration::ZERO };
        let evaluation = monitor.on_joint_state(input, now);
        let array = display.update(&evaluation, Duration::from_secs(1));
        array.markers.into_iter().filter(|marker| marker.ns == CONTACTS).collect()
    }

    fn length(arrow: &Marker) -> f64 {
        let [from, to] = arrow.points.as_slice() else { panic!("{arrow:?}") };
        Vector::new(to.x - from.x, to.y - from.y, to.z - from.z).norm()
    }

    #[test]
    fn a_contact_has_a_ball_and_an_arrow_as_long_as_it_is_deep() {
        for (depth, expected) in [(0.05, 0.05), (0.001, SHORTEST_ARROW)] {
            let mut display = MarkerDisplay::default();
            let markers = contact_markers(depth, 1, &mut display);
            let [balls, arrow] = markers.as_slice() else { panic!("{markers:?}") };
            assert_eq!(
                (balls.type_, balls.points.len(), arrow.type_),
                (Marker::SPHERE_LIST, 1, Marker::ARROW)
            );
            let [from, to] = arrow.points.as_slice() else { panic!("{arrow:?}") };
            assert_eq!(*from, balls.points[0]);
            assert!((length(arrow) - expected).abs() < 1e-6, "{arrow:?}");
            // towards the second body, the box above
            assert!(to.z > from.z && (to.x - from.x).abs() < 1e-9, "{arrow:?}");
            let gone = contact_markers(-0.1, 1, &mut display);
            assert!(gone.len() == 2 && gone.iter().all(|marker| marker.action == Marker::DELETE), "{gone:?}");
        }
    }

    #[test]
    fn without_the_parameter_there_are_none() {
        assert_eq!(contact_markers(0.05, 0, &mut MarkerDisplay::default()), []);
    }
}
