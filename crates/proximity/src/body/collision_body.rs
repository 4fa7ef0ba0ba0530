//! Collision body: a rigid body built from shapes, with its triangles, solids, planes, points, voxels and hierarchies.

use std::sync::Arc;

use clearance_geometry::math::{Extremes, MatrixPose, Point, Pose};
use clearance_geometry::{InsideGrid, Plane, Shape, VolumeKind};

use super::body_volume::BodyVolume;
use super::bounding_sphere::BoundingSphere;
use super::cube_set::CubeSet;
use super::interior::Interior;
use super::piece::{Piece, PieceVolume, cube_pieces, solid_pieces, surface_pieces};
use super::solid_leaf::{Solid, SolidLeaf, set_volumes_of_solids};
use super::surface::Surface;
use crate::bounding_volume::Obb;
use crate::bvh::Tree;
use crate::elements::{ElementId, RoundedShape};

/// Collision geometry of one body in its own frame, with hierarchies of volumes `B`: triangles, solid primitives, planes, points and
/// voxels. Immutable; threads share it.
#[derive(Clone, Debug)]
pub struct CollisionBody {
    /// All triangles; shared with copies of the body.
    surface: Option<Arc<Surface>>,
    /// All primitives.
    solids: Option<Tree<Obb, SolidLeaf>>,
    /// In the frame of the body.
    planes: Vec<Plane>,
    /// Clouds of points and sets of voxels.
    cube_sets: Vec<CubeSet>,
    interior: Option<Interior>,
    /// Bounding sphere of everything except the planes.
    bounded: Option<BoundingSphere>,
}

impl CollisionBody {
    /// A body of shapes, each at its pose in the body's frame; `None` without shapes. Meshes are surfaces.
    ///
    /// # Panics
    /// If the meshes together have more than 2³² vertices or 2³¹ triangles.
    #[must_use]
    pub fn new<'a>(shapes: impl IntoIterator<Item = (&'a Pose, &'a Shape)>) -> Option<Self> {
        Self::of_shapes(&Vec::from_iter(shapes))
    }

    /// As [`Self::new`], but closed meshes are solids: a body wholly inside one touches it, if it was also built by this function. Open
    /// meshes stay surfaces.
    ///
    /// # Panics
    /// As [`Self::new`].
    #[must_use]
    pub fn with_solid_meshes<'a>(shapes: impl IntoIterator<Item = (&'a Pose, &'a Shape)>) -> Option<Self> {
        let shapes = Vec::from_iter(shapes);
        let mut body = Self::of_shapes(&shapes)?;
        body.interior = Some(Interior::new(&shapes));
        Some(body)
    }

    /// The same body, whose pairs are searched with volumes of another kind; results are the same. The boxes stay, for pieces, clouds of
    /// points, voxels and streams.
    ///
    /// Two bodies of different kinds are searched with the greater one, if both have it: `kinds` are those of the bodies that this one will
    /// meet. Otherwise they are searched with boxes.
    #[must_use]
    pub fn with_volumes_of(mut self, kind: VolumeKind, kinds: &[VolumeKind]) -> Self {
        if kinds.iter().chain([&kind]).all(|kind| *kind == VolumeKind::Obb) {
            return self;
        }
        if let Some(surface) = &mut self.surface {
            Arc::make_mut(surface).set_volumes(kind, kinds);
        }
        if let Some(solids) = &mut self.solids {
            set_volumes_of_solids(solids, kind, kinds);
        }
        self
    }

    /// Points (frame of the body) that decide whether the body is inside another one, if their surfaces are apart and closed meshes are solids:
    /// where a point of either body is inside the other.
    #[must_use]
    #[inline]
    pub fn decisive_points(&self) -> &[Point] {
        self.interior.as_ref().map_or(&[], Interior::decisive_points)
    }

    /// False if a point (frame of the body) is certainly outside of all closed meshes, where these are solids; found without computing a
    /// winding number.
    #[must_use]
    #[inline]
    pub fn may_contain(&self, point: &Point) -> bool {
        self.interior.as_ref().is_some_and(|interior| interior.may_contain(point))
    }

    /// The same body as [`Self::with_solid_meshes`] makes of these shapes, from which this one was built; their hierarchies are shared.
    #[must_use]
    pub(crate) fn with_interior(&self, shapes: &[(&Pose, &Shape)]) -> Self {
        Self { interior: Some(Interior::new(shapes)), ..self.clone() }
    }

    /// Splits the body into not many more than `most` pieces, so that a broad phase can find those that are near. Empty if it cannot be
    /// split: planes are infinite. The inside of solid meshes is not in these pieces.
    #[must_use]
    pub fn pieces(&self, most: usize) -> Vec<(Piece, PieceVolume)> {
        if self.has_planes() {
            return Vec::new();
        }
        let mut pieces = Vec::new();
        pieces.extend(self.solids.iter().flat_map(solid_pieces));
        pieces.extend(self.surface().into_iter().flat_map(|surface| surface_pieces(surface, most)));
        pieces.extend(self.cube_sets.iter().flat_map(|cubes| cube_pieces(cubes, most)));
        pieces
    }

    /// The grids of cells that may be inside its solid meshes, with their poses in the frame of the body.
    pub fn inside_grids(&self) -> impl Iterator<Item = (&Pose, &Arc<InsideGrid>)> {
        let closed_meshes = self.interior.iter().flat_map(Interior::closed_meshes);
        closed_meshes.filter_map(|mesh| Some((mesh.pose_bm(), mesh.inside_grid()?)))
    }

    /// The volumes at a given depth below the roots of the hierarchies, and those of leaves nearer to the root, of the kind that pairs are
    /// searched with: together they contain the body except its planes.
    #[must_use]
    pub fn volumes(&self, level: usize) -> Vec<BodyVolume> {
        let surface =
            self.surface().into_iter().flat_map(|surface| BodyVolume::of_tree(surface.tree(), level));
        let solids = self.solids.iter().flat_map(|tree| BodyVolume::of_tree(tree, level));
        let cubes = self.cube_sets.iter().flat_map(|cubes| {
            let (pose_bs, radius) = (Pose::from(cubes.pose_bs()), cubes.radius());
            let volumes = BodyVolume::of_tree(cubes.tree(), level).into_iter();
            volumes.map(move |volume| volume.placed(&pose_bs, radius))
        });
        surface.chain(solids).chain(cubes).collect()
    }

    fn of_shapes(shapes: &[(&Pose, &Shape)]) -> Option<Self> {
        let (mut vertices, mut faces, mut solids): (Vec<Point>, Vec<[u32; 3]>, Vec<Solid>) =
            Default::default();
        let (mut planes, mut cube_sets): (Vec<Plane>, Vec<CubeSet>) = Default::default();
        for &(pose, shape) in shapes {
            match shape {
                Shape::Primitive(primitive) => solids.push(Solid { primitive: *primitive, pose: *pose }),
                Shape::Mesh(mesh) => {
                    let first = u32::try_from(vertices.len()).expect("vertex count fits 32 bits");
                    vertices.extend(mesh.vertices().iter().map(|p| pose * p));
                    faces.extend(mesh.triangles().iter().map(|t| t.map(|v| v + first)));
                }
                Shape::Plane(plane) => planes.push(plane.transformed(pose)),
                Shape::Points(cloud) => {
                    cube_sets.push(CubeSet::of_points(cloud, pose, next_index(&cube_sets)));
                }
                Shape::Voxels(voxels) => {
                    cube_sets.push(CubeSet::of_voxels(voxels, pose, next_index(&cube_sets)));
                }
            }
        }
        let bounded = BoundingSphere::around(&vertices, &faces, &solids, &cube_sets);
        if bounded.is_none() && planes.is_empty() {
            return None;
        }
        let solids = (!solids.is_empty()).then(|| Tree::build(&solids).0);
        let surface = Surface::new(vertices, &faces).map(Arc::new);
        Some(Self { surface, solids, planes, cube_sets, interior: None, bounded })
    }

    /// A sphere around the body, in its frame; its radius is infinite where the body has a plane.
    #[must_use]
    #[inline]
    pub fn bounding_sphere(&self) -> BoundingSphere {
        self.bounded.filter(|_| !self.has_planes()).unwrap_or(BoundingSphere::UNBOUNDED)
    }

    /// A sphere around everything except the planes.
    #[inline]
    pub(crate) fn bounded(&self) -> Option<&BoundingSphere> {
        self.bounded.as_ref()
    }

    /// Lower bound (m) on the distance of two bodies, from their bounding spheres and planes.
    #[must_use]
    #[inline]
    pub fn sphere_bound(&self, other: &Self, pose_ab: &MatrixPose) -> f64 {
        let bounded = self.bounded.as_ref().zip(other.bounded.as_ref());
        let of_spheres = bounded.map_or(f64::INFINITY, |(a, b)| a.lower_bound(b, pose_ab));
        if !self.has_planes() && !other.has_planes() {
            return of_spheres;
        }
        of_spheres.lesser(self.plane_bound(other, pose_ab))
    }

    /// Lower bound (m) on the distance of planes of either body from anything of the other body; one of them has planes.
    fn plane_bound(&self, other: &Self, pose_ab: &MatrixPose) -> f64 {
        if self.has_planes() && other.has_planes() {
            return 0.0;
        }
        let least = |planes: &[Plane], body: &Self, pose: &MatrixPose| {
            let bound = |plane: &Plane| body.bounded().map(|sphere| sphere.plane_bound(&plane.placed(pose)));
            planes.iter().filter_map(bound).fold(f64::INFINITY, f64::lesser)
        };
        if self.has_planes() {
            least(&self.planes, other, &pose_ab.inverse())
        } else {
            least(&other.planes, self, pose_ab)
        }
    }

    /// The triangles.
    #[inline]
    pub(crate) fn surface(&self) -> Option<&Surface> {
        self.surface.as_deref()
    }

    /// The solid primitives.
    #[inline]
    pub(crate) fn solids(&self) -> Option<&Tree<Obb, SolidLeaf>> {
        self.solids.as_ref()
    }

    /// The planes, in the frame of the body.
    #[inline]
    pub(crate) fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// Clouds of points and sets of voxels.
    #[inline]
    pub(crate) fn cube_sets(&self) -> &[CubeSet] {
        &self.cube_sets
    }

    /// The inside, if closed meshes are solids.
    #[inline]
    pub(crate) fn interior(&self) -> Option<&Interior> {
        self.interior.as_ref()
    }

    /// The plane with this identifier; `None` if it is of another kind of element.
    #[inline]
    pub(crate) fn plane(&self, id: ElementId) -> Option<&Plane> {
        if id.is_plane() { self.planes.get(id.index() as usize) } else { None }
    }

    /// A triangle, a solid primitive, a point or a cube of the body.
    #[inline]
    pub(crate) fn element(&self, id: ElementId) -> RoundedShape {
        let missing = "the identifier is of an element of this body";
        if let Some(set) = id.cube_set() {
            self.cube_sets[set].shape(id.index())
        } else if id.is_triangle() {
            self.surface.as_ref().expect(missing).shape(id.index())
        } else {
            self.solids.as_ref().expect(missing).leaves()[id.index() as usize].content.shape
        }
    }

    #[inline]
    pub(crate) fn has_solids(&self) -> bool {
        self.solids.is_some()
    }

    #[inline]
    pub(crate) fn has_planes(&self) -> bool {
        !self.planes.is_empty()
    }

    #[inline]
    pub(crate) fn has_cubes(&self) -> bool {
        !self.cube_sets.is_empty()
    }

    /// Number of triangles.
    #[must_use]
    #[inline]
    pub fn triangle_count(&self) -> usize {
        self.surface().map_or(0, Surface::triangle_count)
    }

    /// Number of points in clouds and of voxels.
    #[must_use]
    #[inline]
    pub fn cube_count(&self) -> usize {
        self.cube_sets.iter().map(CubeSet::count).sum()
    }

    /// Memory of the hierarchies and of the triangles, points and voxels in them, in bytes.
    #[must_use]
    #[inline]
    pub fn bytes(&self) -> usize {
        let cubes: usize = self.cube_sets.iter().map(CubeSet::bytes).sum();
        self.surface().map_or(0, Surface::bytes) + self.solids.as_ref().map_or(0, Tree::bytes) + cubes
    }
}

/// Index of the next set.
fn next_index(sets: &[CubeSet]) -> u32 {
    u32::try_from(sets.len()).expect("a body has few clouds")
}

#[cfg(test)]
mod tests {
    use super::super::body_volume::VolumeShape;
    use super::*;
    use clearance_geometry::math::Vector;
    use clearance_geometry::testing::Random;
    use clearance_geometry::{PointCloud, Primitive, TriangleMesh};

    fn half_extents(volume: &BodyVolume) -> Vector {
        let VolumeShape::Box { half_extents } = &volume.shape else { panic!("{volume:?} is no box") };
        *half_extents
    }

    fn is_held(point: &Point, volumes: &[BodyVolume]) -> bool {
        volumes.iter().any(|volume| {
            let own = volume.pose_bv.inverse_transform_point(point).coords.abs();
            (own - half_extents(volume)).max() <= 1e-5
        })
    }

    #[test]
    #[expect(clippy::cast_possible_truncation, reason = "a cloud's points are short")]
    fn every_level_holds_the_body_and_its_largest_box_is_no_larger_than_that_above() {
        let mut random = Random::new(3);
        let vertices: Vec<Point> = (0..600).map(|_| random.vector(0.5).into()).collect();
        let triangles = (0..200).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = Shape::Mesh(Arc::new(TriangleMesh::new(vertices.clone(), triangles).unwrap()));
        let ball = Shape::Primitive(Primitive::Sphere { radius: 0.3 });
        let cloud: Vec<[f32; 3]> = vertices.iter().map(|p| [p.x as f32, p.y as f32, p.z as f32]).collect();
        let cloud = Shape::Points(Arc::new(PointCloud::new(cloud, 0.05).unwrap()));
        let [here, there] = [random.pose(2.0), random.pose(2.0)];
        let body = CollisionBody::new([(&here, &mesh), (&there, &ball), (&there, &cloud)]).unwrap();
        let mut before = f64::INFINITY;
        for level in 0..5 {
            let volumes = body.volumes(level);
            assert!(level > 0 || volumes.len() == 3);
            for vertex in &vertices {
                assert!(is_held(&(here * vertex), &volumes), "level {level}");
                let outermost = Point::from(vertex.coords + random.direction().scale(0.0499));
                assert!(is_held(&(there * outermost), &volumes), "level {level}");
            }
            assert!(is_held(&(there * Point::new(0.2999, 0.0, 0.0)), &volumes));
            let size = volumes.iter().map(|v| half_extents(v).product()).fold(0.0, f64::max);
            assert!(size <= before);
            before = size;
        }
        assert_eq!(body.volumes(20), body.volumes(30));
    }

    /// Volumes of other kinds are drawn as they are: those of triangles are convex surfaces around everything, up to their coarseness.
    #[test]
    fn volumes_of_other_kinds_are_drawn() {
        let mut random = Random::new(4);
        let vertices: Vec<Point> = (0..60).map(|_| random.vector(0.5).into()).collect();
        let triangles = (0..20).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = Shape::Mesh(Arc::new(TriangleMesh::new(vertices, triangles).unwrap()));
        let pose = random.pose(2.0);
        let body = CollisionBody::new([(&pose, &mesh)]).unwrap();
        for kind in VolumeKind::ALL {
            let volumes = body.clone().with_volumes_of(kind, &[]).volumes(0);
            let [volume] = &volumes[..] else { panic!("{kind}: {} volumes", volumes.len()) };
            match (kind, &volume.shape) {
                (VolumeKind::Obb | VolumeKind::Aabb, VolumeShape::Box { .. })
                | (VolumeKind::Pss, VolumeShape::Ball { .. }) => {}
                (_, VolumeShape::Triangles(triangles)) => {
                    assert_eq!(triangles.len(), 72);
                    let points = triangles.iter().flatten();
                    let middle = points.clone().fold(Vector::zeros(), |sum, p| sum + p.coords / 216.0);
                    let sixfold = |[a, b, c]: &[Point; 3]| (b - a).cross(&(c - a)).dot(&(a.coords - middle));
                    assert!(triangles.iter().all(|t| sixfold(t) >= -1e-9), "{kind}: a face looks inward");
                    let volume = triangles.iter().map(sixfold).sum::<f64>() / 6.0;
                    assert!((0.2..4.0).contains(&volume), "{kind}: {volume}");
                    let size = points.map(|p| (p.coords - middle).norm()).fold(0.0, f64::max);
                    assert!((0.3..2.0).contains(&size), "{kind}: {size}");
                }
                (_, shape) => panic!("{kind} is drawn as {shape:?}"),
            }
        }
    }
}
