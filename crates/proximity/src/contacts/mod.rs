//! Contact points: where two bodies touch, spread over the region of contact.
//!
//! | file | contents |
//! |---|---|
//! | `manifold` | two convex shapes: faces clipped against each other |
//! | `support_face`, `chord`, `polygon` | faces, chords and polygons for it |
//! | `surface_pair` | two surfaces: the curves in which they cross |
//! | `surface_solid` | a surface and solid primitives |
//! | `plane_contacts` | a plane: corners behind it |
//! | `cube_contacts` | points and voxels |
//! | `element_meeting` | where an element of one body meets one of the other |
//! | `contact_patches` | patches: connected parts of a contact, each with a normal |
//! | `touching_elements` | enumeration of what touches, with bounded work |
//! | `surface_chords` | the parts of a line inside closed surfaces |
//! | `candidate` | choice of contacts that are far from each other |

mod candidate;
mod chord;
mod contact_patches;
mod cube_contacts;
mod element_meeting;
mod manifold;
mod plane_contacts;
mod polygon;
mod support_face;
mod surface_chords;
mod surface_pair;
mod surface_solid;
#[cfg(test)]
mod tests;
mod touching_elements;

use clearance_geometry::PointPair;
use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose, Point, Vector};

use crate::body::{BodyPair, CollisionBody};
use crate::bvh::TreePair;
use crate::elements::RoundedShape;
use crate::narrow_phase::separation_within;
use crate::penetration_depth::{ConvexSolid, SolidBody, Union, depth_of_convex, distance_of_point};
use crate::search::Scratch;
use candidate::{Candidate, KnownContact, Local, Spread, next_patch};
use cube_contacts::CubeContacts;
use manifold::{ConvexContact, PlacedSolid};
use plane_contacts::PlaneContact;
use surface_pair::{PlacedSurface, SurfacePair};
use surface_solid::SurfaceAndSolids;
use touching_elements::for_touching;

/// Distance (m) from a body up to which a point counts as in it.
const IN_BODY: f64 = 1e-8;

/// A point where two bodies touch, in the frame of the first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint {
    /// A point of both bodies; where only their margins overlap, half way between them.
    pub position: Point,
    /// Unit vector towards the second body: along it, the second body leaves the first one here by the shortest way.
    pub normal: Vector,
    /// Overlap (m, margin included) of the two shapes that meet here, on the line along the normal through the position. It says nothing
    /// on other places: the translation that separates the whole bodies may be longer. `None` where an open mesh has no inside.
    pub depth: Option<f64>,
}

/// The contact of two bodies that is known already: [`penetration_depth`](crate::penetration_depth()) finds the deepest one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeepestContact {
    /// A point of each body, in the frame of the first: those that come apart last, or the nearest ones of bodies that are apart.
    pub witness_points: PointPair,
    /// Unit vector towards the second body, if it is known.
    pub normal: Option<Vector>,
    /// Depth (m, margin included); 0 if it is not known.
    pub depth: f64,
}

/// Input of [`contact_points`].
#[derive(Clone, Copy, Debug)]
pub struct ContactQuery<'b> {
    /// The bodies.
    pub bodies: BodyPair<'b>,
    /// The same bodies as solids, built from the same shapes in the same order.
    pub solids: [&'b SolidBody; 2],
    /// Distance (m) up to which they touch.
    pub margin: f64,
    /// The deepest contact.
    pub deepest: DeepestContact,
}

/// All contact points of two bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactPoints {
    /// Position of the deepest contact: half way between its witness points, unless this is outside of one of the bodies.
    pub deepest: Point,
    /// Others, the first ones farthest apart.
    pub others: Vec<ContactPoint>,
}

/// Contact points of two bodies, at most `most` besides the deepest.
///
/// Each separate patch of the contact gets a point, as far as there may be so many, and the others are spread. A patch has one normal: the
/// direction in which the common volume shrinks fastest. Between two convex solids the points are the corners of the region in which the
/// facing sides overlap; between meshes they are on the curves in which the surfaces cross, or inside; on planes they are corners and
/// vertices behind the plane. Points and voxels are contacts of their own, with a normal away from the nearest surface.
///
/// Positions are in both bodies within 1e-8 m, relative to coordinates of up to a metre; closed meshes count as solids, planes as the
/// half-space behind them. The work is bounded: of more than about 4000 touching pairs of elements a part is used, spread over the second
/// body. Points and voxels of both bodies are not compared. The result depends on the input only.
#[must_use]
pub fn contact_points(query: &ContactQuery, most: usize, scratch: &mut Scratch) -> ContactPoints {
    let common = query.deepest_position(scratch);
    if most == 0
        && let Some(deepest) = common
    {
        return ContactPoints { deepest, others: Vec::new() };
    }
    let search = ContactSearch::new(query, scratch);
    let deepest = common.unwrap_or_else(|| search.nearest_to_deepest(scratch));
    ContactPoints { deepest, others: search.spread(&deepest, most, scratch) }
}

impl ContactQuery<'_> {
    /// The position of the deepest contact; `None` if it is not one of its own points.
    fn deepest_position(&self, scratch: &mut Scratch) -> Option<Point> {
        let DeepestContact { witness_points: [p, q], normal, .. } = self.deepest;
        let middle = nalgebra::center(&p, &q);
        if normal.is_some_and(|normal| (q - p).dot(&normal) > CONTACT_DISTANCE) {
            return Some(middle);
        }
        let pose_ba = self.bodies.pose_ab.inverse();
        [middle, q, p].into_iter().find(|point| {
            is_in(self.bodies.a, self.solids[0], point, scratch)
                && is_in(self.bodies.b, self.solids[1], &(&pose_ba * *point), scratch)
        })
    }
}

/// Whether a point of the body's frame is in a body; closed meshes are solids.
fn is_in(body: &CollisionBody, solid: &SolidBody, p: &Point, scratch: &mut Scratch) -> bool {
    let is_in_union = solid.union.as_ref().is_some_and(|union| union.depth_of_point(p, scratch) >= -IN_BODY);
    is_in_union || distance_of_point(body, p, scratch).is_some_and(|found| found.distance <= IN_BODY)
}

/// All candidates for the contact points of two bodies.
struct ContactSearch<'q> {
    query: &'q ContactQuery<'q>,
    candidates: Vec<Candidate>,
    surfaces: Option<SurfacePair<'q>>,
    /// The surface of either body, and the solids of the other one.
    faces: [Option<SurfaceAndSolids<'q>>; 2],
    /// Points and voxels of either body; candidates name them by the place in this list.
    cubes: [Option<CubeContacts<'q>>; 2],
}

static IDENTITY: std::sync::LazyLock<MatrixPose> = std::sync::LazyLock::new(MatrixPose::identity);

impl<'q> ContactSearch<'q> {
    fn new(query: &'q ContactQuery<'q>, scratch: &mut Scratch) -> Self {
        let mut search =
            Self { query, candidates: Vec::new(), surfaces: None, faces: [None, None], cubes: [None, None] };
        match query.solids.map(|solid| solid.union.as_ref().and_then(Union::only_convex)) {
            [Some(a), Some(b)] => search.add_convex([a, b]),
            _ => search.add_shapes(scratch),
        }
        search.add_cubes(scratch);
        search
    }

    fn poses(&self) -> [&'q MatrixPose; 2] {
        [&IDENTITY, self.query.bodies.pose_ab]
    }

    /// Two bodies of one convex solid each: the deepest contact has their normal.
    fn add_convex(&mut self, [a, b]: [&ConvexSolid; 2]) {
        if let Some(normal) = self.query.deepest.normal {
            self.add_manifold([a, b], self.poses(), normal);
        }
    }

    fn add_manifold(
        &mut self,
        [a, b]: [&ConvexSolid; 2],
        [pose_a, pose_b]: [&MatrixPose; 2],
        normal: Vector,
    ) {
        let (a, b) = (&PlacedSolid { solid: a, pose: pose_a }, &PlacedSolid { solid: b, pose: pose_b });
        let manifold = ConvexContact { a, b, normal, margin: self.query.margin }.manifold();
        let patch = next_patch(&self.candidates);
        self.candidates.extend(manifold.corners.iter().map(|corner| Candidate {
            position: corner.position,
            normal,
            patch,
            local: Local::Known(Some(corner.depth)),
        }));
    }

    /// All pairs of shapes.
    fn add_shapes(&mut self, scratch: &mut Scratch) {
        let BodyPair { a, b, .. } = self.query.bodies;
        let (poses, margin) = (self.poses(), self.query.margin);
        let fallback = self.query.deepest.normal;
        self.add_solids(scratch);
        let placed = [0, 1].map(|side| {
            let union = self.query.solids[side].union.as_ref()?;
            let surface = [a, b][side].surface()?;
            Some(PlacedSurface { surface, winding: union.winding(), pose: poses[side] })
        });
        for (side, other) in [(0, 1), (1, 0)] {
            if let (Some(surface), Some(solids)) = (placed[side], [a, b][other].solids()) {
                let (pose_solids, surface_is_a) = (poses[other], side == 0);
                let faces = SurfaceAndSolids { surface, solids, pose_solids, surface_is_a, margin };
                faces.candidates(fallback.as_ref(), scratch, &mut self.candidates);
                self.faces[side] = Some(faces);
            }
            for plane in [a, b][side].planes() {
                let (other, pose_other) = ([a, b][other], poses[other]);
                PlaneContact {
                    plane: plane.placed(poses[side]),
                    plane_is_a: side == 0,
                    other,
                    pose_other,
                    margin,
                }
                .candidates(fallback.as_ref(), &mut self.candidates);
            }
        }
        if let [Some(a), Some(b)] = placed {
            let surfaces = SurfacePair::new(a, b, margin, fallback.as_ref(), scratch);
            surfaces.candidates(&mut self.candidates);
            self.surfaces = Some(surfaces);
        }
    }

    /// All pairs of primitives.
    fn add_solids(&mut self, scratch: &mut Scratch) {
        let BodyPair { a, b, pose_ab } = self.query.bodies;
        let (Some(a), Some(b)) = (a.solids(), b.solids()) else { return };
        let relative = &a.relative(b, pose_ab);
        let (mut touching, margin) = (Vec::new(), self.query.margin);
        for_touching(TreePair { a, b, relative }, margin, 0.0, scratch, &mut |i, j| {
            let shapes = (a.leaves()[i as usize].content.shape, b.leaves()[j as usize].content.shape);
            let normal = normal_of(&shapes.0, &shapes.1, pose_ab, margin);
            touching.extend(normal.map(|normal| (shapes, normal)));
            normal.is_some()
        });
        for ((first, second), normal) in touching {
            let solids = [first, second].map(ConvexSolid::Primitive);
            self.add_manifold([&solids[0], &solids[1]], self.poses(), normal);
        }
    }

    fn add_cubes(&mut self, scratch: &mut Scratch) {
        let BodyPair { a, b, .. } = self.query.bodies;
        let poses = self.poses();
        for (side, other) in [(0, 1), (1, 0)] {
            let Some(union) = self.query.solids[other].union.as_ref() else { continue };
            let contacts = CubeContacts {
                cubes: [a, b][side].cube_sets(),
                pose_cubes: poses[side],
                cubes_are_a: side == 0,
                other: [a, b][other],
                union,
                pose_other: poses[other],
                margin: self.query.margin,
            };
            contacts.candidates(&self.query.deepest.witness_points[side], scratch, &mut self.candidates);
            self.cubes[side] = Some(contacts);
        }
    }

    /// The candidate nearest to the deepest contact; without candidates, any common point.
    fn nearest_to_deepest(&self, scratch: &mut Scratch) -> Point {
        let [p, q] = self.query.deepest.witness_points;
        let middle = nalgebra::center(&p, &q);
        let positions = self.candidates.iter().map(|candidate| candidate.position);
        let distance = |position: &Point| nalgebra::distance(position, &middle);
        positions.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or_else(|| {
            let BodyPair { a, b, pose_ab } = self.query.bodies;
            crate::collide(a, b, pose_ab, scratch).unwrap_or(q)
        })
    }

    /// The chosen candidates, measured; `deepest` is the position of the deepest contact.
    fn spread(&self, deepest: &Point, most: usize, scratch: &mut Scratch) -> Vec<ContactPoint> {
        let known = KnownContact { position: *deepest, depth: self.query.deepest.depth };
        let mut spread = Spread::new(&self.candidates, &known, self.size());
        let mut found = Vec::with_capacity(most.min(self.candidates.len()));
        while found.len() < most {
            let Some(candidate) = spread.next() else { break };
            let Some(point) = self.measured(candidate, scratch) else { continue };
            spread.remove_near(&point.position);
            found.push(point);
        }
        found
    }

    /// Radius (m) of the smaller body.
    fn size(&self) -> f64 {
        let BodyPair { a, b, .. } = self.query.bodies;
        let radii = [a, b].map(|body| body.bounded().map_or(f64::INFINITY, |sphere| sphere.radius));
        let least = radii[0].lesser(radii[1]);
        if least.is_finite() { least } else { 1.0 }
    }

    fn measured(&self, candidate: &Candidate, scratch: &mut Scratch) -> Option<ContactPoint> {
        let Candidate { position, normal, local, .. } = *candidate;
        let surfaces = self.surfaces.as_ref();
        match local {
            Local::Known(depth) => Some(ContactPoint { position, normal, depth }),
            Local::OnCurve(patch) => {
                let depth = surfaces?.depth_on_curve(patch, &position, scratch);
                Some(ContactPoint { position, normal, depth })
            }
            Local::InsideCurve(patch) => {
                let (position, depth) = surfaces?.deepest_inside(patch, &position, scratch)?;
                Some(ContactPoint { position, normal, depth: Some(depth) })
            }
            Local::OnFace { surface_is_a, solid, beside } => {
                let faces = self.faces[usize::from(!surface_is_a)].as_ref()?;
                let depth = faces.depth(solid, &beside, &normal, scratch);
                Some(ContactPoint { position, normal, depth })
            }
            Local::Cube { side, set, index } => {
                let measured = self.cubes[side].as_ref()?.measured(set, index, scratch);
                let fallback = self.query.deepest.normal.unwrap_or_else(Vector::z);
                let (normal, depth) =
                    measured.map_or((fallback, None), |(normal, depth)| (normal, Some(depth)));
                Some(ContactPoint { position, normal, depth })
            }
        }
    }
}

/// The direction in which two primitives separate by the shortest way, if they come within the margin (m).
fn normal_of(a: &RoundedShape, b: &RoundedShape, pose_ab: &MatrixPose, margin: f64) -> Option<Vector> {
    let limit = margin.greater(CONTACT_DISTANCE);
    let found = separation_within(a, b, pose_ab, limit).filter(|found| found.distance <= limit)?;
    if found.distance > 0.0 {
        return Some(found.direction());
    }
    let [a, b] = [a, b].map(|shape| ConvexSolid::Primitive(*shape));
    depth_of_convex(&a, &b, pose_ab).map(|depth| depth.direction)
}
