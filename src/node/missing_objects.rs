//! What the scene lacks because messages about it were refused.

use std::collections::BTreeMap;

use crate::monitor::scene::{SceneRefusal, SceneUpdate};

/// Objects remembered at most, so that a hostile network can not fill the memory.
const MOST: usize = 1000;

/// Objects told of at most, the first by name.
const TOLD: usize = 20;

/// Objects that were refused, until something about them is not.
#[derive(Debug, Default)]
pub struct MissingObjects {
    by_name: BTreeMap<String, Missing>,
    /// How many more there were.
    unnamed: usize,
}

#[derive(Debug)]
struct Missing {
    fault: String,
    /// Whether a link was to hold it.
    is_attached: bool,
}

impl MissingObjects {
    /// Heeds a message: what it is about, and what was refused of it.
    pub fn heed(&mut self, source: &str, update: Option<&SceneUpdate>, refusals: &[SceneRefusal]) {
        if let Some(update) = update {
            self.by_name.retain(|id, missing| !update.settles(id, missing.is_attached));
        }
        for refusal in refusals.iter().filter(|refusal| refusal.leaves_out) {
            let Some(id) = &refusal.object else { continue };
            if self.by_name.len() >= MOST && !self.by_name.contains_key(id) {
                self.unnamed += 1;
                continue;
            }
            let is_attached = update.is_some_and(|update| update.attaches(id));
            self.by_name.insert(id.clone(), Missing { fault: format!("{source}: {refusal}"), is_attached });
        }
        if self.by_name.is_empty() {
            self.unnamed = 0;
        }
    }

    /// What is told of them.
    pub fn told(&self) -> impl Iterator<Item = String> {
        let more = (self.by_name.len() + self.unnamed).saturating_sub(TOLD);
        let rest =
            (more > 0).then(|| format!("and {more} more objects are missing, because they were refused"));
        self.by_name.values().take(TOLD).map(|missing| missing.fault.clone()).chain(rest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::scene::{
        AttachedChange, ObjectChange, OctomapPlacement, Operation, SceneChange, WorldChange,
    };

    fn add(id: &str) -> ObjectChange {
        ObjectChange::named(id, Operation::Add)
    }

    fn attach(id: &str) -> SceneUpdate {
        let touch_links = Vec::new();
        SceneUpdate::Attached(Box::new(AttachedChange { link: String::new(), object: add(id), touch_links }))
    }

    fn told(missing: &MissingObjects) -> Vec<String> {
        missing.told().collect()
    }

    #[test]
    fn an_object_is_missing_until_something_about_it_is_right() {
        let mut missing = MissingObjects::default();
        let object = |id| SceneUpdate::Object(Box::new(add(id)));
        missing.heed("topic", Some(&object("a")), &[SceneRefusal::of("a", "no shapes")]);
        missing.heed("topic", Some(&attach("held")), &[SceneRefusal::of("held", "no link")]);
        missing.heed("topic", Some(&object("b")), &[]);
        assert_eq!(told(&missing), ["topic: object 'a': no shapes", "topic: object 'held': no link"]);
        // who lets go of all that links hold says nothing of the world
        missing.heed("topic", Some(&object("c")), &[SceneRefusal::of("c", "no shapes")]);
        let mut all = AttachedChange { link: String::new(), object: add(""), touch_links: Vec::new() };
        all.object.operation = Operation::Remove;
        missing.heed("topic", Some(&SceneUpdate::Attached(Box::new(all))), &[]);
        assert_eq!(told(&missing), ["topic: object 'a': no shapes", "topic: object 'c': no shapes"]);
        missing.heed("topic", Some(&attach("held")), &[SceneRefusal::of("held", "no link")]);
        // a world says nothing of what links hold
        missing.heed("topic", Some(&SceneUpdate::World(Box::default())), &[]);
        assert_eq!(told(&missing), ["topic: object 'held': no link"]);
        missing.heed("topic", Some(&attach("held")), &[]);
        assert!(told(&missing).is_empty());
    }

    #[test]
    fn an_octomap_is_missing_until_one_comes() {
        let mut missing = MissingObjects::default();
        let id = crate::monitor::scene::OCTOMAP;
        let octomap =
            OctomapPlacement { frame: String::new(), pose_fo: crate::math::Pose::identity(), shape: None };
        let with = |octomap| {
            let world = WorldChange { objects: Vec::new(), octomap };
            SceneUpdate::Scene(Box::new(SceneChange { is_diff: true, world, ..SceneChange::default() }))
        };
        missing.heed("topic", None, &[SceneRefusal::of(id, "broken")]);
        missing.heed("topic", Some(&with(None)), &[]);
        assert_eq!(told(&missing).len(), 1);
        missing.heed("topic", Some(&with(Some(octomap))), &[]);
        assert!(told(&missing).is_empty());
    }

    #[test]
    fn of_very_many_some_are_told_and_the_rest_counted() {
        let mut missing = MissingObjects::default();
        let refusals: Vec<_> =
            (0..MOST + 7).map(|i| SceneRefusal::of(&format!("{i:05}"), "no shapes")).collect();
        missing.heed("topic", None, &refusals);
        let lines = told(&missing);
        assert_eq!((lines.len(), missing.by_name.len()), (TOLD + 1, MOST));
        assert!(lines[TOLD].contains(&format!("and {} more", MOST + 7 - TOLD)), "{}", lines[TOLD]);
        missing.heed("topic", Some(&SceneUpdate::World(Box::default())), &[]);
        assert!(told(&missing).is_empty());
    }
}
