//! Known gaps in the world: rejected parts of messages, lost messages, blind sensors.

use clearance_monitor::Reason;

use crate::parameters::parameter_set::Parameters;
use crate::scene::loader_scene::{LoaderScene, OCTOMAP_SOURCE};

impl LoaderScene {
    /// Records that a part of the world could not be taken into use, for a reason that is not specific to one object.
    pub fn note_failure(&mut self, fault: &str) {
        self.failure = Some(fault.to_owned());
    }

    /// Why the world is incomplete; `None` if it is complete, or if the parameters treat the fault as a warning only.
    #[must_use]
    pub fn incomplete(&self, parameters: &Parameters) -> Option<Reason> {
        let blind = || self.blind().filter(|_| parameters.blind_makes_unknown());
        let rejected = || self.rejected().filter(|_| parameters.rejected_makes_unknown());
        let lost = || self.lost.reason().filter(|_| parameters.lost_makes_unknown());
        blind().or_else(rejected).or_else(lost)
    }

    /// Sensors whose last message shows nothing of the environment, with the cause.
    fn blind_sensors(&self) -> impl Iterator<Item = (&str, &str)> {
        let of_clouds = self
            .clouds
            .iter()
            .filter_map(|(topic, cloud)| Some((topic.as_str(), cloud.report.blind.as_deref()?)));
        of_clouds.chain(self.octomap_state.why_blind.as_deref().map(|cause| (OCTOMAP_SOURCE, cause)))
    }

    fn blind(&self) -> Option<Reason> {
        let mut blind = self.blind_sensors();
        let (source, cause) = blind.next()?;
        Some(Reason::BlindCloud { source: source.to_owned(), cause: cause.to_owned(), more: blind.count() })
    }

    fn rejected(&self) -> Option<Reason> {
        let others = self.dropped_objects.iter().chain(&self.failure).cloned();
        let fault = self.missing.faults().chain(others.clone()).chain(self.cloud_faults()).next()?;
        let more = self.missing.len() + others.count() + self.cloud_faults().count() - 1;
        Some(Reason::RejectedObstacle { fault, more })
    }

    fn cloud_faults(&self) -> impl Iterator<Item = String> {
        self.clouds.iter().filter_map(|(topic, cloud)| {
            Some(format!("the last cloud of '{topic}' was not taken: {}", cloud.report.fault.as_ref()?))
        })
    }

    /// Rejected parts of the last messages, the parts that are still missing in the scene because of rejections, and publishers from
    /// which the node cannot receive.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let missing = self.missing.faults().filter(|fault| !self.faults.contains(fault));
        let blind = self.blind_sensors().map(|(source, cause)| {
            format!("the last message of '{source}' shows nothing of the environment: {cause}")
        });
        self.faults
            .iter()
            .chain(&self.ineffective)
            .chain(&self.invalid_parts)
            .chain(&self.dropped_objects)
            .chain(self.failure.iter().filter(|failure| !self.faults.contains(failure)))
            .cloned()
            .chain(self.lost.warnings())
            .chain(missing)
            .chain(self.cloud_faults())
            .chain(blind)
            .chain(self.unreceivable.iter().cloned())
            .collect()
    }
}
