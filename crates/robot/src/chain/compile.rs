//! Compiler from the joints of a robot to the steps of a kinematic chain, with precomputed constant parts.

use clearance_geometry::math::{Pose, RotationMatrix, UnitVector, Vector};

use super::{Body, Chain, ChainJoint, EightSources, Frame, LinkInBody, Motion, Source, Step, Turn};

impl Chain {
    /// Compiles `joints`, parents first, of a robot whose links are numbered; `needed` marks the links whose frames will be needed.
    ///
    /// # Panics
    /// If a joint names a link beyond `needed`, or its parent does not have a pose yet.
    #[must_use]
    pub fn compile(root: usize, joints: &[ChainJoint], needed: &[bool]) -> Self {
        let mut draft = Draft::new(root, joints, needed.len());
        draft.drop_unneeded(needed);
        let aims = draft.aims();
        let bodies: Vec<Body> =
            draft.bodies.iter().zip(&aims).filter_map(|(b, &aim)| b.finish(aim, &aims)).collect();
        let seats = draft.seats.iter().map(|s| Some(s.as_ref()?.aimed(&aims))).collect();
        let angles = bodies.chunks(8).map(EightSources::of).collect();
        Self { bodies, angles, seats }
    }
}

impl From<&Pose> for Frame<f64> {
    fn from(pose: &Pose) -> Self {
        Place::from(pose).frame()
    }
}

/// A constant frame during compilation.
#[derive(Clone, Copy, Debug)]
struct Place {
    r: RotationMatrix,
    t: Vector,
}

impl Place {
    fn identity() -> Self {
        Self { r: RotationMatrix::identity(), t: Vector::zeros() }
    }

    /// The composition of `self` and the frame `inner` within it.
    fn then(&self, inner: &Self) -> Self {
        Self { r: self.r * inner.r, t: self.r * inner.t + self.t }
    }

    fn turned_by(&self, r: &RotationMatrix) -> Self {
        Self { r: self.r * r, t: self.t }
    }

    /// This frame relative to a frame that is rotated by `aim` about z.
    fn seen_from(&self, aim: f64) -> Self {
        let back = about_z(-aim);
        Self { r: back * self.r, t: back * self.t }
    }

    fn frame(&self) -> Frame<f64> {
        Frame { r: columns(&self.r), t: self.t.into() }
    }
}

impl From<&Pose> for Place {
    fn from(pose: &Pose) -> Self {
        Self { r: pose.rotation.to_rotation_matrix().into_inner(), t: pose.translation.vector }
    }
}

fn columns(r: &RotationMatrix) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| r.column(i).into_owned().into())
}

fn about_z(angle: f64) -> RotationMatrix {
    let (sin, cos) = angle.sin_cos();
    RotationMatrix::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
}

/// A rotation that takes z to `axis`, by the shortest way.
fn z_onto(axis: &UnitVector) -> RotationMatrix {
    let turn = nalgebra::Rotation3::rotation_between(&Vector::z(), axis);
    turn.map_or(RotationMatrix::from_diagonal(&Vector::new(1.0, -1.0, -1.0)), nalgebra::Rotation3::into_inner)
}

/// Bodies and link seats, before the frames of revolute bodies are aligned with their children.
struct Draft {
    bodies: Vec<DraftBody>,
    seats: Vec<Option<DraftSeat>>,
}

#[derive(Clone, Debug)]
struct DraftBody {
    parent: usize,
    /// Pose in the parent body at position zero.
    place: Place,
    motion: DraftMotion,
    /// True if this is the child that its parent's x axis is aligned with.
    aimed_at: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum DraftMotion {
    Root,
    /// Rotation about z of the body's frame.
    Turn(Source),
    /// Translation along an axis in the parent body.
    Shift(Vector, Source),
    Float(usize),
}

#[derive(Clone, Copy, Debug)]
struct DraftSeat {
    body: usize,
    place: Place,
}

impl Draft {
    fn new(root: usize, joints: &[ChainJoint], links: usize) -> Self {
        let body =
            DraftBody { parent: 0, place: Place::identity(), motion: DraftMotion::Root, aimed_at: false };
        let mut draft = Self { bodies: vec![body], seats: vec![None; links] };
        draft.seats[root] = Some(DraftSeat { body: 0, place: Place::identity() });
        for joint in joints {
            let parent = draft.seats[joint.parent].expect("parents come before children");
            let place = parent.place.then(&Place::from(&joint.pose_pj));
            draft.seats[joint.child] = Some(draft.add(DraftSeat { body: parent.body, place }, &joint.motion));
        }
        draft
    }

    /// The pose in its body of a link that is moved by `joint`.
    fn add(&mut self, joint: DraftSeat, motion: &Motion) -> DraftSeat {
        let position = |index| Source { index, multiplier: 1.0, offset: 0.0 };
        match *motion {
            Motion::Fixed => joint,
            Motion::Revolute(axis, source) => self.add_turn(joint, &z_onto(&axis), source),
            Motion::Prismatic(axis, source) => self.add_shift(joint, &axis, source),
            Motion::Planar(plane, first) => {
                let along = |i| plane.column(i).into_owned();
                let joint = self.add_shift(joint, &along(0), position(first));
                let joint = self.add_shift(joint, &along(1), position(first + 1));
                self.add_turn(joint, &plane, position(first + 2))
            }
            Motion::Floating(first) => self.add_body(joint.body, joint.place, DraftMotion::Float(first)),
        }
    }

    /// A body that rotates about the z column of `axes`; the pose of its link compensates for these axes.
    fn add_turn(&mut self, joint: DraftSeat, axes: &RotationMatrix, source: Source) -> DraftSeat {
        let seat = self.add_body(joint.body, joint.place.turned_by(axes), DraftMotion::Turn(source));
        DraftSeat { place: seat.place.turned_by(&axes.transpose()), ..seat }
    }

    /// A prismatic body that keeps its parent's orientation; the pose of its link compensates for the joint's orientation.
    fn add_shift(&mut self, joint: DraftSeat, axis: &Vector, source: Source) -> DraftSeat {
        let Place { r, t } = joint.place;
        let place = Place { r: RotationMatrix::identity(), t };
        let seat = self.add_body(joint.body, place, DraftMotion::Shift(r * axis, source));
        DraftSeat { place: seat.place.turned_by(&r), ..seat }
    }

    fn add_body(&mut self, parent: usize, place: Place, motion: DraftMotion) -> DraftSeat {
        self.bodies.push(DraftBody { parent, place, motion, aimed_at: false });
        DraftSeat { body: self.bodies.len() - 1, place: Place::identity() }
    }

    /// Keeps the poses of needed links, their bodies, and the ancestors of these bodies.
    fn drop_unneeded(&mut self, needed: &[bool]) {
        let mut keep = vec![false; self.bodies.len()];
        keep[0] = true;
        for (seat, _) in self.seats.iter_mut().zip(needed).filter(|(_, needed)| !**needed) {
            *seat = None;
        }
        for seat in self.seats.iter().flatten() {
            keep[seat.body] = true;
        }
        for i in (1..keep.len()).rev() {
            keep[self.bodies[i].parent] |= keep[i];
        }
        let mut kept = 0;
        let renumbered: Vec<usize> = keep.iter().map(|&k| (kept, kept += usize::from(k)).0).collect();
        let mut keeping = keep.iter();
        self.bodies.retain(|_| keeping.next() == Some(&true));
        for body in &mut self.bodies {
            body.parent = renumbered[body.parent];
        }
        for seat in self.seats.iter_mut().flatten() {
            seat.body = renumbered[seat.body];
        }
    }

    /// Rotation of each body's frame about z that makes its x axis the common normal of its own axis and the axis of its first revolute
    /// child. Prismatic bodies rotate with their parents.
    fn aims(&mut self) -> Vec<f64> {
        let turns = |body: &DraftBody| matches!(body.motion, DraftMotion::Turn(_));
        let mut aims: Vec<Option<f64>> = vec![None; self.bodies.len()];
        for i in 1..self.bodies.len() {
            let parent = self.bodies[i].parent;
            if turns(&self.bodies[i]) && turns(&self.bodies[parent]) && aims[parent].is_none() {
                aims[parent] = Some(normal_direction(&self.bodies[i].place.r));
                self.bodies[i].aimed_at = true;
            }
        }
        for (i, body) in self.bodies.iter().enumerate() {
            if let DraftMotion::Shift(..) = body.motion {
                aims[i] = aims[body.parent];
            }
        }
        aims.into_iter().map(Option::unwrap_or_default).collect()
    }
}

/// The angle a of `r = Rz(a) Rx(α) Rz(b)` with sin α ≥ 0: its third column is (sin a sin α, −cos a sin α, cos α).
fn normal_direction(r: &RotationMatrix) -> f64 {
    match (r[(0, 2)], -r[(1, 2)]) {
        // parallel axes
        (0.0, 0.0) => 0.0,
        (sin, cos) => sin.atan2(cos),
    }
}

impl DraftBody {
    /// The body with its frame rotated by `aim` about z, in a parent rotated by its own angle; `None` for the root's.
    fn finish(&self, aim: f64, aims: &[f64]) -> Option<Body> {
        let place = self.place.seen_from(aims[self.parent]);
        let step = match self.motion {
            DraftMotion::Turn(source) if self.aimed_at => {
                // place.r = Rx(α) Rz(b): first row (cos b, −sin b, 0), third column (0, −sin α, cos α)
                let b = (-place.r[(0, 1)]).atan2(place.r[(0, 0)]);
                let (sin, cos) = (-place.r[(1, 2)], place.r[(2, 2)]);
                let length = sin.hypot(cos);
                Step::Turn(Turn::Twist { cos: cos / length, sin: sin / length }, source.shifted(b + aim))
            }
            DraftMotion::Turn(source) if self.parent == 0 => {
                Step::Turn(Turn::Root(columns(&place.r)), source.shifted(aim))
            }
            DraftMotion::Turn(source) => Step::Turn(Turn::Full(columns(&place.r)), source.shifted(aim)),
            DraftMotion::Shift(axis, source) => {
                Step::Shift((about_z(-aims[self.parent]) * axis).into(), source)
            }
            DraftMotion::Float(first) => Step::Float(columns(&place.r), first),
            DraftMotion::Root => return None,
        };
        Some(Body { parent: self.parent, origin: place.t.into(), step })
    }
}

impl DraftSeat {
    fn aimed(&self, aims: &[f64]) -> LinkInBody {
        LinkInBody { body: self.body, place: self.place.seen_from(aims[self.body]).frame() }
    }
}

impl Source {
    /// The same position with another zero, minus full turns.
    fn shifted(self, angle: f64) -> Self {
        let turn = std::f64::consts::TAU;
        Self { offset: self.offset + (angle - (angle / turn).round() * turn), ..self }
    }
}
