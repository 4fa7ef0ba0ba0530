//! Measurements of one link: triangles, and distances between collision and visual geometry, with their findings.

use std::sync::Arc;

use clearance_geometry::{Shape, TriangleMesh};
use clearance_robot::{Collision, Link};
use serde::Serialize;

use crate::finding::{Check, Finding, Severity};
use crate::hausdorff::{HausdorffBounds, HausdorffOptions, hausdorff};
use crate::link_geometry::{are_same, placed};
use crate::robot_lint::LintOptions;

/// Triangles of a link, or of one mesh, above which they are not checked: their number bounds the memory.
pub(crate) const MOST_TRIANGLES: usize = 3_000_000;

/// Bounds of the largest distance (m) of one geometry from the other, and its place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LargestDistance {
    /// Lower bound (m).
    pub lower: f64,
    /// Upper bound (m).
    pub upper: f64,
    /// Point with the largest distance found (m, link frame).
    pub point: [f64; 3],
    /// True if the bounds differ by at most the gap of the options: [`HausdorffBounds::is_within_gap`].
    pub is_within_gap: bool,
    /// True if a limit of the work ended the search.
    #[serde(skip)]
    pub ended_early: bool,
}

impl LargestDistance {
    /// The bounds in millimetres, with so many digits, rounded to the outside.
    pub fn in_millimetres(&self, digits: u8) -> String {
        let scale = 10.0_f64.powi(i32::from(digits));
        let [lower, upper] = [(1e3 * scale * self.lower).floor(), (1e3 * scale * self.upper).ceil()];
        let digits = usize::from(digits);
        format!("{:.digits$} to {:.digits$}", lower / scale, upper / scale)
    }
}

impl From<HausdorffBounds> for LargestDistance {
    fn from(bounds: HausdorffBounds) -> Self {
        let HausdorffBounds { lower, upper, point, is_within_gap, ended_early, .. } = bounds;
        Self { lower, upper, point: point.coords.into(), is_within_gap, ended_early }
    }
}

/// Measurements of one link.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LinkReport {
    /// Name of the link.
    pub link: String,
    /// Number of triangles of its collision meshes.
    pub collision_triangles: usize,
    /// Number of triangles of its visual meshes.
    pub visual_triangles: usize,
    /// True if all of its collision meshes are closed, so that points inside have distance 0. Primitives are solid.
    pub is_collision_solid: bool,
    /// True if all of its visual meshes are closed.
    pub is_visual_solid: bool,
    /// How far visual geometry stands out of the collision geometry, whose closed meshes are solid.
    pub unprotected: Option<LargestDistance>,
    /// How far collision geometry stands out beyond the visual geometry, whose closed meshes are solid.
    pub excess: Option<LargestDistance>,
}

impl LinkReport {
    /// Number of triangles of all meshes.
    pub(crate) fn triangles(&self) -> usize {
        self.collision_triangles + self.visual_triangles
    }
}

/// Measures the geometry of a link.
pub(crate) fn measure(link: &Link, visuals: &[Collision], options: &HausdorffOptions) -> LinkReport {
    let collision_triangles = triangle_count(&link.collisions);
    let visual_triangles = triangle_count(visuals);
    let [unprotected, excess] = if collision_triangles + visual_triangles > MOST_TRIANGLES {
        [None; 2]
    } else if are_same(&link.collisions, visuals) {
        [visuals.first().and_then(same_geometry); 2]
    } else {
        let [collision, visual] = [&link.collisions[..], visuals].map(placed);
        let (unprotected, excess) = rayon::join(
            || hausdorff(&visual, &collision, options),
            || hausdorff(&collision, &visual, options),
        );
        [unprotected, excess].map(|bounds| bounds.map(LargestDistance::from))
    };
    LinkReport {
        link: link.name.clone(),
        collision_triangles,
        visual_triangles,
        is_collision_solid: are_solid(&link.collisions),
        is_visual_solid: are_solid(visuals),
        unprotected,
        excess,
    }
}

/// The meshes of geometry.
pub(crate) fn meshes(geometry: &[Collision]) -> impl Iterator<Item = &Arc<TriangleMesh>> {
    geometry.iter().filter_map(|collision| match &collision.shape {
        Shape::Mesh(mesh) => Some(mesh),
        _ => None,
    })
}

fn triangle_count(geometry: &[Collision]) -> usize {
    meshes(geometry).map(|mesh| mesh.triangles().len()).sum()
}

fn are_solid(geometry: &[Collision]) -> bool {
    meshes(geometry).all(|mesh| !mesh.solid().remarks().is_open())
}

/// Distance of a geometry from itself, at a vertex.
fn same_geometry(geometry: &Collision) -> Option<LargestDistance> {
    let vertex = meshes(std::slice::from_ref(geometry)).next()?.vertices().first().copied()?;
    let point = (geometry.pose_ls * vertex).coords.into();
    Some(LargestDistance { lower: 0.0, upper: 0.0, point, is_within_gap: true, ended_early: false })
}

/// Findings about the distances of a link.
pub(crate) fn distance_findings(report: &LinkReport, options: &LintOptions) -> Vec<Finding> {
    let finding = |severity, check, distance: Option<LargestDistance>, message: String| Finding {
        severity,
        check,
        link: report.link.clone(),
        element: String::new(),
        mesh: None,
        point: distance.map(|d| d.point.into()),
        message,
    };
    let mut findings = Vec::new();
    if report.triangles() > MOST_TRIANGLES {
        let message = format!(
            "{} triangles: distances are measured up to {MOST_TRIANGLES}; simplify the meshes",
            report.triangles()
        );
        findings.push(finding(Severity::Warning, Check::LimitReached, None, message));
    }
    for (distance, what) in [(report.unprotected, "unprotected"), (report.excess, "excess")] {
        if let Some(distance) = distance.filter(|d| d.ended_early) {
            let message = format!(
                "the search for the largest distance ({what}) ended early, at {}: give it more time, or a larger gap",
                millimetres(&distance)
            );
            findings.push(finding(Severity::Note, Check::LimitReached, Some(distance), message));
        }
    }
    if let Some(distance) = report.unprotected.filter(|d| d.lower > options.unprotected) {
        let message = format!(
            "visual geometry stands {} out of the collision geometry, so contacts there are not found: \
             enlarge the collision geometry",
            millimetres(&distance)
        );
        findings.push(finding(Severity::Warning, Check::UnprotectedVisual, Some(distance), message));
    }
    if let Some(distance) = report.excess.filter(|d| d.lower > options.excess) {
        let surface =
            if report.is_visual_solid { "" } else { "; visual meshes are open, so their inside counts, too" };
        let message = format!(
            "collision geometry stands {} out beyond the visual geometry, so free states there are reported as \
             collisions: make it fit, unless it covers parts that are not drawn{surface}",
            millimetres(&distance)
        );
        findings.push(finding(Severity::Note, Check::ExcessCollision, Some(distance), message));
    }
    findings
}

/// The bounds in millimetres.
fn millimetres(distance: &LargestDistance) -> String {
    distance.in_millimetres(2) + " mm"
}
