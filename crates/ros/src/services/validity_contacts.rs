//! Contacts of a state as `moveit_msgs/ContactInformation`.

use std::time::{Duration, Instant};

use clearance_checker::{CollisionChecker, Contact, LocalContact, PairContacts, Workspace};
use clearance_geometry::math::{Point, Pose, Vector};
use clearance_monitor::Now;
use clearance_robot::{Configuration, LinkPoses};
use clearance_scene::BodyId;
use ros2_interfaces_jazzy_serde::geometry_msgs::msg::Vector3;
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::ContactInformation;
use ros2_interfaces_jazzy_serde::std_msgs::msg::Header;

use crate::messages::time_and_geometry::{point_message, stamp_message};
use crate::services::state_validity::carrier;

/// Largest number of contacts in a response: its size must not grow with the number of bodies.
const MOST_CONTACTS: usize = 200;

/// Largest number of contacts of one pair: the deepest, and the corners of a contact.
const MOST_OF_PAIR: usize = 8;

/// Time for the contacts of one response, after which pairs get a common point without normal and depth. It is compared
/// before each pair, so that the last pair may take longer: the first depth of a huge mesh takes a second.
pub const CONTACT_TIME: Duration = Duration::from_millis(100);

/// A state whose contacts are searched.
pub struct ContactsOfState<'s> {
    pub checker: &'s CollisionChecker,
    pub q: &'s Configuration,
    pub poses: &'s LinkPoses,
    pub now: Now,
}

/// Contacts of colliding pairs.
pub struct FoundContacts {
    /// The contacts of one pair follow each other, the deepest first.
    pub messages: Vec<ContactInformation>,
    /// Remark about pairs without contact or depth.
    pub remark: Option<String>,
}

/// One contact of a pair, as far as it is known.
struct KnownContact {
    point: Point,
    normal: Option<Vector>,
    depth: Option<f64>,
}

impl From<&Contact> for KnownContact {
    fn from(contact: &Contact) -> Self {
        Self { point: contact.point, normal: contact.normal, depth: contact.depth }
    }
}

impl From<&LocalContact> for KnownContact {
    fn from(contact: &LocalContact) -> Self {
        Self { point: contact.point, normal: Some(contact.normal), depth: contact.depth }
    }
}

impl ContactsOfState<'_> {
    /// At least one contact of each pair, as far as a response may have so many; several of each where they fit.
    pub fn contacts(
        &self,
        pairs: &[(BodyId, BodyId)],
        deadline: Instant,
        workspace: &mut Workspace,
    ) -> FoundContacts {
        let told = &pairs[..pairs.len().min(MOST_CONTACTS)];
        let most = MOST_CONTACTS.checked_div(told.len()).map_or(0, |share| share.clamp(1, MOST_OF_PAIR));
        let (mut messages, mut without_depth) = (Vec::new(), 0);
        for bodies in told {
            let is_over = Instant::now() >= deadline;
            without_depth += usize::from(is_over);
            let found: Vec<KnownContact> = if is_over {
                let found = self.checker.common_point(self.q, *bodies, workspace);
                vec![found.as_ref().map_or_else(|| self.middle_of(bodies.0), KnownContact::from)]
            } else {
                match self.checker.contacts(self.q, *bodies, most, workspace) {
                    Some(PairContacts { deepest, others }) => std::iter::once(KnownContact::from(&deepest))
                        .chain(others.iter().map(KnownContact::from))
                        .collect(),
                    None => vec![self.middle_of(bodies.0)],
                }
            };
            messages.extend(found.iter().map(|contact| self.message(*bodies, contact)));
        }
        FoundContacts { messages, remark: remark(pairs.len(), told.len(), without_depth) }
    }

    /// Where nothing is known about a contact.
    fn middle_of(&self, a: BodyId) -> KnownContact {
        KnownContact { point: self.middle(a), normal: None, depth: None }
    }

    /// Origin of a body.
    fn middle(&self, body: BodyId) -> Point {
        match body {
            BodyId::Link(link) => Point::from(self.poses.pose(link).translation.vector),
            BodyId::Attached(id) => {
                let link = carrier(self.checker, id);
                let pose_rl = link.map_or(Pose::identity(), |link| *self.poses.pose(link));
                let pose_lo = self.checker.world().attached_object(id).pose_lo;
                Point::from((pose_rl * pose_lo).translation.vector)
            }
            BodyId::Obstacle(_) => Point::origin(),
        }
    }

    /// Converts a contact. If no normal is known, it points from the middle of the first body towards the contact; if
    /// no depth is known, it is zero.
    fn message(&self, (a, b): (BodyId, BodyId), contact: &KnownContact) -> ContactInformation {
        let robot = self.checker.robot();
        let outward = || (contact.point - self.middle(a)).try_normalize(1e-9).unwrap_or_else(Vector::z);
        let normal = contact.normal.unwrap_or_else(outward);
        ContactInformation {
            header: Header {
                stamp: stamp_message(self.now.ros.unwrap_or_default()),
                frame_id: robot.link(robot.root()).name.clone(),
            },
            position: point_message(&contact.point),
            normal: Vector3 { x: normal.x, y: normal.y, z: normal.z },
            depth: contact.depth.unwrap_or(0.0),
            contact_body_1: self.checker.body_name(a).to_owned(),
            body_type_1: body_type(a),
            contact_body_2: self.checker.body_name(b).to_owned(),
            body_type_2: body_type(b),
        }
    }
}

fn body_type(body: BodyId) -> u32 {
    match body {
        BodyId::Link(_) => ContactInformation::ROBOT_LINK,
        BodyId::Attached(_) => ContactInformation::ROBOT_ATTACHED,
        BodyId::Obstacle(_) => ContactInformation::WORLD_OBJECT,
    }
}

/// Remark about pairs without contact or depth in a response.
fn remark(pairs: usize, told: usize, without_depth: usize) -> Option<String> {
    let mut missing = Vec::new();
    if told < pairs {
        missing.push(format!("{} of {pairs} colliding pairs have no contact", pairs - told));
    }
    if without_depth > 0 {
        let limit = CONTACT_TIME.as_secs_f64();
        missing.push(format!(
            "{without_depth} have no normal and depth, since contacts took more than {limit} s"
        ));
    }
    (!missing.is_empty()).then(|| missing.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_remark_counts_what_is_missing() {
        assert_eq!(remark(5, 5, 0), None);
        assert_eq!(remark(300, 200, 0).unwrap(), "100 of 300 colliding pairs have no contact");
        let all = remark(300, 200, 7).unwrap();
        assert!(all.ends_with("; 7 have no normal and depth, since contacts took more than 0.1 s"), "{all}");
    }
}
