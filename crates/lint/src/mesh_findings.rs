//! Findings about the meshes of one link.

use std::collections::HashMap;
use std::sync::Arc;

use clearance_geometry::{Shape, TriangleMesh};
use clearance_robot::Collision;

use crate::finding::{Check, Finding, GeometryKind, Severity};
use crate::mesh_defects::{Defect, MeshDefects};

/// Triangles of a collision mesh above which loading and checks become slow.
const MANY_TRIANGLES: usize = 20_000;

/// A kind of defect, with its text and advice. `severity` holds for collision meshes; for visual meshes, which no check uses, all are notes.
struct Rule {
    severity: Severity,
    check: Check,
    defect: Option<Defect>,
    /// Follows the number of defects.
    text: &'static str,
}

/// Findings about the meshes of one kind of geometry of a link, with the numbers of their elements.
pub(crate) fn mesh_findings(
    link: &str,
    kind: GeometryKind,
    elements: &mut dyn Iterator<Item = (usize, &Collision)>,
    defects: &HashMap<*const TriangleMesh, MeshDefects>,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (number, collision) in elements {
        let Shape::Mesh(mesh) = &collision.shape else { continue };
        let element = format!("{} {number}", kind.name());
        let finding = |severity, check, defect: Option<Defect>, message: String| Finding {
            severity: if kind == GeometryKind::Visual { Severity::Note } else { severity },
            check,
            link: link.to_owned(),
            element: element.clone(),
            mesh: collision.mesh_source.as_ref().map(|source| source.uri.clone()),
            point: defect.map(|d| collision.pose_ls * d.point),
            message,
        };
        let Some(found) = defects.get(&Arc::as_ptr(mesh)) else {
            let message = format!("{} triangles: not checked, simplify the mesh", mesh.triangles().len());
            findings.push(finding(Severity::Warning, Check::LimitReached, None, message));
            continue;
        };
        if found.degenerate_triangles.is_some_and(|defect| defect.count == found.triangles) {
            let message =
                "no triangle has an area, so that only lines and points are left: export the mesh again";
            findings.push(finding(Severity::Error, Check::DegenerateTriangles, None, message.to_owned()));
            continue;
        }
        for Rule { severity, check, defect, text } in rules(found) {
            if let Some(Defect { count, .. }) = defect {
                let is_least = check == Check::SelfIntersection && found.may_have_more_self_intersections;
                let least = if is_least { "at least " } else { "" };
                findings.push(finding(severity, check, defect, format!("{least}{count} {text}")));
            }
        }
        if found.may_have_more_self_intersections && found.self_intersections.is_none() {
            let message = "the search for faces that pass through each other ended early".to_owned();
            findings.push(finding(Severity::Note, Check::LimitReached, None, message));
        }
        if found.components > 1 {
            let message =
                format!("{} components that share no vertex: correct, if this is intended", found.components);
            findings.push(finding(Severity::Note, Check::SeveralComponents, None, message));
        }
        if found.triangles > MANY_TRIANGLES && kind == GeometryKind::Collision {
            let message =
                format!("{} triangles: simplify the mesh, for faster loading and checks", found.triangles);
            findings.push(finding(Severity::Note, Check::ManyTriangles, None, message));
        }
    }
    findings
}

fn rules(found: &MeshDefects) -> [Rule; 7] {
    use Severity::{Note, Warning};
    let rule = |severity, check, defect, text| Rule { severity, check, defect, text };
    [
        rule(
            Warning,
            Check::OpenEdges,
            found.open_edges,
            "open edges: parts with holes are no solid, so what is wholly inside touches nothing; close the mesh",
        ),
        rule(Warning, Check::Inverted, found.inverted, "components wound inward: reverse the faces"),
        rule(
            Warning,
            Check::MixedOrientation,
            found.mixed_orientation,
            "edges between faces of opposite windings: make the normals consistent",
        ),
        rule(Note, Check::DuplicateFaces, found.duplicate_faces, "faces repeat other faces: remove them"),
        rule(
            Note,
            Check::DoubleSidedFaces,
            found.double_sided_faces,
            "faces repeat other faces with the opposite winding: remove one side",
        ),
        rule(
            Note,
            Check::SelfIntersection,
            found.self_intersections,
            "pairs of faces pass through each other: unite the parts, if the mesh should be one solid",
        ),
        rule(
            Note,
            Check::DegenerateTriangles,
            found.degenerate_triangles,
            "triangles without area: remove them",
        ),
    ]
}
