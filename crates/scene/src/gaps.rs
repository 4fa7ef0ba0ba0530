//! Gaps in a scene: announced objects or settings that were rejected, and the later updates that close them.

use super::{AttachedChange, ObjectChange, Operation, SceneChange, SceneUpdate};

/// An announced object or setting that is not in the scene as announced.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Gap {
    pub subject: Subject,
    /// Name of the object or link; empty for an object without a name, an octomap and a matrix.
    pub name: String,
    pub extent: Extent,
}

/// The part of a scene that a gap is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    /// An obstacle of the world.
    Object,
    /// An object that was to be attached to a link, or to be detached.
    Attached,
    Octomap,
    /// The allowed collision matrix.
    Matrix,
    LinkPadding,
    LinkScale,
}

/// Extent of the difference from the announced content.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Extent {
    /// Its shapes are in the scene, but its pose or its link is not as announced.
    Pose,
    /// Shapes may be missing.
    Shapes,
}

impl Gap {
    #[must_use]
    pub fn new(subject: Subject, name: impl Into<String>, extent: Extent) -> Self {
        Self { subject, name: name.into(), extent }
    }
}

impl SceneUpdate {
    /// The rest of a gap after this update; `None` if the update closes it. `is_rejected`: true if a part of the update for the same
    /// object was rejected.
    ///
    /// Only an update that defines an object completely closes its gap: after a move, shapes that were rejected before are still missing.
    #[must_use]
    pub fn left_of(&self, gap: Gap, is_rejected: bool) -> Option<Gap> {
        let is_octomap = gap.subject == Subject::Octomap;
        match self {
            Self::Object(object) => object.left_of(gap, is_rejected),
            Self::Attached(attached) => attached.left_of(gap, is_rejected),
            Self::World(_) => Some(gap).filter(|gap| gap.subject != Subject::Object && !is_octomap),
            Self::Octomap(_) => Some(gap).filter(|_| !is_octomap || is_rejected),
            Self::Scene(scene) if scene.is_diff => scene.left_of(gap, is_rejected),
            Self::Scene(scene) => {
                let keeps = (is_octomap && scene.keeps_octomap)
                    || (gap.subject == Subject::Attached && scene.robot_state.is_diff);
                if keeps { scene.left_of(gap, is_rejected) } else { None }
            }
        }
    }

    /// The gaps that remain if no part of this update is applied.
    #[must_use]
    pub fn announced(&self) -> Vec<Gap> {
        let object = |object: &ObjectChange| match object.operation {
            Operation::Remove => None,
            Operation::Move => Some(Gap::new(Subject::Object, &object.id, Extent::Pose)),
            Operation::Add | Operation::Append => Some(Gap::new(Subject::Object, &object.id, Extent::Shapes)),
        };
        let attached =
            |attached: &AttachedChange| Gap::new(Subject::Attached, &attached.object.id, attached.extent());
        let octomap = || Gap::new(Subject::Octomap, "", Extent::Shapes);
        match self {
            Self::Object(change) => object(change).into_iter().collect(),
            Self::Attached(change) => vec![attached(change)],
            Self::Octomap(map) => map.iter().map(|_| octomap()).collect(),
            Self::World(world) => {
                let octomap = world.octomap.iter().map(|_| octomap());
                world.objects.iter().filter_map(object).chain(octomap).collect()
            }
            Self::Scene(scene) => {
                let held = scene.robot_state.attached.iter().map(attached);
                let octomap = scene.world.octomap.iter().map(|_| octomap());
                held.chain(scene.world.objects.iter().filter_map(object)).chain(octomap).collect()
            }
        }
    }
}

impl ObjectChange {
    fn left_of(&self, gap: Gap, is_rejected: bool) -> Option<Gap> {
        let is_all = self.id.is_empty() && self.operation == Operation::Remove;
        let is_about = match gap.subject {
            Subject::Object => is_all || self.id == gap.name,
            // an object removed from the world may be attached to the robot since then
            Subject::Attached => self.id == gap.name && self.operation != Operation::Remove,
            Subject::Octomap | Subject::Matrix | Subject::LinkPadding | Subject::LinkScale => false,
        };
        let closes = match self.operation {
            Operation::Remove => true,
            Operation::Add => !is_rejected,
            Operation::Move => !is_rejected && gap.extent == Extent::Pose,
            Operation::Append => false,
        };
        Some(gap).filter(|_| !(is_about && closes))
    }
}

impl AttachedChange {
    /// The world still has the shapes of an object that is attached or detached by its name alone.
    pub(super) fn extent(&self) -> Extent {
        if self.object.shapes.is_empty() { Extent::Pose } else { Extent::Shapes }
    }

    fn left_of(&self, gap: Gap, is_rejected: bool) -> Option<Gap> {
        let ObjectChange { id, operation, shapes, .. } = &self.object;
        let is_of_objects = matches!(gap.subject, Subject::Object | Subject::Attached);
        let is_all = id.is_empty() && *operation == Operation::Remove && self.link.is_empty();
        if !is_of_objects || (gap.name != *id && !is_all) {
            return Some(gap);
        }
        let is_held = gap.subject == Subject::Attached;
        match operation {
            // an object that was to be attached must be in the world from now on
            Operation::Remove if is_held && (is_all || is_rejected || gap.extent == Extent::Shapes) => {
                Some(Gap { subject: Subject::Object, ..gap })
            }
            Operation::Remove => Some(gap).filter(|_| !is_held),
            Operation::Add if shapes.is_empty() => {
                Some(gap).filter(|gap| is_rejected || !is_held || gap.extent == Extent::Shapes)
            }
            Operation::Add => Some(gap).filter(|_| is_rejected),
            Operation::Append | Operation::Move => Some(gap),
        }
    }
}

impl SceneChange {
    fn left_of(&self, gap: Gap, is_rejected: bool) -> Option<Gap> {
        let names = |sizes: &[(String, f64)]| sizes.iter().any(|(link, _)| *link == gap.name);
        let is_given = match gap.subject {
            Subject::Octomap => self.world.octomap.is_some(),
            Subject::Matrix => !self.matrix.entry_names.is_empty(),
            Subject::LinkPadding => names(&self.link_padding),
            Subject::LinkScale => names(&self.link_scale),
            Subject::Object | Subject::Attached => {
                let mut held = self.robot_state.attached.iter();
                let gap = held.try_fold(gap, |gap, attached| attached.left_of(gap, is_rejected))?;
                let mut objects = self.world.objects.iter();
                return objects.try_fold(gap, |gap, object| object.left_of(gap, is_rejected));
            }
        };
        Some(gap).filter(|_| !is_given || is_rejected)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ObstacleShape;
    use clearance_geometry::math::Pose;
    use clearance_geometry::{Primitive, Shape};

    fn object(operation: Operation) -> SceneUpdate {
        SceneUpdate::Object(Box::new(ObjectChange::named("a", operation)))
    }

    fn attached(operation: Operation, with_shapes: bool) -> SceneUpdate {
        let mut object = ObjectChange::named("a", operation);
        if with_shapes {
            let shape = Shape::Primitive(Primitive::sphere(0.1).unwrap());
            object.shapes.push(ObstacleShape { pose_os: Pose::identity(), shape });
        }
        SceneUpdate::Attached(Box::new(AttachedChange { link: String::new(), object, touch_links: vec![] }))
    }

    fn scene(is_diff: bool, keeps_held: bool) -> SceneUpdate {
        let mut scene = SceneChange { is_diff, ..SceneChange::default() };
        scene.robot_state.is_diff = keeps_held;
        SceneUpdate::Scene(Box::new(scene))
    }

    fn gap(subject: Subject, extent: Extent) -> Gap {
        Gap::new(subject, "a", extent)
    }

    #[test]
    fn only_what_gives_all_of_an_object_closes_its_gap() {
        use Extent::{Pose, Shapes};
        use Operation::{Add, Append, Move, Remove};
        use Subject::{Attached, Object};
        // per update: the rest of a gap of a pose and of shapes in the world, and of a pose and of shapes of an attached object
        let table = [
            (object(Add), [None, None, None, None]),
            (object(Remove), [None, None, Some((Attached, Pose)), Some((Attached, Shapes))]),
            (object(Move), [None, Some((Object, Shapes)), None, Some((Attached, Shapes))]),
            (
                object(Append),
                [
                    Some((Object, Pose)),
                    Some((Object, Shapes)),
                    Some((Attached, Pose)),
                    Some((Attached, Shapes)),
                ],
            ),
            (attached(Add, true), [None, None, None, None]),
            (
                attached(Add, false),
                [Some((Object, Pose)), Some((Object, Shapes)), None, Some((Attached, Shapes))],
            ),
            (
                attached(Remove, false),
                [Some((Object, Pose)), Some((Object, Shapes)), None, Some((Object, Shapes))],
            ),
            (
                SceneUpdate::World(Box::default()),
                [None, None, Some((Attached, Pose)), Some((Attached, Shapes))],
            ),
            (scene(false, false), [None; 4]),
            (scene(false, true), [None, None, Some((Attached, Pose)), Some((Attached, Shapes))]),
        ];
        let gaps = [gap(Object, Pose), gap(Object, Shapes), gap(Attached, Pose), gap(Attached, Shapes)];
        for (update, left) in table {
            for (gap, left) in gaps.iter().zip(left) {
                let found = update.left_of(gap.clone(), false).map(|gap| (gap.subject, gap.extent));
                assert_eq!(found, left, "{update:?} after {gap:?}");
            }
        }
    }

    #[test]
    fn what_was_rejected_itself_closes_nothing_but_by_a_removal() {
        use Operation::{Add, Move, Remove};
        for subject in [Subject::Object, Subject::Attached] {
            for update in
                [object(Add), object(Move), attached(Add, true), attached(Add, false), scene(true, true)]
            {
                let gap = gap(subject, Extent::Pose);
                assert_eq!(update.left_of(gap.clone(), true), Some(gap), "{update:?}");
            }
        }
        assert_eq!(object(Remove).left_of(gap(Subject::Object, Extent::Shapes), true), None);
        // an object that was never attached, and is detached, must be in the world
        let left = attached(Remove, false).left_of(gap(Subject::Attached, Extent::Pose), true);
        assert_eq!(left, Some(gap(Subject::Object, Extent::Pose)));
    }

    #[test]
    fn an_octomap_a_matrix_and_sizes_are_closed_by_others_of_their_kind_alone() {
        let octomap = Gap::new(Subject::Octomap, "", Extent::Shapes);
        assert_eq!(SceneUpdate::Octomap(None).left_of(octomap.clone(), false), None);
        assert_eq!(SceneUpdate::Octomap(None).left_of(octomap.clone(), true), Some(octomap.clone()));
        assert_eq!(scene(true, true).left_of(octomap.clone(), false), Some(octomap.clone()));
        let world = SceneUpdate::World(Box::default());
        assert_eq!(world.left_of(octomap, false), None);
        let padding = Gap::new(Subject::LinkPadding, "tip", Extent::Shapes);
        let with = |link: &str| {
            let link_padding = vec![(link.to_owned(), 0.1)];
            SceneUpdate::Scene(Box::new(SceneChange { is_diff: true, link_padding, ..Default::default() }))
        };
        assert_eq!(with("base").left_of(padding.clone(), false), Some(padding.clone()));
        assert_eq!(with("tip").left_of(padding.clone(), true), Some(padding.clone()));
        assert_eq!(with("tip").left_of(padding.clone(), false), None);
        assert_eq!(world.left_of(padding.clone(), false), Some(padding));
    }
}
