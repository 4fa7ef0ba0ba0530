//! All checks of a robot model.

use std::collections::HashMap;
use std::sync::Arc;

use clearance_geometry::{Shape, TriangleMesh};
use clearance_robot::{Collision, Link, RobotModel, VisualGeometry};
use rayon::prelude::*;
use serde::Serialize;

use crate::finding::{Check, Finding, GeometryKind, Severity};
use crate::hausdorff::{HausdorffBounds, HausdorffOptions, hausdorff};
use crate::link_geometry::{PlacedShape, are_same, bounds_of};
use crate::mesh_defects::MeshDefects;
use crate::mesh_findings::mesh_findings;
use crate::size_checks::{confused_units, diagonal, reach, size_fault};

/// Thresholds and limits of the checks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LintOptions {
    /// Distance (m) of visual geometry from the collision solid above which it is reported.
    pub unprotected: f64,
    /// Distance (m) of collision geometry from the visual one above which it is reported.
    pub excess: f64,
    /// Limits of the searches for the largest distances.
    pub hausdorff: HausdorffOptions,
}

impl Default for LintOptions {
    fn default() -> Self {
        Self { unprotected: 0.005, excess: 0.05, hausdorff: HausdorffOptions::default() }
    }
}

/// Bounds of the largest distance (m) of one geometry from the other, and its place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LargestDistance {
    /// Lower bound (m).
    pub lower: f64,
    /// Upper bound (m).
    pub upper: f64,
    /// Point with the largest distance found (m, link frame).
    pub point: [f64; 3],
}

impl From<HausdorffBounds> for LargestDistance {
    fn from(bounds: HausdorffBounds) -> Self {
        Self { lower: bounds.lower, upper: bounds.upper, point: bounds.point.coords.into() }
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
    /// How far visual geometry stands out of the collision geometry, whose closed meshes are solid.
    pub unprotected: Option<LargestDistance>,
    /// How far collision geometry stands out beyond the visual geometry, whose closed meshes are solid.
    pub excess: Option<LargestDistance>,
}

/// Result of all checks.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LintReport {
    /// Name of the robot.
    pub robot: String,
    /// Links with geometry, in the order of the URDF.
    pub links: Vec<LinkReport>,
    /// Most severe findings first.
    pub findings: Vec<Finding>,
}

impl LintReport {
    /// Number of findings of this severity.
    pub fn count(&self, severity: Severity) -> usize {
        self.findings.iter().filter(|finding| finding.severity == severity).count()
    }
}

/// Defects of the collision meshes of a robot alone; neither visual geometry nor distances.
pub fn lint_collision_meshes(robot: &RobotModel) -> Vec<Finding> {
    let defects = all_defects(robot.links().iter().flat_map(|link| &link.collisions));
    let mut findings = Vec::new();
    for link in robot.links() {
        findings.extend(mesh_findings(&link.name, GeometryKind::Collision, &link.collisions, &defects));
        findings.extend(size_findings(link, &[], reach(robot)));
    }
    sorted(findings)
}

/// Runs all checks. `visuals` are read from the URDF of `robot`; links that they do not list count as links without visual geometry.
pub fn lint(robot: &RobotModel, visuals: &VisualGeometry, options: &LintOptions) -> LintReport {
    let visual = |index: usize| visuals.links.get(index).map_or(&[][..], Vec::as_slice);
    let all = robot.links().iter().enumerate();
    let defects = all_defects(all.clone().flat_map(|(i, link)| link.collisions.iter().chain(visual(i))));
    let mut findings: Vec<Finding> = visuals.faults.iter().map(unreadable).collect();
    for (index, link) in all.clone() {
        findings.extend(mesh_findings(&link.name, GeometryKind::Collision, &link.collisions, &defects));
        findings.extend(mesh_findings(&link.name, GeometryKind::Visual, visual(index), &defects));
        findings.extend(size_findings(link, visual(index), reach(robot)));
        findings.extend(missing_geometry(link, visual(index)));
    }
    let links: Vec<LinkReport> = all
        .filter(|(index, link)| !(link.collisions.is_empty() && visual(*index).is_empty()))
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|(index, link)| measure(link, visual(index), &options.hausdorff))
        .collect();
    findings.extend(links.iter().flat_map(|report| distance_findings(report, options)));
    LintReport { robot: robot.name().to_owned(), links, findings: sorted(findings) }
}

/// The geometry of a link, in its frame.
pub(crate) fn placed(geometry: &[Collision]) -> Vec<PlacedShape> {
    geometry.iter().filter_map(PlacedShape::of).collect()
}

fn sorted(mut findings: Vec<Finding>) -> Vec<Finding> {
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    findings
}

/// The defects of each mesh, which several links may share.
fn all_defects<'c>(
    geometry: impl Iterator<Item = &'c Collision>,
) -> HashMap<*const TriangleMesh, MeshDefects> {
    let mut meshes: HashMap<*const TriangleMesh, &Arc<TriangleMesh>> = HashMap::new();
    for collision in geometry {
        if let Shape::Mesh(mesh) = &collision.shape {
            meshes.insert(Arc::as_ptr(mesh), mesh);
        }
    }
    let meshes: Vec<&Arc<TriangleMesh>> = meshes.into_values().collect();
    let found: Vec<MeshDefects> = meshes.par_iter().map(|mesh| MeshDefects::find(mesh)).collect();
    meshes.into_iter().map(Arc::as_ptr).zip(found).collect()
}

fn measure(link: &Link, visuals: &[Collision], options: &HausdorffOptions) -> LinkReport {
    let triangles = |list: &[Collision]| {
        let of = |collision: &Collision| match &collision.shape {
            Shape::Mesh(mesh) => mesh.triangles().len(),
            _ => 0,
        };
        list.iter().map(of).sum()
    };
    let [unprotected, excess] = if are_same(&link.collisions, visuals) {
        let point = bounds_of(&placed(visuals)).map_or([0.0; 3], |[low, _]| low.coords.into());
        [Some(LargestDistance { lower: 0.0, upper: 0.0, point }); 2]
    } else {
        let [collision, visual] = [&link.collisions[..], visuals].map(placed);
        [hausdorff(&visual, &collision, options), hausdorff(&collision, &visual, options)]
            .map(|bounds| bounds.map(LargestDistance::from))
    };
    LinkReport {
        link: link.name.clone(),
        collision_triangles: triangles(&link.collisions),
        visual_triangles: triangles(visuals),
        unprotected,
        excess,
    }
}

fn distance_findings(report: &LinkReport, options: &LintOptions) -> Vec<Finding> {
    let finding = |severity, check, distance: LargestDistance, message: String| Finding {
        severity,
        check,
        link: report.link.clone(),
        element: String::new(),
        mesh: None,
        point: Some(distance.point.into()),
        message,
    };
    let mut findings = Vec::new();
    if let Some(distance) = report.unprotected.filter(|d| d.lower > options.unprotected) {
        let message = format!(
            "visual geometry stands {} out of the collision geometry, so contacts there are not found: \
             enlarge the collision geometry",
            millimetres(&distance)
        );
        findings.push(finding(Severity::Warning, Check::UnprotectedVisual, distance, message));
    }
    if let Some(distance) = report.excess.filter(|d| d.lower > options.excess) {
        let message = format!(
            "collision geometry stands {} out beyond the visual geometry, so free states there are reported as \
             collisions: make it fit, unless it covers parts that are not drawn",
            millimetres(&distance)
        );
        findings.push(finding(Severity::Note, Check::ExcessCollision, distance, message));
    }
    findings
}

/// The bounds in millimetres.
pub(crate) fn millimetres(distance: &LargestDistance) -> String {
    format!("{:.2} to {:.2} mm", 1e3 * distance.lower, 1e3 * distance.upper)
}

fn size_findings(link: &Link, visuals: &[Collision], reach: f64) -> Vec<Finding> {
    let wrong = |element: String, mesh: Option<String>, message: String| Finding {
        severity: Severity::Error,
        check: Check::WrongUnit,
        link: link.name.clone(),
        element,
        mesh,
        point: None,
        message,
    };
    let mut findings = Vec::new();
    for (kind, list) in [(GeometryKind::Collision, &link.collisions[..]), (GeometryKind::Visual, visuals)] {
        for (collision, number) in list.iter().zip(1..) {
            let source = collision.mesh_source.as_ref();
            let size = PlacedShape::of(collision).and_then(|placed| placed.bounds()).map_or(0.0, diagonal);
            if let Some(message) = size_fault(size, reach, source) {
                let element = format!("{} {number}", kind.name());
                findings.push(wrong(element, source.map(|s| s.uri.clone()), message));
            }
        }
    }
    let sizes = [&link.collisions[..], visuals].map(|list| bounds_of(&placed(list)).map_or(0.0, diagonal));
    if let Some((ratio, units)) = confused_units(sizes[0], sizes[1]) {
        let message = format!(
            "collision geometry is {:.4} m and visual geometry {:.4} m large, a ratio of about {ratio}: \
             {units} are probably confused; correct the scale of one mesh",
            sizes[0], sizes[1]
        );
        findings.push(wrong(String::new(), None, message));
    }
    findings
}

fn missing_geometry(link: &Link, visuals: &[Collision]) -> Option<Finding> {
    let (severity, check, message) = match (link.collisions.is_empty(), visuals.is_empty()) {
        (true, false) => (
            Severity::Warning,
            Check::MissingCollision,
            "has visual but no collision geometry, so it is never checked: add <collision>, unless it cannot touch anything",
        ),
        (false, true) => (
            Severity::Note,
            Check::MissingVisual,
            "has collision but no visual geometry, so nothing shows whether it fits",
        ),
        _ => return None,
    };
    Some(Finding {
        severity,
        check,
        link: link.name.clone(),
        element: String::new(),
        mesh: None,
        point: None,
        message: message.to_owned(),
    })
}

fn unreadable(fault: &clearance_robot::Fault) -> Finding {
    Finding {
        severity: Severity::Warning,
        check: Check::UnreadableVisual,
        link: String::new(),
        element: String::new(),
        mesh: None,
        point: None,
        message: fault.to_string(),
    }
}
