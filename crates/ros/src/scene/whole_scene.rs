//! Tracks whether the complete scene was received, where the parameters require it: from messages, or, if a
//! service is queried, from that service alone.

use clearance_monitor::WorldSource;
use clearance_scene::SceneUpdate;

use crate::parameters::parameter_set::Parameters;
use crate::recording::step::SceneSource;

/// Name of the awaited source, if no service is queried.
const ANY_SOURCE: &str = "planning_scene, apply_planning_scene or planning_scene_world";

/// Completeness of the received scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
enum Completeness {
    #[default]
    Nothing,
    /// All obstacles.
    World,
    /// The scene of the queried service.
    Response,
}

/// Completeness of the received messages, and of the part that is in use.
#[derive(Debug, Default)]
pub struct WholeScene {
    received: Completeness,
    in_force: Completeness,
    /// Queried service; empty if there is none.
    service: String,
}

impl WholeScene {
    /// Sets the service to query. A new service resets the completeness: scenes from other sources do not replace its
    /// response.
    pub fn set_service(&mut self, service: &str) {
        if self.service != service {
            service.clone_into(&mut self.service);
            if !service.is_empty() {
                (self.received, self.in_force) = (Completeness::Nothing, Completeness::Nothing);
            }
        }
    }

    /// Processes an update that was received from this topic or service.
    pub fn on_update(&mut self, update: &SceneUpdate, source: &str) {
        self.received = self.received.max(match update {
            part if !part.is_whole() => Completeness::Nothing,
            _ if source == SceneSource::GetPlanningScene.name() => Completeness::Response,
            _ => Completeness::World,
        });
    }

    /// The latest updates are now in use.
    pub fn note_in_use(&mut self) {
        self.in_force = self.received;
    }

    /// The latest updates were not taken into use.
    pub fn restore(&mut self) {
        self.received = self.in_force;
    }

    /// Source that must still send the scene, if the parameters require one.
    #[must_use]
    pub fn awaited(&self, parameters: &Parameters) -> Option<WorldSource> {
        let (needed, source) =
            match (parameters.planning_scene_service.as_str(), parameters.require_planning_scene) {
                ("", false) => return None,
                ("", true) => (Completeness::World, ANY_SOURCE),
                (service, _) => (Completeness::Response, service),
            };
        (self.received < needed).then(|| WorldSource {
            name: source.to_owned(),
            seen: None,
            ttl: f64::INFINITY,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clearance_scene::SceneChange;

    fn scene(is_diff: bool) -> SceneUpdate {
        SceneUpdate::Scene(Box::new(SceneChange { is_diff, ..SceneChange::default() }))
    }

    const TOPIC: &str = "planning_scene";
    const SERVICE: &str = "planning_scene_service";

    fn asking(service: &str, require_planning_scene: bool) -> Parameters {
        let planning_scene_service = service.to_owned();
        Parameters { planning_scene_service, require_planning_scene, ..Parameters::default() }
    }

    fn awaited(whole: &WholeScene, parameters: &Parameters) -> Option<String> {
        whole.awaited(parameters).map(|source| source.name)
    }

    #[test]
    fn a_world_is_enough_unless_a_service_is_queried() {
        let mut whole = WholeScene::default();
        assert_eq!(awaited(&whole, &asking("", false)), None);
        whole.on_update(&scene(true), TOPIC);
        assert_eq!(awaited(&whole, &asking("", true)).as_deref(), Some(ANY_SOURCE));
        whole.on_update(&SceneUpdate::World(Box::default()), "planning_scene_world");
        assert_eq!(awaited(&whole, &asking("", true)), None);
        // messages of topics may be older than the response, or have a part of the scene
        for source in [TOPIC, "apply_planning_scene"] {
            whole.on_update(&scene(false), source);
            assert_eq!(awaited(&whole, &asking("/a", false)).as_deref(), Some("/a"));
        }
        whole.on_update(&scene(false), SERVICE);
        assert_eq!(awaited(&whole, &asking("/a", true)), None);
    }

    #[test]
    fn scenes_that_are_not_in_force_or_precede_another_service_do_not_count() {
        let (mut whole, a, b) = (WholeScene::default(), asking("/a", false), asking("/b", false));
        whole.set_service("/a");
        whole.on_update(&scene(false), SERVICE);
        whole.restore();
        assert!(awaited(&whole, &a).is_some());
        whole.on_update(&scene(false), SERVICE);
        whole.note_in_use();
        whole.restore();
        whole.set_service("/a");
        assert_eq!(awaited(&whole, &a), None);
        whole.set_service("/b");
        assert!(awaited(&whole, &b).is_some());
    }
}
