//! Simplification of the meshes of a link by edge collapses, with the certified distance between both surfaces.
//!
//! All meshes share one queue of collapses, so that each gets the triangles that its shape needs. Quadrics only choose the collapses: the
//! distance is proven from the triangles of both surfaces alone.

mod edge_collapse;
mod plane_sets;
mod quadric;
mod surface_complex;
mod surface_distance;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use clearance_geometry::math::Point;
use clearance_geometry::{MeshError, TriangleMesh};

use crate::search_limit::SearchLimit;
use edge_collapse::EdgeCollapse;
use surface_complex::SurfaceComplex;
pub use surface_distance::SurfaceDistance;

/// Ratio of two numbers of triangles at which the search for the least one ends.
const COUNT_RATIO: f64 = 1.04;

/// Part of the time that is left for the search of collapses; the rest is for the proof of the distances.
const SEARCH_TIME: f64 = 0.5;

/// Least number of triangles of a closed surface.
pub const LEAST_TRIANGLES: usize = 4;

/// A simplified mesh, in the frame of the original.
#[derive(Clone, Debug)]
pub struct Simplified {
    /// Its vertices are single-precision numbers.
    pub mesh: Arc<TriangleMesh>,
    /// From the surface of the original.
    pub distance: SurfaceDistance,
}

/// Size of the simplified meshes of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MeshSize {
    /// At most this many triangles for each link.
    Triangles(usize),
    /// As few triangles as are found with a distance (m) between the surfaces of at most this.
    Distance(f64),
}

/// The meshes of a link during their simplification.
#[derive(Clone, Debug)]
struct LinkReduction<'m> {
    originals: &'m [Arc<TriangleMesh>],
    /// For each mesh: the end of its faces.
    ends: Vec<usize>,
    collapse: EdgeCollapse,
}

impl<'m> LinkReduction<'m> {
    fn new(originals: &'m [Arc<TriangleMesh>]) -> Self {
        let (complex, ends) = SurfaceComplex::new(originals.iter().map(AsRef::as_ref));
        Self { originals, ends, collapse: EdgeCollapse::new(complex) }
    }

    fn count(&self) -> usize {
        self.collapse.complex().count()
    }

    /// The meshes, with their distances from the originals, which are compared with the `largest` allowed one (m).
    fn simplified(&self, largest: Option<f64>, limit: &SearchLimit) -> Result<Vec<Simplified>, MeshError> {
        let mut start = 0;
        let of_mesh = |(original, end): (&Arc<TriangleMesh>, &usize)| {
            let faces = std::mem::replace(&mut start, *end)..*end;
            let mesh = mesh_of(self.collapse.complex(), faces)?;
            match mesh.filter(|mesh| mesh.triangles().len() < original.triangles().len()) {
                Some(mesh) => {
                    let mesh = Arc::new(mesh);
                    let distance = match largest {
                        Some(largest) => SurfaceDistance::compared([original, &mesh], largest, limit),
                        None => SurfaceDistance::between([original, &mesh], 0.0, limit),
                    };
                    Ok(Simplified { mesh, distance })
                }
                None => unchanged(original),
            }
        };
        self.originals.iter().zip(&self.ends).map(of_mesh).collect()
    }
}

/// The meshes of a link simplified to a size; false if the limit has ended the search. Where edges cannot collapse without a change of
/// topology, there are more triangles.
pub fn simplify(
    originals: &[Arc<TriangleMesh>],
    size: MeshSize,
    limit: &SearchLimit,
) -> Result<(Vec<Simplified>, bool), MeshError> {
    match size {
        MeshSize::Triangles(count) if total(originals) <= count => {
            Ok((originals.iter().map(unchanged).collect::<Result<_, _>>()?, true))
        }
        MeshSize::Triangles(count) => {
            let mut reduction = LinkReduction::new(originals);
            let search_limit = limit.part(SEARCH_TIME);
            let is_cut = !reduction.collapse.reduce_to(count, &search_limit) && search_limit.is_over();
            let simplified = reduction.simplified(None, limit)?;
            Ok((simplified, !is_cut && !limit.is_over()))
        }
        MeshSize::Distance(distance) => fewest(originals, distance, limit),
    }
}

/// As few triangles as bisection finds for a largest distance (m). Every trial goes on from the fewest triangles that are proven.
fn fewest(
    originals: &[Arc<TriangleMesh>],
    distance: f64,
    limit: &SearchLimit,
) -> Result<(Vec<Simplified>, bool), MeshError> {
    let mut best: Vec<Simplified> = originals.iter().map(unchanged).collect::<Result<_, _>>()?;
    let mut proven = LinkReduction::new(originals);
    let mut too_few = LEAST_TRIANGLES - 1;
    #[allow(clippy::cast_precision_loss)] // far below 2^52
    let ratio = |many: usize, few: usize| many as f64 / few as f64;
    while ratio(proven.count(), too_few) > COUNT_RATIO && proven.count() > too_few + 1 {
        let mut trial = proven.clone();
        let count = between(too_few, proven.count());
        let is_reached = trial.collapse.reduce_to(count, limit);
        let simplified = trial.simplified(Some(distance), limit)?;
        if limit.is_over() {
            return Ok((best, false));
        }
        if simplified.iter().all(|mesh| mesh.distance.upper <= distance) {
            (best, proven) = (simplified, trial);
            if !is_reached {
                break;
            }
        } else {
            too_few = count.max(trial.count());
        }
    }
    Ok((best, true))
}

/// The geometric mean of two numbers, and not one of them if another is between them.
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn between(few: usize, many: usize) -> usize {
    (((few as f64) * (many as f64)).sqrt() as usize).clamp(few + 1, many - 1)
}

fn total(meshes: &[Arc<TriangleMesh>]) -> usize {
    meshes.iter().map(|mesh| mesh.triangles().len()).sum()
}

/// A mesh with its vertices rounded to single precision.
fn unchanged(original: &Arc<TriangleMesh>) -> Result<Simplified, MeshError> {
    let vertices = original.vertices().iter().map(rounded).collect();
    let mesh = TriangleMesh::new(vertices, original.triangles().to_vec())?;
    let distance = SurfaceDistance::of_moved_vertices(original, &mesh);
    Ok(Simplified { mesh: Arc::new(mesh), distance })
}

/// The faces with numbers in a range as a mesh; `None` if there are none.
fn mesh_of(complex: &SurfaceComplex, faces: Range<usize>) -> Result<Option<TriangleMesh>, MeshError> {
    let mut names: HashMap<u32, u32> = HashMap::new();
    let mut vertices = vec![];
    let mut name = |v: u32| {
        *names.entry(v).or_insert_with(|| {
            vertices.push(rounded(&complex.position(v)));
            u32::try_from(vertices.len() - 1).unwrap_or(u32::MAX)
        })
    };
    let triangles: Vec<[u32; 3]> = complex.faces_in(faces).map(|face| face.map(&mut name)).collect();
    if triangles.is_empty() { Ok(None) } else { TriangleMesh::new(vertices, triangles).map(Some) }
}

/// The nearest point of single-precision numbers, as STL stores it.
#[allow(clippy::cast_possible_truncation)] // a rounding
fn rounded(p: &Point) -> Point {
    p.map(|c| f64::from(c as f32))
}
