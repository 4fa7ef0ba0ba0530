//! Objects that are missing in the scene because messages about them were rejected.

use std::collections::BTreeMap;

use clearance_scene::{GapExtent, GapSubject, SceneGap, SceneRejection, SceneUpdate, World};

/// Maximum number of stored gaps, so that a hostile network cannot fill the memory.
const MOST: usize = 1000;

/// Maximum number of listed gaps, in the order of their names.
const MOST_LISTED: usize = 20;

/// Gaps in the scene that no later update has closed yet.
#[derive(Debug, Default)]
pub struct MissingObjects {
    /// By subject and name: the gap, and the fault of the last message that caused it.
    gaps: BTreeMap<(GapSubject, String), (SceneGap, String)>,
    /// Number of further gaps, whose names are not stored: only a complete scene closes them.
    unnamed: usize,
}

impl MissingObjects {
    /// Processes an update, if the message could be parsed, and the rejected parts of the message.
    pub fn on_message(&mut self, source: &str, update: Option<&SceneUpdate>, rejections: &[SceneRejection]) {
        if let Some(update) = update {
            for (gap, fault) in std::mem::take(&mut self.gaps).into_values() {
                let is_rejected = rejections.iter().any(|rejection| is_about(rejection, &gap));
                if let Some(left) = update.remaining_gap(gap, is_rejected) {
                    self.note(left, fault);
                }
            }
            if update.is_whole_of_robot() {
                self.unnamed = 0;
            }
        }
        for rejection in rejections {
            if let Some(gap) = &rejection.gap {
                self.note(gap.clone(), format!("{source}: {rejection}"));
            }
        }
    }

    /// Closes the gaps of objects that no link holds any more, whatever released them.
    pub fn close_released(&mut self, world: &World) {
        // the name is that of an object, or of a link; without a name, all objects count
        let is_held = |name: &str| {
            let mut held = world.attached().iter();
            held.any(|object| name.is_empty() || object.name == name || object.link == name)
        };
        self.gaps.retain(|_, (gap, _)| gap.extent != GapExtent::Held || is_held(&gap.name));
    }

    /// Records the objects of an update that was not applied at all, with the reason.
    pub fn note_unused(&mut self, source: &str, update: &SceneUpdate, why: &str) {
        for gap in update.announced_gaps() {
            let rejection = SceneRejection::of(&gap.name, why);
            self.note(gap, format!("{source}: {rejection}"));
        }
    }

    fn note(&mut self, gap: SceneGap, fault: String) {
        let key = (gap.subject, gap.name.clone());
        let is_full = self.gaps.len() >= MOST;
        match self.gaps.get_mut(&key) {
            Some((known, known_fault)) => {
                known.extent = known.extent.max(gap.extent);
                *known_fault = fault;
            }
            None if is_full => self.unnamed += 1,
            None => drop(self.gaps.insert(key, (gap, fault))),
        }
    }

    #[must_use]
    pub fn len(&self) -> usize {
        self.gaps.len() + self.unnamed
    }

    /// The fault of each listed gap, and the number of further gaps.
    pub fn faults(&self) -> impl Iterator<Item = String> {
        let more = self.len().saturating_sub(MOST_LISTED);
        let rest =
            (more > 0).then(|| format!("and {more} more objects are missing, because they were rejected"));
        self.gaps.values().take(MOST_LISTED).map(|(_, fault)| fault.clone()).chain(rest)
    }
}

fn is_about(rejection: &SceneRejection, gap: &SceneGap) -> bool {
    let is_same = |other: &SceneGap| {
        let is_of_all = other.subject == GapSubject::Attached && other.name.is_empty();
        other.subject == gap.subject && (other.name == gap.name || is_of_all)
    };
    rejection.gap.as_ref().is_some_and(is_same) || rejection.object.as_deref() == Some(&gap.name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clearance_scene::{
        AttachedChange, ObjectChange, OctomapPlacement, Operation, SceneChange, WorldChange,
    };

    fn object(id: &str, operation: Operation) -> SceneUpdate {
        SceneUpdate::Object(Box::new(ObjectChange::named(id, operation)))
    }

    fn add(id: &str) -> SceneUpdate {
        object(id, Operation::Add)
    }

    fn attach(id: &str) -> SceneUpdate {
        let (link, touch_links) = (String::new(), Vec::new());
        let object = ObjectChange::named(id, Operation::Add);
        SceneUpdate::Attached(Box::new(AttachedChange { link, object, touch_links }))
    }

    fn no_link(id: &str) -> SceneRejection {
        SceneRejection::of(id, "no link").of_attached().of_pose()
    }

    fn faults(missing: &MissingObjects) -> Vec<String> {
        missing.faults().collect()
    }

    #[test]
    fn an_object_is_missing_until_something_about_it_is_right() {
        let mut missing = MissingObjects::default();
        missing.on_message("topic", Some(&add("a")), &[SceneRejection::of("a", "no shapes")]);
        missing.on_message("topic", Some(&attach("held")), &[no_link("held")]);
        missing.on_message("topic", Some(&add("b")), &[]);
        assert_eq!(faults(&missing), ["topic: object 'a': no shapes", "topic: object 'held': no link"]);
        // a world message contains no attached objects
        missing.on_message("topic", Some(&SceneUpdate::World(Box::default())), &[]);
        assert_eq!(faults(&missing), ["topic: object 'held': no link"]);
        missing.on_message("topic", Some(&attach("held")), &[]);
        assert!(faults(&missing).is_empty());
    }

    #[test]
    fn a_rejected_detachment_is_a_fault_until_all_are_detached() {
        let detach = |id: &str| {
            let object = ObjectChange::named(id, Operation::Remove);
            let (link, touch_links) = (String::new(), Vec::new());
            SceneUpdate::Attached(Box::new(AttachedChange { link, object, touch_links }))
        };
        let rejection = |id: &str| {
            let gap = SceneGap::new(GapSubject::Attached, id, GapExtent::Held);
            SceneRejection { gap: Some(gap), ..SceneRejection::of("a", "another link holds it") }
        };
        let mut missing = MissingObjects::default();
        missing.on_message("topic", Some(&detach("a")), &[rejection("a")]);
        missing.on_message("topic", Some(&detach("")), &[rejection("")]);
        assert_eq!(missing.len(), 2);
        missing.on_message("topic", Some(&detach("")), &[]);
        assert_eq!(missing.len(), 0);
        // something else has released it
        missing.on_message("topic", Some(&detach("a")), &[rejection("a")]);
        missing.close_released(&World::default());
        assert_eq!(missing.len(), 0);
    }

    #[test]
    fn what_is_moved_still_lacks_its_shapes() {
        let mut missing = MissingObjects::default();
        let append = object("a", Operation::Append);
        missing.on_message("topic", Some(&append), &[SceneRejection::of("a", "a mesh")]);
        // a rejected move does not reduce the gap either
        let elsewhere = object("a", Operation::Move);
        missing.on_message("topic", Some(&elsewhere), &[SceneRejection::of("a", "a frame").of_pose()]);
        missing.on_message("topic", Some(&elsewhere), &[]);
        assert_eq!(faults(&missing).len(), 1);
        missing.on_message("topic", Some(&object("a", Operation::Remove)), &[]);
        assert!(faults(&missing).is_empty());
    }

    #[test]
    fn an_object_without_a_name_is_missing_until_all_are_removed() {
        let mut missing = MissingObjects::default();
        let gap = SceneGap::new(GapSubject::Object, "", GapExtent::Shapes);
        let unnamed = SceneRejection { gap: Some(gap), ..SceneRejection::new("id is empty") };
        missing.on_message("topic", Some(&add("")), &[unnamed]);
        missing.on_message("topic", Some(&add("b")), &[]);
        assert_eq!(faults(&missing), ["topic: id is empty"]);
        missing.on_message("topic", Some(&object("", Operation::Remove)), &[]);
        assert!(faults(&missing).is_empty());
    }

    #[test]
    fn an_update_that_came_to_nothing_is_missing_as_if_it_had_been_rejected() {
        let mut missing = MissingObjects::default();
        let objects = ["a", "b"].map(|id| ObjectChange::named(id, Operation::Add)).into();
        let world = WorldChange { objects, octomap: None };
        let update = SceneUpdate::Scene(Box::new(SceneChange { is_diff: true, world, ..Default::default() }));
        missing.note_unused("service", &update, "there is no robot yet");
        assert_eq!(faults(&missing).len(), 2);
        missing.on_message("service", Some(&update), &[]);
        assert!(faults(&missing).is_empty());
    }

    #[test]
    fn an_octomap_is_missing_until_one_comes() {
        let mut missing = MissingObjects::default();
        let octomap = OctomapPlacement {
            frame: String::new(),
            pose_fo: clearance_geometry::math::Pose::identity(),
            shape: None,
            is_blank: false,
        };
        let with = |octomap| {
            let world = WorldChange { objects: Vec::new(), octomap };
            SceneUpdate::Scene(Box::new(SceneChange { is_diff: true, world, ..SceneChange::default() }))
        };
        missing.on_message("topic", None, &[SceneRejection::of_octomap("broken")]);
        missing.on_message("topic", Some(&with(None)), &[]);
        assert_eq!(faults(&missing).len(), 1);
        missing.on_message("topic", Some(&with(Some(octomap))), &[]);
        assert!(faults(&missing).is_empty());
    }

    #[test]
    fn of_very_many_some_are_listed_and_the_rest_counted() {
        let mut missing = MissingObjects::default();
        let rejections: Vec<_> =
            (0..MOST + 7).map(|i| SceneRejection::of(&format!("{i:05}"), "no shapes")).collect();
        missing.on_message("topic", None, &rejections);
        let lines = faults(&missing);
        assert_eq!((lines.len(), missing.gaps.len()), (MOST_LISTED + 1, MOST));
        assert!(
            lines[MOST_LISTED].contains(&format!("and {} more", MOST + 7 - MOST_LISTED)),
            "{}",
            lines[MOST_LISTED]
        );
        let whole = SceneUpdate::Scene(Box::default());
        missing.on_message("topic", Some(&whole), &[]);
        assert!(faults(&missing).is_empty());
    }
}
