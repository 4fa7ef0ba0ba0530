//! Warnings about publishers of the world's topics from which this node cannot receive: their type or quality of service
//! is another one.

use std::time::{Duration, Instant};

use smol::Timer;

use crate::names::{FullName, Names};
use crate::scene::loader_command::LoaderCommand;
use crate::topics::scene_requester::RequestContext;

/// Time between two comparisons with the discovered publishers.
const PERIOD: Duration = Duration::from_secs(1);

/// Largest number of warnings.
const MOST_LISTED: usize = 20;

/// Topics of obstacles and frames, but for point clouds.
const TOPICS: [&str; 9] = [
    "planning_scene",
    "planning_scene_world",
    "collision_object",
    "attached_collision_object",
    "~/obstacle_states",
    "octomap_binary",
    "octomap_full",
    "tf",
    "tf_static",
];

/// Reports these publishers to the loader whenever they change. Returns when the loader has ended.
pub async fn report(RequestContext { middleware, names, sender }: RequestContext<'_>) {
    let mut reported = Vec::new();
    loop {
        Timer::after(PERIOD).await;
        let clouds = sender.shared.store.get().point_cloud_topics;
        let mut found = middleware.unreceivable_publishers(&topics(names, &clouds));
        let more = found.len().saturating_sub(MOST_LISTED);
        found.truncate(MOST_LISTED);
        if more > 0 {
            found.push(format!(
                "and {more} more kinds of publishers of the world are incompatible with this node"
            ));
        }
        if found == reported {
            continue;
        }
        reported.clone_from(&found);
        sender.note_update(Instant::now());
        if !sender.send(LoaderCommand::Scene(Box::new(sender.unreceivable(found)))).await {
            return;
        }
    }
}

fn topics(names: &Names, clouds: &[String]) -> Vec<FullName> {
    let names_of_topics = TOPICS.into_iter().chain(clouds.iter().map(String::as_str));
    // a name that is invalid was logged when it was subscribed to
    names_of_topics.filter_map(|name| names.resolve(name).ok()).collect()
}
