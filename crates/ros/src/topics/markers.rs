//! Markers for `RViz`: colliding links, lines between near bodies, and contacts.

mod contact_markers;

use clearance_checker::{PairDistance, PairKind};
use clearance_geometry::math::{Extremes, Point, Pose, Vector};
use clearance_geometry::{PointCloud, Primitive, Shape, TriangleMesh, Voxels};
use clearance_monitor::{CheckedState, Evaluation, Revision};
use clearance_robot::{LinkId, MeshSource};
use clearance_scene::AttachedId;
use clearance_scene::BodyId;
use ros2_interfaces_jazzy_serde::builtin_interfaces::msg::Duration as DurationMessage;
use ros2_interfaces_jazzy_serde::geometry_msgs::msg::Point as PointMessage;
use ros2_interfaces_jazzy_serde::std_msgs::msg::{ColorRGBA, Header};
use ros2_interfaces_jazzy_serde::visualization_msgs::msg::{Marker, MarkerArray};
use std::collections::BTreeSet;
use std::time::Duration;

use crate::messages::collision_state::header;
use crate::messages::time_and_geometry::point_message;
use crate::messages::time_and_geometry::pose_message;
use crate::messages::time_and_geometry::vector_message;

const COLLIDING_LINKS: &str = "colliding_links";
const WITNESS_LINES: &str = "witness_lines";
const LEAST_DISTANCE: &str = "least_distance";
const DISTANCES: &str = "distances";
const SELF_DISTANCE: &str = "self_distance";
const WORLD_DISTANCE: &str = "world_distance";
const COLLIDING_ATTACHED: &str = "colliding_attached_objects";

const RED: [f32; 4] = [0.9, 0.1, 0.1, 0.8];
const YELLOW: [f32; 4] = [1.0, 0.8, 0.1, 1.0];
const WHITE: [f32; 4] = [1.0, 1.0, 1.0, 1.0];
const BLUE: [f32; 4] = [0.31, 0.51, 0.74, 1.0];
const ORANGE: [f32; 4] = [0.85, 0.51, 0.17, 1.0];

/// Width of a witness line (m).
const LINE_WIDTH: f64 = 0.004;
/// Height of the text (m).
const TEXT_HEIGHT: f64 = 0.04;
const SMALL_TEXT_HEIGHT: f64 = 0.02;
/// Maximum number of triangles in one message (72 bytes each): `RustDDS` loses messages of more than about 250 kB.
const TRIANGLES_SHOWN: usize = 2000;
const LINES_SHOWN: usize = 1000;
/// Maximum number of lines with a distance as text. The nearest pairs have priority.
const DISTANCES_SHOWN: usize = 20;
/// Maximum number of points of a cloud in one message (24 bytes each).
const POINTS_SHOWN: usize = 4000;

/// Markers that are currently displayed, so that they can be deleted.
#[derive(Debug, Default)]
pub struct MarkerDisplay {
    shown: BTreeSet<(&'static str, i32)>,
}

impl MarkerDisplay {
    /// Markers of an evaluation, and deletions of the markers that are no longer valid. Markers expire after
    /// `lifetime`, so that none remain when the node has ended.
    pub fn update(&mut self, evaluation: &Evaluation, lifetime: Duration) -> MarkerArray {
        let mut scene = Scene::new(header(evaluation), lifetime);
        if let (Some(revision), Some(checked_state)) = (&evaluation.revision, &evaluation.checked_state) {
            scene.add_colliding_links(revision, checked_state);
            scene.add_colliding_attached(revision, checked_state);
            scene.add_witness_lines(checked_state);
            scene.add_nearest_of_kinds(checked_state);
            scene.add_contacts(checked_state);
        }
        let shown: BTreeSet<_> = scene.markers.iter().map(|(ns, m)| (*ns, m.id)).collect();
        let gone: Vec<_> = self.shown.difference(&shown).copied().collect();
        self.shown = shown;
        scene.finish(&gone)
    }

    /// Deletions of all markers.
    pub fn clear(&mut self, evaluation: &Evaluation) -> MarkerArray {
        let gone: Vec<_> = std::mem::take(&mut self.shown).into_iter().collect();
        Scene::new(header(evaluation), Duration::ZERO).finish(&gone)
    }
}

/// Builder of a marker array.
struct Scene {
    header: Header,
    lifetime: DurationMessage,
    markers: Vec<(&'static str, Marker)>,
    triangles_left: usize,
    /// Namespace of the geometry that is added next.
    geometry: &'static str,
}

impl Scene {
    fn new(header: Header, lifetime: Duration) -> Self {
        let lifetime = DurationMessage {
            sec: i32::try_from(lifetime.as_secs()).unwrap_or(i32::MAX),
            nanosec: lifetime.subsec_nanos(),
        };
        Self {
            header,
            lifetime,
            markers: Vec::new(),
            triangles_left: TRIANGLES_SHOWN,
            geometry: COLLIDING_LINKS,
        }
    }

    fn add_colliding_links(&mut self, revision: &Revision, checked_state: &CheckedState) {
        let robot = revision.checker.robot();
        self.geometry = COLLIDING_LINKS;
        let links: BTreeSet<LinkId> = (colliding_bodies(checked_state))
            .filter_map(|body| match body {
                BodyId::Link(link) => Some(link),
                BodyId::Attached(_) | BodyId::Obstacle(_) => None,
            })
            .collect();
        for link in links {
            let pose_rl = checked_state.poses.pose(link);
            for (index, collision) in robot.link(link).collisions.iter().enumerate() {
                let source = collision.mesh_source.as_ref();
                let pose_rs = pose_rl * collision.pose_ls;
                self.add_shape(first_id(link.index(), index), &pose_rs, &collision.shape, source);
            }
        }
    }

    fn add_colliding_attached(&mut self, revision: &Revision, checked_state: &CheckedState) {
        let checker = &revision.checker;
        self.geometry = COLLIDING_ATTACHED;
        let attached: BTreeSet<AttachedId> = (colliding_bodies(checked_state))
            .filter_map(|body| match body {
                BodyId::Attached(id) => Some(id),
                BodyId::Link(_) | BodyId::Obstacle(_) => None,
            })
            .collect();
        for id in attached {
            let object = checker.world().attached_object(id);
            let Some(link) = checker.robot().link_by_name(&object.link) else { continue };
            let pose_ro = checked_state.poses.pose(link) * object.pose_lo;
            for (index, placed) in object.shapes.iter().enumerate() {
                self.add_shape(
                    first_id(id.0 as usize, index),
                    &(pose_ro * placed.pose_os),
                    &placed.shape,
                    None,
                );
            }
        }
    }

    fn add_shape(&mut self, first_id: usize, pose_rs: &Pose, shape: &Shape, source: Option<&MeshSource>) {
        match shape {
            Shape::Primitive(primitive) => self.add_primitive(first_id, pose_rs, primitive),
            Shape::Mesh(mesh) => match source.and_then(resource) {
                Some((uri, scale)) => self.add_mesh_resource(first_id, pose_rs, uri, &scale),
                None => self.add_mesh(first_id, pose_rs, mesh),
            },
            Shape::Points(cloud) => self.add_points(first_id, pose_rs, cloud),
            Shape::Voxels(voxels) => self.add_voxels(first_id, pose_rs, voxels),
            // a plane is infinite: no marker can show it
            Shape::Plane(_) => {}
        }
    }

    fn add_primitive(&mut self, id: usize, pose_rs: &Pose, primitive: &Primitive) {
        let ball = |radius: f64| Vector::repeat(2.0 * radius);
        let round = |radius, half_length: f64| Vector::new(2.0 * radius, 2.0 * radius, 2.0 * half_length);
        match *primitive {
            Primitive::Box { half_extents } => {
                self.add_solid(id, Marker::CUBE, pose_rs, 2.0 * Vector::from(half_extents));
            }
            Primitive::Sphere { radius } => {
                self.add_solid(id, Marker::SPHERE, pose_rs, ball(radius));
            }
            Primitive::Cylinder { radius, half_length } => {
                self.add_solid(id, Marker::CYLINDER, pose_rs, round(radius, half_length));
            }
            Primitive::Cone { radius, half_length } => {
                let corners = cone_corners(radius, half_length);
                self.add_triangles(id, pose_rs, corners.iter().map(point_message).collect());
            }
            Primitive::Capsule { radius, half_length } => {
                self.add_solid(id, Marker::CYLINDER, pose_rs, round(radius, half_length));
                for (end, z) in [(1, half_length), (2, -half_length)] {
                    let pose = pose_rs * Pose::translation(0.0, 0.0, z);
                    self.add_solid(id + end, Marker::SPHERE, &pose, ball(radius));
                }
            }
        }
    }

    fn add_solid(&mut self, id: usize, kind: i32, pose_rs: &Pose, size: Vector) {
        self.add(self.geometry, id, kind, RED, |marker| {
            marker.pose = pose_message(pose_rs);
            marker.scale = vector_message(&size);
        });
    }

    /// Adds a mesh by its resource name, which `RViz` loads.
    fn add_mesh_resource(&mut self, id: usize, pose_rs: &Pose, uri: String, scale: &Vector) {
        self.add(self.geometry, id, Marker::MESH_RESOURCE, RED, |marker| {
            marker.pose = pose_message(pose_rs);
            marker.scale = vector_message(scale);
            marker.mesh_resource = uri;
        });
    }

    /// Adds a mesh as triangles, or as its bounding box if it has too many.
    fn add_mesh(&mut self, id: usize, pose_rs: &Pose, mesh: &TriangleMesh) {
        let triangles = mesh.triangles().len();
        if triangles > self.triangles_left {
            let (lo, hi) = mesh.bounds();
            let centre = nalgebra::center(&lo, &hi);
            let pose = pose_rs * Pose::from_parts(centre.coords.into(), nalgebra::one());
            self.add_solid(id, Marker::CUBE, &pose, hi - lo);
            return;
        }
        self.triangles_left -= triangles;
        let corner = |&v: &u32| point_message(&mesh.vertices()[v as usize]);
        self.add_triangles(id, pose_rs, mesh.triangles().iter().flatten().map(corner).collect());
    }

    /// Adds a triangle list: three points per triangle.
    fn add_triangles(&mut self, id: usize, pose_rs: &Pose, points: Vec<PointMessage>) {
        self.add(self.geometry, id, Marker::TRIANGLE_LIST, RED, |marker| {
            marker.pose = pose_message(pose_rs);
            marker.scale = vector_message(&Vector::repeat(1.0));
            marker.points = points;
        });
    }

    /// Adds the points of a cloud, or an evenly spaced subset if there are too many.
    fn add_points(&mut self, id: usize, pose_rs: &Pose, cloud: &PointCloud) {
        let step = cloud.points().len().div_ceil(POINTS_SHOWN);
        let shown =
            cloud.points().iter().step_by(step).map(|p| point_message(&Point::from(p.map(f64::from))));
        let points: Vec<PointMessage> = shown.collect();
        self.add(self.geometry, id, Marker::SPHERE_LIST, RED, |marker| {
            marker.pose = pose_message(pose_rs);
            // a point of size zero would be invisible
            marker.scale = vector_message(&Vector::repeat((2.0 * cloud.radius()).greater(LINE_WIDTH)));
            marker.points = points;
        });
    }

    /// Adds the bounding box of all voxels, because all cubes of a cube list have the same size.
    fn add_voxels(&mut self, id: usize, pose_rs: &Pose, voxels: &Voxels) {
        let (lo, hi) = voxels.bounds();
        let pose = pose_rs * Pose::from_parts(nalgebra::center(&lo, &hi).coords.into(), nalgebra::one());
        self.add_solid(id, Marker::CUBE, &pose, hi - lo);
    }

    fn add_witness_lines(&mut self, checked_state: &CheckedState) {
        let report = &checked_state.report;
        let nearest = report.nearest.as_ref();
        let near = (report.pair_distances.iter().take(LINES_SHOWN))
            .chain(nearest.filter(|n| !report.pair_distances.contains(n)))
            .filter(|pair| pair.distance > 0.0);
        let ends: Vec<PointMessage> =
            near.flat_map(|pair| pair.witness_points.each_ref().map(point_message)).collect();
        if !ends.is_empty() {
            self.add(WITNESS_LINES, 0, Marker::LINE_LIST, YELLOW, |marker| {
                marker.scale.x = LINE_WIDTH;
                marker.points = ends;
            });
        }
        if let Some(nearest) = nearest.filter(|nearest| nearest.distance > 0.0) {
            self.add_distance((LEAST_DISTANCE, 0), nearest, TEXT_HEIGHT);
        }
        let is_other = |pair: &&PairDistance| pair.distance > 0.0 && Some(*pair) != nearest;
        let mut others: Vec<_> = report.pair_distances.iter().filter(is_other).collect();
        others.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        for (id, pair) in others.into_iter().take(DISTANCES_SHOWN).enumerate() {
            self.add_distance((DISTANCES, id), pair, SMALL_TEXT_HEIGHT);
        }
    }

    /// Adds the nearest self pair and the nearest world pair, also beyond the influence distance: a line wider than the
    /// witness lines, and the distance as text below its middle.
    fn add_nearest_of_kinds(&mut self, checked_state: &CheckedState) {
        let kinds = [
            (PairKind::SelfPair, SELF_DISTANCE, "self", BLUE),
            (PairKind::WorldPair, WORLD_DISTANCE, "world", ORANGE),
        ];
        for (kind, namespace, word, colour) in kinds {
            let nearest = checked_state.report.known_nearest_of(kind);
            let Some(pair) = nearest.filter(|pair| pair.distance > 0.0) else { continue };
            self.add(namespace, 0, Marker::LINE_LIST, colour, |marker| {
                marker.scale.x = 2.0 * LINE_WIDTH;
                marker.points = pair.witness_points.each_ref().map(point_message).to_vec();
            });
            let text = format!("{word} {:.3} m", pair.distance);
            let place = middle(pair) - Vector::z() * TEXT_HEIGHT;
            self.add_text((namespace, 1), &place, TEXT_HEIGHT, text);
        }
    }

    /// Adds the distance of a pair as text above the middle of its line.
    fn add_distance(&mut self, marker: (&'static str, usize), pair: &PairDistance, height: f64) {
        let place = middle(pair) + Vector::z() * height;
        self.add_text(marker, &place, height, format!("{:.3} m", pair.distance));
    }

    fn add_text(&mut self, (namespace, id): (&'static str, usize), place: &Point, height: f64, text: String) {
        self.add(namespace, id, Marker::TEXT_VIEW_FACING, WHITE, |marker| {
            marker.pose = pose_message(&Pose::translation(place.x, place.y, place.z));
            marker.scale.z = height;
            marker.text = text;
        });
    }

    fn add(
        &mut self,
        namespace: &'static str,
        id: usize,
        kind: i32,
        [r, g, b, a]: [f32; 4],
        complete: impl FnOnce(&mut Marker),
    ) {
        let mut marker = Marker {
            header: self.header.clone(),
            ns: namespace.to_owned(),
            id: i32::try_from(id).unwrap_or(i32::MAX),
            type_: kind,
            action: Marker::ADD,
            pose: pose_message(&Pose::identity()),
            color: ColorRGBA { r, g, b, a },
            lifetime: self.lifetime.clone(),
            ..Marker::default()
        };
        complete(&mut marker);
        self.markers.push((namespace, marker));
    }

    fn finish(self, gone: &[(&'static str, i32)]) -> MarkerArray {
        let deletion = |&(namespace, id): &(&str, i32)| Marker {
            header: self.header.clone(),
            ns: namespace.to_owned(),
            id,
            action: Marker::DELETE,
            pose: pose_message(&Pose::identity()),
            ..Marker::default()
        };
        let mut markers: Vec<Marker> = gone.iter().map(deletion).collect();
        markers.extend(self.markers.into_iter().map(|(_, marker)| marker));
        MarkerArray { markers }
    }
}

fn colliding_bodies(checked_state: &CheckedState) -> impl Iterator<Item = BodyId> {
    checked_state.report.colliding_pairs.iter().flat_map(|&(a, b)| [a, b])
}

/// The middle of the line between the nearest points of a pair.
fn middle(pair: &PairDistance) -> Point {
    let [a, b] = &pair.witness_points;
    nalgebra::center(a, b)
}

/// First marker id of a shape. Ids are unique within a namespace, with up to four markers per shape.
fn first_id(body: usize, shape: usize) -> usize {
    (body * 1024 + shape) * 4
}

/// Triangles of a cone's surface: `RViz` has no marker type for cones.
fn cone_corners(radius: f64, half_length: f64) -> Vec<Point> {
    const SIDES: u32 = 24;
    let rim = |i: u32| {
        let angle = std::f64::consts::TAU * f64::from(i % SIDES) / f64::from(SIDES);
        Point::new(radius * angle.cos(), radius * angle.sin(), -half_length)
    };
    let [apex, foot] = [half_length, -half_length].map(|z| Point::new(0.0, 0.0, z));
    (0..SIDES).flat_map(|i| [apex, rim(i), rim(i + 1), foot, rim(i + 1), rim(i)]).collect()
}

/// Resource name and scale of a mesh for other programs. `None` for file names relative to the URDF, which other
/// programs cannot resolve.
fn resource(source: &MeshSource) -> Option<(String, Vector)> {
    let uri = match &source.uri {
        uri if uri.starts_with("package://") || uri.starts_with("file://") => uri.clone(),
        path if path.starts_with('/') => format!("file://{path}"),
        _ => return None,
    };
    Some((uri, source.scale))
}
