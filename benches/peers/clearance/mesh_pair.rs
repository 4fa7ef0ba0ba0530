//! Benchmark queries of two meshes, at generated poses of known gap or in contact.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use clearance::MeshFiles;
use clearance::geometry::math::{Pose, Rotation, Vector};
use clearance::geometry::{Shape, TriangleMesh};
use clearance::proximity::{CollisionBody, Scratch, collide, distance};

use crate::Outcome;
use crate::answer::Answer;
use crate::neutral::Neutral;
use crate::random::Random;
use crate::volume_cost_model::{Cost, cost_model};

/// Name and width (m) of each gap.
const GAPS: [(&str, f64); 6] =
    [("0.1mm", 1e-4), ("1mm", 1e-3), ("3mm", 3e-3), ("10mm", 1e-2), ("30mm", 3e-2), ("100mm", 1e-1)];

/// The set of poses in which the meshes cut each other.
const TOUCHING: &str = "touching";

/// How exactly a gap must be met, as a share of it.
const GAP_ACCURACY: f64 = 0.01;

/// Steps after which a direction along which the gap is hard to meet is given up.
const MOST_STEPS: usize = 100;

/// How deep (m) the meshes are pushed into each other to touch, at most.
const DEPTH: f64 = 0.005;

pub struct MeshPair {
    bodies: [CollisionBody; 2],
    meshes: [Arc<TriangleMesh>; 2],
    poses: BTreeMap<&'static str, Vec<Pose>>,
}

/// A line along which mesh b, turned, comes to mesh a.
struct Approach {
    rotation: Rotation,
    direction: Vector,
    centres: [Vector; 2],
    /// Sum of the radii of spheres around the meshes (m).
    reach: f64,
}

impl Approach {
    fn draw(random: &mut Random, centres: [Vector; 2], reach: f64) -> Self {
        let [x, y, z, w] = random.in_ball::<4>();
        Self {
            rotation: Rotation::from_quaternion(nalgebra::Quaternion::new(w, x, y, z)),
            direction: Vector::from(random.in_ball::<3>()).normalize(),
            centres,
            reach,
        }
    }

    /// Pose of b in the frame of a with the centres `shift` (m) apart.
    fn pose(&self, shift: f64) -> Pose {
        let to = self.centres[0] + self.direction * shift - self.rotation * self.centres[1];
        Pose::from_parts(to.into(), self.rotation)
    }
}

impl MeshPair {
    /// Reads two meshes, finds `count` poses for every gap, and writes everything down for the others.
    pub fn prepare(a: &str, b: &str, seed: u64, count: usize, out: &str) -> Outcome<Self> {
        let meshes = [load(a)?, load(b)?];
        let bodies = [body(&meshes[0])?, body(&meshes[1])?];
        let mut poses: BTreeMap<&str, Vec<Pose>> = BTreeMap::new();
        let mut random = Random::new(seed);
        let around = [ball(&meshes[0]), ball(&meshes[1])];
        let reach = around[0].1 + around[1].1;
        for (set, gap) in GAPS {
            let found = poses.entry(set).or_default();
            for _ in 0..50 * count {
                let approach = Approach::draw(&mut random, [around[0].0, around[1].0], reach);
                if found.len() < count {
                    found.extend(shift_to(&bodies, &approach, gap).map(|shift| approach.pose(shift)));
                }
            }
        }
        let found = poses.entry(TOUCHING).or_default();
        for _ in 0..50 * count {
            let approach = Approach::draw(&mut random, [around[0].0, around[1].0], reach);
            let depth = random.between(0.1, 1.0) * DEPTH;
            if found.len() < count {
                let pose = shift_to(&bodies, &approach, 1e-4).map(|shift| approach.pose(shift - depth));
                found.extend(pose.filter(|pose| touch(&bodies, pose)));
            }
        }
        let mut neutral = Neutral::create(Path::new(out), "mesh pair")?;
        neutral.mesh_pair([&meshes[0], &meshes[1]])?;
        for (set, poses) in &poses {
            neutral.poses(set, poses)?;
        }
        neutral.finish()?;
        Ok(Self { bodies, meshes, poses })
    }

    /// `key=value` words for the report.
    pub fn summary(&self) -> String {
        let sets = self.poses.iter().map(|(set, poses)| format!("\t{set}={}", poses.len()));
        let [a, b] = self.meshes.each_ref().map(|m| m.triangles().len());
        format!("a={a}\tb={b}{}", sets.collect::<String>())
    }

    /// `volume question n_bv c_bv n_p c_p` of every volume type, separated by tabs; times in ns.
    pub fn costs(&self) -> String {
        let lines = cost_model(&self.meshes, &self.poses).into_iter().map(|c| {
            let Cost { volume, question, volume_tests, volume_test_ns, primitive_tests, primitive_test_ns } = c;
            format!(
                "{volume} {question} {volume_tests:.1} {volume_test_ns:.2} {primitive_tests:.1} {primitive_test_ns:.2}"
            )
        });
        lines.collect::<Vec<_>>().join("\t")
    }

    pub fn ask(&mut self, question: &str, set: &str, mut hear: impl FnMut(Answer)) -> Outcome<bool> {
        let [a, b] = &self.bodies;
        let poses = self.poses.get(set).ok_or_else(|| format!("no poses '{set}'"))?;
        let mut scratch = Scratch::default();
        match question {
            "free" => {
                for pose_ab in poses {
                    hear(Answer::Free(collide(a, b, pose_ab, &mut scratch).is_none()));
                }
            }
            "distance" => {
                for pose_ab in poses {
                    let found = distance(a, b, pose_ab, f64::INFINITY, &mut scratch);
                    hear(Answer::Distance(found.map(|s| s.distance)));
                }
            }
            _ => return Ok(false),
        }
        Ok(true)
    }
}

/// How far the centres are apart when the meshes first come within `gap` of each other, from outside.
///
/// A shift by the distance that is missing never passes the gap, since no point moves farther than the shift.
fn shift_to(bodies: &[CollisionBody; 2], approach: &Approach, gap: f64) -> Option<f64> {
    let mut shift = approach.reach + gap;
    for _ in 0..MOST_STEPS {
        let apart =
            distance(&bodies[0], &bodies[1], &approach.pose(shift), f64::INFINITY, &mut Scratch::default())?
                .distance;
        if (apart - gap).abs() <= GAP_ACCURACY * gap {
            return Some(shift);
        }
        shift -= apart - gap;
        if shift < -approach.reach {
            break;
        }
    }
    None
}

fn touch(bodies: &[CollisionBody; 2], pose_ab: &Pose) -> bool {
    collide(&bodies[0], &bodies[1], pose_ab, &mut Scratch::default()).is_some()
}

fn load(file: &str) -> Outcome<Arc<TriangleMesh>> {
    let path = Path::new(file);
    let folder = path.parent().ok_or("a mesh without a folder")?;
    let name = path.file_name().and_then(|n| n.to_str()).ok_or("a mesh without a name")?;
    Ok(MeshFiles::under(folder).load(name, Vector::from_element(1.0))?.mesh)
}

fn body(mesh: &Arc<TriangleMesh>) -> Outcome<CollisionBody> {
    let shape = Shape::Mesh(mesh.clone());
    Ok(CollisionBody::new([(&Pose::identity(), &shape)]).ok_or("a mesh without triangles")?)
}

/// Centre and radius of a ball around a mesh.
fn ball(mesh: &TriangleMesh) -> (Vector, f64) {
    let (lo, hi) = mesh.bounds();
    (nalgebra::center(&lo, &hi).coords, 0.5 * (hi - lo).norm())
}
