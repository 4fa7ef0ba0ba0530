//! Pairs of links that touched in every state checked so far, and the warning that names the SRDF entries for them.
//!
//! Such a pair is usually overlapping geometry that no SRDF entry allows, not a collision.

use std::collections::BTreeSet;
use std::fmt::Write;

use clearance_geometry::math::Extremes;
use clearance_robot::{Configuration, LinkId, xml_attribute};
use clearance_scene::BodyId;

use crate::CollisionChecker;

/// Pairs of links that touched in every state so far.
#[derive(Clone, Debug, Default)]
pub struct ConstantContacts {
    states: usize,
    pairs: BTreeSet<(LinkId, LinkId)>,
    /// By position: the smallest and the largest value so far.
    ranges: Vec<[f64; 2]>,
}

/// Maximum number of pairs named in a remark.
const MOST_NAMED: usize = 3;

impl ConstantContacts {
    /// Minimum number of states for a remark.
    pub const FEWEST_STATES: usize = 20;

    /// Range of positions (rad, m) below which the robot counts as not moved.
    const REST: f64 = 0.01;

    /// Records a state and all its colliding pairs.
    pub fn add(&mut self, q: &Configuration, colliding: &[(BodyId, BodyId)]) {
        let of_links = colliding.iter().filter_map(|&pair| match pair {
            (BodyId::Link(a), BodyId::Link(b)) => Some((a.min(b), a.max(b))),
            _ => None,
        });
        let pairs: BTreeSet<_> = of_links.collect();
        if self.states == 0 {
            self.pairs = pairs;
            self.ranges = q.positions().iter().map(|&x| [x, x]).collect();
        } else {
            self.pairs.retain(|pair| pairs.contains(pair));
        }
        for (range, &x) in self.ranges.iter_mut().zip(q.positions()) {
            *range = [range[0].lesser(x), range[1].greater(x)];
        }
        self.states += 1;
    }

    /// True if some pair may still touch in every state.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.states == 0 || !self.pairs.is_empty()
    }

    /// Remark that names the pairs that touched in every state, and the SRDF entries that would allow them. `states`
    /// names the states in the text, for example `all 25 states`.
    #[must_use]
    pub fn remark(&self, states: &str, checker: &CollisionChecker) -> Option<String> {
        if self.states < Self::FEWEST_STATES || self.pairs.is_empty() {
            return None;
        }
        let robot = checker.robot();
        let named = self.pairs.iter().take(MOST_NAMED);
        let names: Vec<String> = (named.clone())
            .map(|(a, b)| format!("'{}' and '{}'", robot.link(*a).name, robot.link(*b).name))
            .collect();
        let mut remark = format!("links {} touch in {states}", names.join("; "));
        if self.pairs.len() > MOST_NAMED {
            let more = self.pairs.len() - MOST_NAMED;
            // writing to a String cannot fail
            let _ = write!(remark, ", and so do {more} more pairs");
        }
        if self.ranges.iter().all(|[low, high]| high - low < Self::REST) {
            remark += " (the robot has hardly moved between them: it may be a true collision)";
        }
        let entries: Vec<String> = named.map(|pair| entry(*pair, checker)).collect();
        let place = if checker.has_matrix() {
            "the allowed_collision_matrix of the scene, which counts here in place of the SRDF, has to allow them; the SRDF entry is"
        } else if robot.srdf().is_some() {
            "an SRDF entry allows them:"
        } else {
            "an SRDF with these entries, and with those of all adjacent links, allows them:"
        };
        let _ = write!(
            remark,
            ". If they always touch by design, as adjacent parts may, {place} {}. Allowed pairs are never checked: that hides true \
             collisions between them",
            entries.join(" ")
        );
        Some(remark)
    }
}

/// The element of an SRDF that allows a pair.
fn entry((a, b): (LinkId, LinkId), checker: &CollisionChecker) -> String {
    let robot = checker.robot();
    let [link1, link2] = [a, b].map(|link| xml_attribute(robot.described_name(link)));
    let reason = if robot.adjacent_rigid_bodies(a, b) { "Adjacent" } else { "Always" };
    format!("<disable_collisions link1=\"{link1}\" link2=\"{link2}\" reason=\"{reason}\"/>")
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::Question;
    use clearance_robot::{MeshFiles, RobotModel, RobotText};
    use clearance_scene::Settings;
    use clearance_scene::World;

    /// Links b and c overlap always; d meets them when its joint is at zero.
    fn checker(srdf: Option<&str>) -> CollisionChecker {
        let link = |name: &str| {
            let shape = "<collision><geometry><sphere radius='0.1'/></geometry></collision>";
            let joint = format!(
                "<parent link='a'/><child link='{name}'/><axis xyz='1 0 0'/><limit lower='-9' upper='9'/>"
            );
            format!("<link name='{name}'>{shape}</link><joint name='{name}' type='prismatic'>{joint}</joint>")
        };
        let fixed = link("b &amp; c").replace("prismatic", "fixed");
        let urdf = format!("<robot name='r'><link name='a'/>{fixed}{}{}</robot>", link("c"), link("d"));
        let text = RobotText { urdf: &urdf, srdf, ..RobotText::default() };
        let robot = RobotModel::from_text(&text, &MeshFiles::default()).unwrap();
        CollisionChecker::new(Arc::new(robot), &World::default(), Settings::default()).unwrap()
    }

    fn contacts(checker: &CollisionChecker, states: impl IntoIterator<Item = [f64; 2]>) -> ConstantContacts {
        let mut contacts = ConstantContacts::default();
        for state in states {
            let q = checker.robot().configuration(&state).unwrap();
            let report = checker.check(&q, Question::Pairs, &mut checker.workspace());
            contacts.add(&q, &report.colliding_pairs);
        }
        contacts
    }

    const SRDF: &str = "<robot name='r'/>";

    #[test]
    fn pairs_that_always_touch_are_named_with_their_srdf_entry() {
        let checker = checker(Some(SRDF));
        let states = |count: i32| (0..count).map(|i| [0.005 * f64::from(i), 0.1 * f64::from(i)]);
        let remark = contacts(&checker, states(20)).remark("all 20 states", &checker).unwrap();
        for words in [
            "links 'b & c' and 'c' touch in all 20 states",
            r#"<disable_collisions link1="b &amp; c" link2="c" reason="Adjacent"/>"#,
            "hides true collisions",
        ] {
            assert!(remark.contains(words), "{remark}");
        }
        assert!(
            !remark.contains("hardly moved") && !remark.contains("'d'") && !remark.contains('\n'),
            "{remark}"
        );
        assert_eq!(contacts(&checker, states(19)).remark("all", &checker), None);
        let resting = contacts(&checker, [[0.0, 1.0]; 20]).remark("all 20 states", &checker).unwrap();
        assert!(resting.contains("hardly moved"), "{resting}");
    }

    #[test]
    fn one_free_state_ends_it() {
        let checker = checker(Some(SRDF));
        let mut states = vec![[0.0, 1.0]; 30];
        states[7] = [1.0, 2.0];
        let contacts = contacts(&checker, states);
        assert!(!contacts.is_open());
        assert_eq!(contacts.remark("all", &checker), None);
    }

    #[test]
    fn without_an_srdf_adjacent_links_are_left_out_already() {
        let checker = checker(None);
        assert_eq!(contacts(&checker, [[0.0, 1.0]; 20]).remark("all", &checker), None);
        // c and d are siblings
        let remark = contacts(&checker, [[0.0, 0.0]; 20]).remark("all", &checker).unwrap();
        assert!(remark.contains("those of all adjacent links") && remark.contains("\"Always\""), "{remark}");
    }
}
