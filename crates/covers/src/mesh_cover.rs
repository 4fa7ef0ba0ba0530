//! Simplified collision meshes of a robot, each with a proven distance between its surface and the original one.

use std::collections::HashSet;
use std::sync::Arc;

use clearance_geometry::math::{Extremes, Point};
use clearance_geometry::{Shape, TriangleMesh};
use clearance_robot::{LinkId, RobotModel};
use rayon::prelude::*;

use crate::mesh_simplification::{LEAST_TRIANGLES, MeshSize, Simplified, simplify};
use crate::options::{CoverError, CoverSize};
use crate::search_limit::SearchLimit;

/// Triangles of the meshes of a link above which they are not simplified: their number bounds the memory.
const MOST_TRIANGLES: usize = 1_000_000;

/// Longest name (characters) of a link in the name of a file.
const LONGEST_FILE_NAME: usize = 100;

/// A simplified collision mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct SimplifiedMesh {
    /// Index of the collision geometry in its link.
    pub collision: usize,
    /// The mesh, in the frame of the original one (m, its scale applied). The vertices are single-precision numbers, as STL stores them.
    pub mesh: Arc<TriangleMesh>,
    /// Number of triangles of the original mesh.
    pub original_triangles: usize,
    /// Proven bounds (m), lower and upper, on the Hausdorff distance of both surfaces: every point of each is at most the upper bound away
    /// from the other, and some point of one is at least the lower bound away.
    pub error: [f64; 2],
    /// A point with the largest distance that was found (m, link frame).
    pub point: Point,
    /// Name of an STL file for the mesh, unique within the robot.
    pub file_name: String,
}

/// The simplified meshes of a link.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkMeshes {
    /// The link.
    pub link: LinkId,
    /// One mesh for each mesh of its collision geometry.
    pub meshes: Vec<SimplifiedMesh>,
    /// True if the limit has ended the search: more time can give fewer triangles, or a smaller bound.
    pub is_cut: bool,
}

impl LinkMeshes {
    /// Number of triangles.
    #[must_use]
    pub fn triangles(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.mesh.triangles().len()).sum()
    }

    /// Number of triangles of the original meshes.
    #[must_use]
    pub fn original_triangles(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.original_triangles).sum()
    }

    /// The mesh with the largest error.
    fn worst(&self) -> Option<&SimplifiedMesh> {
        self.meshes.iter().max_by(|a, b| a.error[0].total_cmp(&b.error[0]))
    }

    /// Bounds (m) on the largest error of its meshes.
    #[must_use]
    pub fn error(&self) -> [f64; 2] {
        [0, 1].map(|i| self.meshes.iter().map(|mesh| mesh.error[i]).fold(0.0, Extremes::greater))
    }

    /// A point with the largest error that was found (m, link frame).
    #[must_use]
    pub fn point(&self) -> Option<Point> {
        self.worst().map(|mesh| mesh.point)
    }
}

/// Simplified meshes of a robot: the links with collision meshes, in the order of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshCover {
    /// The meshes of the links.
    pub links: Vec<LinkMeshes>,
}

impl MeshCover {
    /// Number of triangles.
    #[must_use]
    pub fn triangles(&self) -> usize {
        self.links.iter().map(LinkMeshes::triangles).sum()
    }

    /// Number of triangles of the original meshes.
    #[must_use]
    pub fn original_triangles(&self) -> usize {
        self.links.iter().map(LinkMeshes::original_triangles).sum()
    }

    /// Bounds (m) on the largest error of all meshes.
    #[must_use]
    pub fn error(&self) -> [f64; 2] {
        [0, 1].map(|i| self.links.iter().map(|link| link.error()[i]).fold(0.0, Extremes::greater))
    }

    /// True if the limit has ended the search of a link.
    #[must_use]
    pub fn is_cut(&self) -> bool {
        self.links.iter().any(|link| link.is_cut)
    }
}

/// Simplified collision meshes: at most so many triangles for each link ([`CoverSize::PerLink`]), or as few as are found for a largest error
/// ([`CoverSize::Excess`], m). Closed surfaces stay closed, boundaries of open ones stay boundaries, and parts stay separate, so that a link
/// can keep more triangles than requested. Primitives are not changed.
///
/// The simplified meshes do not contain the original ones: enlarged by the error, they do. The same input gives the same meshes, on any number
/// of threads, unless the limit ends the search. `on_link` is called when a link is done, from any thread.
///
/// # Errors
/// If the size is of another kind or too small, the robot has no collision mesh, a link has more than a million triangles,
/// or single precision is too coarse for the error.
pub fn mesh_cover(
    robot: &RobotModel,
    size: &CoverSize,
    limit: &SearchLimit,
    on_link: &(dyn Fn(LinkId) + Sync),
) -> Result<MeshCover, CoverError> {
    let size = mesh_size(size)?;
    let with_meshes: Vec<LinkId> =
        robot.link_ids().filter(|id| meshes(robot, *id).next().is_some()).collect();
    if with_meshes.is_empty() {
        return Err(CoverError::NoMeshes);
    }
    let of_link = |id: &LinkId| {
        let meshes = link_meshes(robot, *id, size, limit);
        on_link(*id);
        meshes
    };
    let mut links: Vec<LinkMeshes> = with_meshes.par_iter().map(of_link).collect::<Result<_, _>>()?;
    name_files(robot, &mut links);
    Ok(MeshCover { links })
}

fn mesh_size(size: &CoverSize) -> Result<MeshSize, CoverError> {
    match size {
        CoverSize::PerLink(count) if *count < LEAST_TRIANGLES => {
            Err(CoverError::FewTriangles { count: *count })
        }
        CoverSize::PerLink(count) => Ok(MeshSize::Triangles(*count)),
        CoverSize::Excess(value) => {
            size.validate()?;
            Ok(MeshSize::Distance(*value))
        }
        CoverSize::Total(_) | CoverSize::Links(_) => Err(CoverError::NoMeshSize),
    }
}

/// The meshes of a link, with their numbers.
fn meshes(robot: &RobotModel, id: LinkId) -> impl Iterator<Item = (usize, &Arc<TriangleMesh>)> {
    robot.link(id).collisions.iter().enumerate().filter_map(|(i, collision)| match &collision.shape {
        Shape::Mesh(mesh) => Some((i, mesh)),
        _ => None,
    })
}

fn link_meshes(
    robot: &RobotModel,
    id: LinkId,
    size: MeshSize,
    limit: &SearchLimit,
) -> Result<LinkMeshes, CoverError> {
    let link = robot.link(id);
    let (numbers, originals): (Vec<usize>, Vec<Arc<TriangleMesh>>) =
        meshes(robot, id).map(|(i, mesh)| (i, mesh.clone())).unzip();
    let triangles: usize = originals.iter().map(|mesh| mesh.triangles().len()).sum();
    if triangles > MOST_TRIANGLES {
        let reason = format!(
            "its collision meshes have {triangles} triangles, but at most {MOST_TRIANGLES} are simplified"
        );
        return Err(CoverError::Link { link: link.name.clone(), reason });
    }
    let (simplified, is_whole) = simplify(&originals, size, limit)
        .map_err(|error| CoverError::Link { link: link.name.clone(), reason: error.to_string() })?;
    if let MeshSize::Distance(excess) = size
        && simplified.iter().any(|mesh| mesh.distance.upper > excess)
    {
        return Err(CoverError::NotReached { link: link.name.clone(), excess });
    }
    let mesh = |((collision, original), simplified): ((usize, &Arc<TriangleMesh>), Simplified)| {
        let Simplified { mesh, distance } = simplified;
        SimplifiedMesh {
            collision,
            mesh,
            original_triangles: original.triangles().len(),
            error: [distance.lower, distance.upper],
            point: link.collisions[collision].pose_ls * distance.point,
            file_name: String::new(),
        }
    };
    let meshes = numbers.into_iter().zip(&originals).zip(simplified).map(mesh).collect();
    Ok(LinkMeshes { link: id, meshes, is_cut: !is_whole })
}

/// Names files after the links, in a way that every file system accepts and keeps apart.
fn name_files(robot: &RobotModel, links: &mut [LinkMeshes]) {
    let mut taken = HashSet::new();
    for LinkMeshes { link, meshes, .. } in links {
        let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '_' };
        let name: String = robot.described_name(*link).chars().take(LONGEST_FILE_NAME).map(plain).collect();
        let is_single = robot.link(*link).collisions.len() == 1;
        for mesh in meshes {
            let number = if is_single { String::new() } else { format!("_{}", mesh.collision + 1) };
            let mut stem = format!("{name}{number}");
            // no other link has this index: a second round is rare
            while !taken.insert(stem.to_ascii_lowercase()) {
                stem = format!("{stem}__{}", link.index());
            }
            mesh.file_name = format!("{stem}.stl");
        }
    }
}
