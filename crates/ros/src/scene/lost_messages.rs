//! Scene messages that were lost on the network, so that their content is unknown.

use std::collections::BTreeMap;

use clearance_monitor::Reason;
use clearance_scene::SceneUpdate;

use crate::recording::step::SceneSource;

type Counts = BTreeMap<&'static str, u64>;

/// Number of lost messages per topic, until a later update replaces everything that they may have changed.
#[derive(Debug, Default)]
pub struct LostMessages {
    now: Counts,
    /// Counts for the scene that is in use; `since` counts the messages that were lost after it.
    in_force: Counts,
    since: Counts,
}

impl LostMessages {
    pub fn note(&mut self, topic: &'static str, count: u64) {
        if count > 0 {
            add(&mut self.now, topic, count);
            add(&mut self.since, topic, count);
        }
    }

    /// Clears the counts of the topics whose content this update replaces completely.
    pub fn on_update(&mut self, update: &SceneUpdate) {
        match update {
            // such an update contains no attached objects, collision matrices or paddings
            SceneUpdate::World(_) => self.on_world_replaced(),
            whole if whole.is_whole_of_robot() => self.now.clear(),
            // such an update does not change attached objects
            SceneUpdate::Scene(scene) if !scene.is_diff => self.on_world_replaced(),
            _ => {}
        }
    }

    /// All obstacles were replaced.
    fn on_world_replaced(&mut self) {
        let of_world =
            [SceneSource::CollisionObject, SceneSource::ObstacleStates, SceneSource::PlanningSceneWorld]
                .map(SceneSource::name);
        self.now.retain(|topic, _| !of_world.contains(topic));
    }

    /// The latest updates are now in use.
    pub fn note_in_use(&mut self) {
        self.in_force = self.now.clone();
        self.since.clear();
    }

    /// The latest updates were not taken into use: restores the previous counts.
    pub fn restore(&mut self) {
        self.now = self.in_force.clone();
        for (topic, count) in &self.since {
            add(&mut self.now, topic, *count);
        }
    }

    /// Why the world is incomplete, if messages were lost.
    #[must_use]
    pub fn reason(&self) -> Option<Reason> {
        let topics: Vec<String> =
            self.now.iter().map(|(topic, count)| format!("{count} of {topic}")).collect();
        (!topics.is_empty()).then_some(Reason::LostMessages { topics })
    }

    /// One warning per topic with lost messages.
    pub fn warnings(&self) -> impl Iterator<Item = String> {
        self.now.iter().map(|(topic, count)| {
            format!("{topic}: {count} messages were lost: what they changed is missing here until a whole scene comes")
        })
    }
}

fn add(counts: &mut Counts, topic: &'static str, count: u64) {
    let known = counts.entry(topic).or_default();
    *known = known.saturating_add(count);
}

#[cfg(test)]
mod tests {
    use super::*;

    use clearance_scene::SceneChange;

    fn warnings(lost: &LostMessages) -> Vec<String> {
        lost.warnings().map(|text| text.split(" messages").next().unwrap_or_default().to_owned()).collect()
    }

    fn scene(is_diff: bool) -> SceneUpdate {
        SceneUpdate::Scene(Box::new(SceneChange { is_diff, ..SceneChange::default() }))
    }

    #[test]
    fn lost_messages_are_counted_by_topic_until_their_content_is_replaced() {
        let mut lost = LostMessages::default();
        let [object, attached] =
            [SceneSource::CollisionObject, SceneSource::AttachedCollisionObject].map(SceneSource::name);
        for (topic, count) in [(object, 2), ("a", 0), (object, u64::MAX), (attached, 1)] {
            lost.note(topic, count);
        }
        let of_objects = format!("collision_object: {}", u64::MAX);
        assert_eq!(warnings(&lost), ["attached_collision_object: 1", &of_objects]);
        lost.on_update(&scene(true));
        assert_eq!(warnings(&lost).len(), 2);
        lost.on_update(&SceneUpdate::World(Box::default()));
        assert_eq!(warnings(&lost), ["attached_collision_object: 1"]);
        lost.on_update(&scene(false));
        assert!(warnings(&lost).is_empty());
    }

    #[test]
    fn a_scene_that_is_not_in_force_replaces_nothing() {
        let mut lost = LostMessages::default();
        lost.note("a", 2);
        lost.note_in_use();
        lost.note("b", 1);
        lost.on_update(&scene(false));
        lost.restore();
        assert_eq!(warnings(&lost), ["a: 2", "b: 1"]);
        lost.on_update(&scene(false));
        lost.note_in_use();
        lost.restore();
        assert!(warnings(&lost).is_empty());
    }
}
