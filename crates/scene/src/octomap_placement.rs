//! Converts octomap messages and octrees to the octomap of a scene: its frame, pose and occupied cells.

use clearance_geometry::Shape;
use clearance_geometry::math::Pose;

use super::{Octomap, OctomapPlacement};

/// The only tree type accepted in messages, as in MoveIt.
const KIND: &str = "OcTree";

/// The fields of an `octomap_msgs/Octomap`.
#[derive(Clone, Copy, Debug)]
pub struct OctomapMessage<'m> {
    /// Tree type, such as `OcTree`.
    pub id: &'m str,
    /// True if cells are stored as free or occupied, without probabilities.
    pub binary: bool,
    /// Edge length (m) of the smallest cells.
    pub resolution: f64,
    /// The serialised tree.
    pub data: &'m [u8],
}

impl OctomapMessage<'_> {
    /// True if a scene with this message does not change its octomap. As in MoveIt, an id without data removes the octomap.
    #[must_use]
    pub fn is_absent(&self) -> bool {
        self.data.is_empty() && self.id.is_empty()
    }

    /// The octree with a pose in a frame.
    ///
    /// # Errors
    /// If it cannot be read; the message names the field.
    pub fn placed(
        &self,
        frame: String,
        pose_fo: Pose,
        unknown_is_occupied: bool,
    ) -> Result<OctomapPlacement, String> {
        if self.id != KIND {
            return Err(format!("id: trees of type '{}' are not taken; {KIND} are", self.id.escape_debug()));
        }
        if self.data.is_empty() {
            return Ok(OctomapPlacement { frame, pose_fo, shape: None, is_blank: true });
        }
        let octomap = Octomap::from_message(self.binary, self.id, self.resolution, self.data);
        let octomap = octomap.map_err(|error| error.to_string())?;
        OctomapPlacement::of(&octomap, frame, pose_fo, unknown_is_occupied)
    }
}

impl OctomapPlacement {
    /// An octree with a pose in a frame.
    ///
    /// # Errors
    /// If it has too many occupied cells.
    pub fn of(
        octomap: &Octomap,
        frame: String,
        pose_fo: Pose,
        unknown_is_occupied: bool,
    ) -> Result<Self, String> {
        let voxels = octomap.to_voxels(unknown_is_occupied).map_err(|error| error.to_string())?;
        let is_blank = !octomap.has_known_cells();
        Ok(Self { frame, pose_fo, shape: voxels.map(Shape::Voxels), is_blank })
    }
}
