//! `~/link_volumes`: boxes of the robot's bounding volume hierarchies at a selected level, for `RViz`.

use clearance_checker::{CollisionChecker, LinkVolume};
use ros2_interfaces_jazzy_serde::std_msgs::msg::{ColorRGBA, Header};
use ros2_interfaces_jazzy_serde::visualization_msgs::msg::{Marker, MarkerArray};

use crate::dds::middleware::Middleware;
use crate::dds::middleware_error::MiddlewareError;
use crate::dds::publisher::Publisher;
use crate::dds::quality::Quality;
use crate::dds::type_name::TypeName;
use crate::messages::time_and_geometry::{pose_message, vector_message};
use crate::names::Names;
use crate::topics::swept_volume_markers::no_markers;

/// Maximum number of boxes in one message (about 350 bytes each): `RustDDS` loses messages of more than about 250 kB.
const BOXES_SHOWN: usize = 500;

const BLUE: [f32; 4] = [0.2, 0.5, 0.9, 0.3];

/// Publishes the boxes when they change. Each box is given in the frame of its link, which `RViz` moves by tf.
pub struct LinkVolumes {
    publisher: Publisher<MarkerArray>,
    last: MarkerArray,
}

impl LinkVolumes {
    pub fn open(middleware: &Middleware, names: &Names) -> Result<Self, MiddlewareError> {
        let kind = TypeName::new("visualization_msgs", "MarkerArray");
        let name = names.resolve("~/link_volumes")?;
        let publisher = middleware.publisher(&name, kind, Quality::Latched)?;
        Ok(Self { publisher, last: MarkerArray::default() })
    }

    /// Shows the boxes of a level; with `None`, removes all boxes.
    pub fn show(&mut self, checker: &CollisionChecker, level: Option<usize>) {
        let message = match level {
            Some(level) => link_volume_markers(checker, level),
            // no boxes were published: there is nothing to remove
            None if self.last.markers.is_empty() => return,
            None => no_markers(),
        };
        if message != self.last && self.publisher.publish(message.clone()) {
            self.last = message;
        }
    }
}

/// Boxes of the requested level, or of the deepest level above it that is small enough for one message.
fn link_volume_markers(checker: &CollisionChecker, level: usize) -> MarkerArray {
    let volumes = |level| checker.link_volumes(level).collect::<Vec<LinkVolume>>();
    let mut shown = volumes(0);
    for level in 1..=level {
        let deeper = volumes(level);
        if deeper.len() > BOXES_SHOWN {
            log::info!(
                "level {level} has {} link volumes: those of level {} are shown",
                deeper.len(),
                level - 1
            );
            break;
        }
        if deeper == shown {
            break;
        }
        shown = deeper;
    }
    let mut array = no_markers();
    array.markers.extend((0..).zip(shown).map(|(id, volume)| marker(checker, id, &volume)));
    array
}

fn marker(checker: &CollisionChecker, id: i32, volume: &LinkVolume) -> Marker {
    let [r, g, b, a] = BLUE;
    Marker {
        header: Header { frame_id: checker.robot().link(volume.link).name.clone(), ..Header::default() },
        ns: checker.body_name(volume.body).to_owned(),
        id,
        type_: Marker::CUBE,
        action: Marker::ADD,
        pose: pose_message(&volume.pose_lv),
        scale: vector_message(&(2.0 * volume.half_extents)),
        color: ColorRGBA { r, g, b, a },
        // the box follows the link's frame
        frame_locked: true,
        ..Marker::default()
    }
}
