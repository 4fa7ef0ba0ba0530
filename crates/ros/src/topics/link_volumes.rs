//! `~/link_volumes`: bounding volumes of the links' hierarchies at a selected level, for `RViz`.

use clearance_checker::{CollisionChecker, LinkVolume};
use clearance_geometry::math::Vector;
use clearance_proximity::VolumeShape;
use ros2_interfaces_jazzy_serde::std_msgs::msg::{ColorRGBA, Header};
use ros2_interfaces_jazzy_serde::visualization_msgs::msg::{Marker, MarkerArray};

use crate::dds::middleware::Middleware;
use crate::dds::middleware_error::MiddlewareError;
use crate::dds::publisher::Publisher;
use crate::dds::quality::Quality;
use crate::dds::type_name::TypeName;
use crate::messages::time_and_geometry::{point_message, pose_message, vector_message};
use crate::names::Names;
use crate::topics::swept_volume_markers::no_markers;

/// Maximum size of a message, in bytes: `RustDDS` loses messages of more than about 250 kB.
const LARGEST_MESSAGE: usize = 175_000;
/// Approximate size of a marker without points, in bytes.
const MARKER_BYTES: usize = 350;
/// Size of a point, in bytes.
const POINT_BYTES: usize = 24;

const BLUE: [f32; 4] = [0.2, 0.5, 0.9, 0.3];

/// Publishes the volumes when they change. Each is given in the frame of its link, which `RViz` moves by tf.
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

    /// Shows the volumes of a level; with `None`, removes all.
    pub fn show(&mut self, checker: &CollisionChecker, level: Option<usize>) {
        let message = match level {
            Some(level) => link_volume_markers(checker, level),
            // none were published: there is nothing to remove
            None if self.last.markers.is_empty() => return,
            None => no_markers(),
        };
        if message != self.last && self.publisher.publish(message.clone()) {
            self.last = message;
        }
    }
}

/// Volumes of the requested level, or of the deepest level above it that is small enough for one message.
fn link_volume_markers(checker: &CollisionChecker, level: usize) -> MarkerArray {
    let volumes = |level| checker.link_volumes(level).collect::<Vec<LinkVolume>>();
    let mut shown = volumes(0);
    for level in 1..=level {
        let deeper = volumes(level);
        if deeper.iter().map(size_in_bytes).sum::<usize>() > LARGEST_MESSAGE {
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

/// Approximate size of a volume in a message.
fn size_in_bytes(volume: &LinkVolume) -> usize {
    match &volume.shape {
        VolumeShape::Triangles(triangles) => MARKER_BYTES + 3 * POINT_BYTES * triangles.len(),
        VolumeShape::Box { .. } | VolumeShape::Ball { .. } => MARKER_BYTES,
    }
}

fn marker(checker: &CollisionChecker, id: i32, volume: &LinkVolume) -> Marker {
    let [r, g, b, a] = BLUE;
    let (kind, scale, points) = match &volume.shape {
        VolumeShape::Box { half_extents } => (Marker::CUBE, 2.0 * half_extents, Vec::new()),
        VolumeShape::Ball { radius } => (Marker::SPHERE, Vector::repeat(2.0 * radius), Vec::new()),
        VolumeShape::Triangles(triangles) => {
            let points = triangles.iter().flatten().map(point_message).collect();
            (Marker::TRIANGLE_LIST, Vector::repeat(1.0), points)
        }
    };
    Marker {
        header: Header { frame_id: checker.robot().link(volume.link).name.clone(), ..Header::default() },
        ns: checker.body_name(volume.body).to_owned(),
        id,
        type_: kind,
        action: Marker::ADD,
        pose: pose_message(&volume.pose_lv),
        scale: vector_message(&scale),
        points,
        color: ColorRGBA { r, g, b, a },
        // the volume follows the link's frame
        frame_locked: true,
        ..Marker::default()
    }
}
