//! Data type of one finding about a robot model: check, severity, place and message.

use clearance_geometry::math::Point;
use serde::Serialize;

/// Importance of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Information; no check is wrong because of it.
    Note,
    /// Checks may be wrong or slow.
    Warning,
    /// Checks are wrong.
    Error,
}

/// Which geometry of a link a finding is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum GeometryKind {
    /// `<collision>`.
    Collision,
    /// `<visual>`.
    Visual,
}

impl GeometryKind {
    /// Name of the URDF element.
    pub fn name(self) -> &'static str {
        match self {
            Self::Collision => "collision",
            Self::Visual => "visual",
        }
    }
}

/// Kind of a finding; its name in reports is stable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Check {
    /// Edges with one face only.
    OpenEdges,
    /// A closed mesh whose faces point inward.
    Inverted,
    /// Neighbouring faces with opposite windings.
    MixedOrientation,
    /// Faces that occur several times with one winding.
    DuplicateFaces,
    /// Faces that occur in both windings.
    DoubleSidedFaces,
    /// Faces that pass through each other.
    SelfIntersection,
    /// Faces without area.
    DegenerateTriangles,
    /// Parts that share no vertex.
    SeveralComponents,
    /// More triangles than a collision mesh needs.
    ManyTriangles,
    /// A size that suggests a wrong unit.
    WrongUnit,
    /// A size that is unlikely beside the visual geometry or beside neighbouring links.
    UnlikelyScale,
    /// Visual geometry without collision geometry.
    MissingCollision,
    /// Collision geometry without visual geometry.
    MissingVisual,
    /// Visual geometry that could not be loaded.
    UnreadableVisual,
    /// Visual geometry outside of the collision geometry.
    UnprotectedVisual,
    /// Collision geometry that stands out beyond the visual geometry.
    ExcessCollision,
    /// A distance that was not measured, or whose bounds are wide, because a limit of the work was reached.
    LimitReached,
}

impl Check {
    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::OpenEdges => "open_edges",
            Self::Inverted => "inverted",
            Self::MixedOrientation => "mixed_orientation",
            Self::DuplicateFaces => "duplicate_faces",
            Self::DoubleSidedFaces => "double_sided_faces",
            Self::SelfIntersection => "self_intersection",
            Self::DegenerateTriangles => "degenerate_triangles",
            Self::SeveralComponents => "several_components",
            Self::ManyTriangles => "many_triangles",
            Self::WrongUnit => "wrong_unit",
            Self::UnlikelyScale => "unlikely_scale",
            Self::MissingCollision => "missing_collision",
            Self::MissingVisual => "missing_visual",
            Self::UnreadableVisual => "unreadable_visual",
            Self::UnprotectedVisual => "unprotected_visual",
            Self::ExcessCollision => "excess_collision",
            Self::LimitReached => "limit_reached",
        }
    }
}

/// One finding about a robot model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Importance.
    pub severity: Severity,
    /// Kind of the finding.
    pub check: Check,
    /// Name of the link; empty if the finding is about the whole robot.
    pub link: String,
    /// The geometry of the link that the finding is about, such as `collision 1`.
    pub element: String,
    /// Name of the mesh in the URDF.
    pub mesh: Option<String>,
    /// Place (m, link frame).
    #[serde(serialize_with = "coordinates")]
    pub point: Option<Point>,
    /// Description of the defect, and advice.
    pub message: String,
}

// the signature is that of serde
#[allow(clippy::ref_option)]
fn coordinates<S: serde::Serializer>(point: &Option<Point>, serializer: S) -> Result<S::Ok, S::Error> {
    point.map(|p| [p.x, p.y, p.z]).serialize(serializer)
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { link, element, mesh, point, message, .. } = self;
        if !link.is_empty() {
            write!(f, "link '{link}'")?;
            if !element.is_empty() {
                write!(f, " {element}")?;
            }
            f.write_str(": ")?;
        }
        f.write_str(message)?;
        if let Some(p) = point {
            write!(f, "; at ({:.4}, {:.4}, {:.4}) m", p.x, p.y, p.z)?;
        }
        match mesh {
            Some(mesh) => write!(f, "; {mesh}"),
            None => Ok(()),
        }
    }
}
