//! The octree of a world file, kept so that it can be sent in messages.

use super::{Octomap, OctomapMessage};

/// The octree of a world file, as the fields of an `octomap_msgs/Octomap` whose `id` is `OcTree` and whose `binary` is true.
#[derive(Clone, Debug, PartialEq)]
pub struct FileOctree {
    /// Edge length (m) of the smallest cells.
    pub resolution: f64,
    /// The serialised tree. Unknown space that counts as occupied is occupied here.
    pub data: Vec<u8>,
}

impl FileOctree {
    pub(super) fn of(octomap: &Octomap, unknown_is_occupied: bool) -> Self {
        Self { resolution: octomap.resolution(), data: octomap.to_binary(unknown_is_occupied) }
    }

    /// The octree of an octomap message in a file; `None` if it has no data or cannot be read.
    pub(super) fn of_message(message: &OctomapMessage, unknown_is_occupied: bool) -> Option<Self> {
        let OctomapMessage { id, binary, resolution, data } = *message;
        if data.is_empty() {
            return None;
        }
        let octomap = Octomap::from_message(binary, id, resolution, data).ok()?;
        Some(Self::of(&octomap, unknown_is_occupied))
    }
}
