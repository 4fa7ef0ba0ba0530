//! Runs all checks of a robot model: options, report, and checks for missing or unreadable geometry.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;

use clearance_geometry::TriangleMesh;
use clearance_robot::{Collision, Link, RobotModel, VisualGeometry};
use rayon::prelude::*;
use serde::Serialize;

use crate::finding::{Check, Finding, GeometryKind, Severity};
use crate::hausdorff::HausdorffOptions;
use crate::link_geometry::Numbered;
use crate::link_report::{LinkReport, MOST_TRIANGLES, distance_findings, measure, meshes};
use crate::mesh_defects::MeshDefects;
use crate::mesh_findings::mesh_findings;
use crate::size_checks::size_findings;

/// Thresholds and limits of the checks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LintOptions {
    /// Distance (m) of visual geometry from the collision solid above which it is reported.
    pub unprotected: f64,
    /// Distance (m) of collision geometry from the visual one above which it is reported.
    pub excess: f64,
    /// Limits of the searches for the largest distances. The deadline holds for all checks.
    pub hausdorff: HausdorffOptions,
}

impl Default for LintOptions {
    fn default() -> Self {
        Self { unprotected: 0.005, excess: 0.05, hausdorff: HausdorffOptions::default() }
    }
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

/// Runs all checks. `visuals` are read from the URDF of `robot`; links that they do not list count as links without visual geometry.
pub fn lint(robot: &RobotModel, visuals: &VisualGeometry, options: &LintOptions) -> LintReport {
    let visual = |index: usize| visuals.links.get(index).map_or(&[][..], Vec::as_slice);
    let all = robot.links().iter().enumerate();
    let deadline = options.hausdorff.deadline;
    let visuals_of = |index: usize| Numbered {
        geometry: visual(index),
        numbers: visuals.numbers.get(index).map_or(&[][..], Vec::as_slice),
    };
    let lists = all.clone().flat_map(|(i, link)| [&link.collisions[..], visual(i)]);
    let defects = all_defects(lists, deadline);
    let mut findings: Vec<Finding> = visuals.faults.iter().map(unreadable).collect();
    for (index, link) in all.clone() {
        let collisions = Numbered { geometry: &link.collisions, numbers: &[] };
        let mut find = |kind, elements: &mut dyn Iterator<Item = (usize, &Collision)>| {
            findings.extend(mesh_findings(&link.name, kind, elements, &defects));
        };
        find(GeometryKind::Collision, &mut collisions.elements());
        let own = |(_, visual): &(usize, &Collision)| !is_shared(visual, &link.collisions);
        find(GeometryKind::Visual, &mut visuals_of(index).elements().filter(own));
        findings.extend(missing_geometry(link, visual(index)));
    }
    findings.extend(size_findings(robot, visuals_of));
    let links: Vec<LinkReport> = all
        .filter(|(index, link)| !(link.collisions.is_empty() && visual(*index).is_empty()))
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|(index, link)| measure(link, visual(index), &options.hausdorff))
        .collect();
    findings.extend(links.iter().flat_map(|report| distance_findings(report, options)));
    LintReport { robot: robot.name().to_owned(), links, findings: sorted(findings) }
}

fn sorted(mut findings: Vec<Finding>) -> Vec<Finding> {
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    findings
}

/// True if the mesh of a visual is a collision mesh of the same link: the findings about it are not repeated.
fn is_shared(visual: &Collision, collisions: &[Collision]) -> bool {
    visual.mesh_source.is_some() && collisions.iter().any(|c| c.mesh_source == visual.mesh_source)
}

/// The defects of each mesh that is not too large; several links may share one.
fn all_defects<'g>(
    lists: impl Iterator<Item = &'g [Collision]>,
    deadline: Option<Instant>,
) -> HashMap<*const TriangleMesh, MeshDefects> {
    let all: HashMap<*const TriangleMesh, &Arc<TriangleMesh>> = lists
        .flat_map(meshes)
        .filter(|mesh| mesh.triangles().len() <= MOST_TRIANGLES)
        .map(|mesh| (Arc::as_ptr(mesh), mesh))
        .collect();
    let all: Vec<&Arc<TriangleMesh>> = all.into_values().collect();
    let found: Vec<MeshDefects> = all.par_iter().map(|mesh| MeshDefects::find(mesh, deadline)).collect();
    all.into_iter().map(Arc::as_ptr).zip(found).collect()
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
