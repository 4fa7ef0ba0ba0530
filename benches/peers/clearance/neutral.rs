//! Writer of the neutral file format: robots, worlds, meshes, states and poses for all contestants. See `README.md`.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use clearance::geometry::math::{Point, Pose};
use clearance::geometry::{PointCloud, Primitive, Shape, TriangleMesh};
use clearance::robot::{JointKind, LinkId};
use clearance::{CollisionChecker, Configuration, RobotModel, World};

pub struct Neutral(BufWriter<File>);

impl Neutral {
    pub fn create(file: &Path, name: &str) -> io::Result<Self> {
        let mut out = BufWriter::new(File::create(file)?);
        writeln!(out, "neutral\t1\t{name}")?;
        Ok(Self(out))
    }

    pub fn finish(mut self) -> io::Result<()> {
        self.0.flush()
    }

    /// All links, parents first, then their shapes, then the pairs.
    pub fn robot(&mut self, checker: &CollisionChecker) -> io::Result<()> {
        let robot = checker.robot();
        let order: Vec<LinkId> = std::iter::once(robot.root())
            .chain(robot.topological_order().iter().map(|&j| robot.joint(j).child))
            .collect();
        for &link in &order {
            self.link(robot, link)?;
        }
        for &link in &order {
            for collision in &robot.link(link).collisions {
                self.shape(link.0, &collision.pose_ls, &collision.shape)?;
            }
        }
        for (a, b) in checker.pairs().link_pairs() {
            writeln!(self.0, "pair\t{}\t{}", a.0, b.0)?;
        }
        Ok(())
    }

    fn link(&mut self, robot: &RobotModel, link: LinkId) -> io::Result<()> {
        let name = &robot.link(link).name;
        let Some(id) = robot.link(link).parent_joint else {
            return writeln!(
                self.0,
                "link\t{}\t{name}\t\t-1\tfixed\t-1\t1\t0\t0\t0\t1\t{}",
                link.0,
                pose(&Pose::identity())
            );
        };
        let joint = robot.joint(id);
        let (kind, axis) = match &joint.kind {
            JointKind::Revolute(axis) | JointKind::Continuous(axis) => ("turns", axis.into_inner()),
            JointKind::Prismatic(axis) => ("slides", axis.into_inner()),
            // planar and floating joints are never moved here, and their default is the identity
            _ => ("fixed", clearance::geometry::math::Vector::z()),
        };
        let mimic = joint.mimic.map_or((id, 1.0, 0.0), |m| (m.joint, m.multiplier, m.offset));
        let position = match kind {
            "fixed" => "-1".to_owned(),
            _ => robot.first_position(mimic.0).map_or("-1".to_owned(), |first| first.to_string()),
        };
        writeln!(
            self.0,
            "link\t{}\t{name}\t{}\t{}\t{kind}\t{position}\t{}\t{}\t{}\t{}\t{}\t{}",
            link.0,
            joint.name,
            joint.parent.0,
            mimic.1,
            mimic.2,
            axis.x,
            axis.y,
            axis.z,
            pose(&joint.pose_pj)
        )
    }

    fn shape(&mut self, link: u32, pose_ls: &Pose, shape: &Shape) -> io::Result<()> {
        let place = pose(pose_ls);
        match shape {
            Shape::Mesh(mesh) => self.mesh(link, mesh, pose_ls),
            Shape::Primitive(Primitive::Box { half_extents: [x, y, z] }) => {
                writeln!(self.0, "box\t{}\t{}\t{}\t{}\t{place}", link, 2.0 * x, 2.0 * y, 2.0 * z)
            }
            Shape::Primitive(Primitive::Sphere { radius }) => {
                writeln!(self.0, "sphere\t{link}\t{radius}\t{place}")
            }
            Shape::Primitive(Primitive::Cylinder { radius, half_length }) => {
                writeln!(self.0, "cylinder\t{}\t{radius}\t{}\t{place}", link, 2.0 * half_length)
            }
            Shape::Primitive(Primitive::Capsule { radius, half_length }) => {
                writeln!(self.0, "capsule\t{}\t{radius}\t{}\t{place}", link, 2.0 * half_length)
            }
            Shape::Points(cloud) => self.cloud(link, cloud, pose_ls),
            other => panic!("the robots and worlds measured have no {}", other.kind()),
        }
    }

    /// The triangles of a mesh in the frame of its link.
    fn mesh(&mut self, link: u32, mesh: &TriangleMesh, pose_ls: &Pose) -> io::Result<()> {
        writeln!(self.0, "mesh\t{link}\t{}\t{}", mesh.vertices().len(), mesh.triangles().len())?;
        for vertex in mesh.vertices() {
            let p: Point = pose_ls * vertex;
            writeln!(self.0, "{}\t{}\t{}", p.x, p.y, p.z)?;
        }
        for [a, b, c] in mesh.triangles() {
            writeln!(self.0, "{a}\t{b}\t{c}")?;
        }
        Ok(())
    }

    /// The points of a cloud in the frame of its link.
    fn cloud(&mut self, link: u32, cloud: &PointCloud, pose_ls: &Pose) -> io::Result<()> {
        writeln!(self.0, "cloud\t{link}\t{}\t{}", cloud.points().len(), cloud.radius())?;
        for point in cloud.points() {
            let p = pose_ls * Point::from(point.map(f64::from));
            writeln!(self.0, "{}\t{}\t{}", p.x, p.y, p.z)?;
        }
        Ok(())
    }

    /// Every obstacle is a link without a parent, in the frame of the robot's root.
    pub fn world(&mut self, world: &World) -> io::Result<()> {
        let identity = pose(&Pose::identity());
        for (id, obstacle) in (0..).zip(world.obstacles()) {
            writeln!(self.0, "link\t{id}\t{}\t\t-1\tfixed\t-1\t1\t0\t0\t0\t1\t{identity}", obstacle.name)?;
            for (pose_rs, shape) in obstacle.placed_shapes() {
                self.shape(id, &pose_rs, shape)?;
            }
        }
        Ok(())
    }

    /// A mesh at rest and one that every state places anew.
    pub fn mesh_pair(&mut self, [a, b]: [&TriangleMesh; 2]) -> io::Result<()> {
        let identity = pose(&Pose::identity());
        writeln!(self.0, "link\t0\ta\t\t-1\tfixed\t-1\t1\t0\t0\t0\t1\t{identity}")?;
        writeln!(self.0, "link\t1\tb\t\t0\tplaced\t0\t1\t0\t0\t0\t1\t{identity}")?;
        self.mesh(0, a, &Pose::identity())?;
        self.mesh(1, b, &Pose::identity())?;
        writeln!(self.0, "pair\t0\t1")
    }

    pub fn states(&mut self, set: &str, states: &[Configuration]) -> io::Result<()> {
        writeln!(self.0, "states\t{set}\t{}", states.len())?;
        for q in states {
            let words: Vec<String> = q.positions().iter().map(f64::to_string).collect();
            writeln!(self.0, "{}", words.join("\t"))?;
        }
        Ok(())
    }

    /// Of every position; for who draws states.
    pub fn limits(&mut self, bounds: &[(f64, f64)]) -> io::Result<()> {
        bounds.iter().try_for_each(|(lower, upper)| writeln!(self.0, "limits\t{lower}\t{upper}"))
    }

    pub fn poses(&mut self, set: &str, poses: &[Pose]) -> io::Result<()> {
        writeln!(self.0, "states\t{set}\t{}", poses.len())?;
        for p in poses {
            writeln!(self.0, "{}", pose(p))?;
        }
        Ok(())
    }
}

/// The upper three rows of the homogeneous matrix, row by row.
fn pose(pose: &Pose) -> String {
    let matrix = pose.to_homogeneous();
    let rows = (0..3).flat_map(|row| (0..4).map(move |column| (row, column)));
    rows.map(|at| matrix[at].to_string()).collect::<Vec<_>>().join("\t")
}
