//! Effect of a scene update on the gaps of a scene: the gaps that it closes, and those that it opens if it is rejected.

use super::{
    AttachedChange, GapExtent, GapSubject, ObjectChange, Operation, SceneChange, SceneGap, SceneUpdate,
};

impl SceneUpdate {
    /// The rest of a gap after this update; `None` if the update closes it. `is_rejected`: true if a part of the update for the same
    /// object was rejected.
    ///
    /// Only an update that defines an object completely closes its gap: after a move, shapes that were rejected before are still missing.
    #[must_use]
    pub fn remaining_gap(&self, gap: SceneGap, is_rejected: bool) -> Option<SceneGap> {
        let is_octomap = gap.subject == GapSubject::Octomap;
        match self {
            Self::Object(object) => object.remaining_gap(gap, is_rejected),
            Self::Attached(attached) => attached.remaining_gap(gap, is_rejected),
            Self::States(given) => {
                let mut states = given.states.iter();
                states.try_fold(gap, |gap, state| state.change().remaining_gap(gap, is_rejected))
            }
            Self::World(_) => Some(gap).filter(|gap| gap.subject != GapSubject::Object && !is_octomap),
            Self::Octomap(_) => Some(gap).filter(|_| !is_octomap || is_rejected),
            Self::Scene(scene) if scene.is_diff => scene.remaining_gap(gap, is_rejected),
            Self::Scene(scene) => {
                let keeps = (is_octomap && scene.keeps_octomap)
                    || (gap.subject == GapSubject::Attached && scene.robot_state.is_diff);
                if keeps { scene.remaining_gap(gap, is_rejected) } else { None }
            }
        }
    }

    /// The gaps that remain if no part of this update is applied.
    #[must_use]
    pub fn announced_gaps(&self) -> Vec<SceneGap> {
        let object = |object: &ObjectChange| match object.operation {
            Operation::Remove => None,
            Operation::Move => Some(SceneGap::new(GapSubject::Object, &object.id, GapExtent::Pose)),
            Operation::Add | Operation::Append => {
                Some(SceneGap::new(GapSubject::Object, &object.id, GapExtent::Shapes))
            }
        };
        let attached = |attached: &AttachedChange| match attached.object.operation {
            // what is detached is in the world from then on
            Operation::Remove if attached.object.id.is_empty() => None,
            Operation::Remove => object(&ObjectChange::named(&attached.object.id, Operation::Move)),
            _ => Some(SceneGap::new(GapSubject::Attached, &attached.object.id, attached.extent())),
        };
        let octomap = || SceneGap::new(GapSubject::Octomap, "", GapExtent::Shapes);
        match self {
            Self::Object(change) => object(change).into_iter().collect(),
            Self::Attached(change) => attached(change).into_iter().collect(),
            Self::States(given) => given.states.iter().filter_map(|state| object(&state.change())).collect(),
            Self::Octomap(map) => map.iter().map(|_| octomap()).collect(),
            Self::World(world) => {
                let octomap = world.octomap.iter().map(|_| octomap());
                world.objects.iter().filter_map(object).chain(octomap).collect()
            }
            Self::Scene(scene) => {
                let held = scene.robot_state.attached.iter().filter_map(attached);
                let octomap = scene.world.octomap.iter().map(|_| octomap());
                held.chain(scene.world.objects.iter().filter_map(object)).chain(octomap).collect()
            }
        }
    }
}

impl ObjectChange {
    fn remaining_gap(&self, gap: SceneGap, is_rejected: bool) -> Option<SceneGap> {
        let is_all = self.id.is_empty() && self.operation == Operation::Remove;
        let is_about = match gap.subject {
            GapSubject::Object => is_all || self.id == gap.name,
            // an object removed from the world may be attached to the robot since then
            GapSubject::Attached => self.id == gap.name && self.operation != Operation::Remove,
            GapSubject::Octomap | GapSubject::Matrix | GapSubject::LinkPadding | GapSubject::LinkScale => {
                false
            }
        };
        let closes = match self.operation {
            Operation::Remove => true,
            Operation::Add => !is_rejected,
            Operation::Move => !is_rejected && gap.extent == GapExtent::Pose,
            Operation::Append => false,
        };
        Some(gap).filter(|_| !(is_about && closes))
    }
}

impl AttachedChange {
    /// Extent of the gap that this change leaves if it is rejected. The world still has the shapes of an object that is attached by
    /// its name alone.
    pub(super) fn extent(&self) -> GapExtent {
        match self.object.operation {
            Operation::Remove => GapExtent::Held,
            _ if self.object.shapes.is_empty() => GapExtent::Pose,
            _ => GapExtent::Shapes,
        }
    }

    fn remaining_gap(&self, gap: SceneGap, is_rejected: bool) -> Option<SceneGap> {
        let ObjectChange { id, operation, shapes, .. } = &self.object;
        let is_of_objects = matches!(gap.subject, GapSubject::Object | GapSubject::Attached);
        let is_of_several = id.is_empty() && *operation == Operation::Remove;
        let is_all = is_of_several && self.link.is_empty();
        // the gap of a rejected detachment of all objects of a link has the name of the link
        let names_it = if is_of_several { gap.name == self.link } else { !id.is_empty() && gap.name == *id };
        if !is_of_objects || !(names_it || is_all) {
            return Some(gap);
        }
        let is_held = gap.subject == GapSubject::Attached;
        match operation {
            Operation::Remove if gap.extent == GapExtent::Held => Some(gap).filter(|_| is_rejected),
            // an object that was to be attached must be in the world from now on
            Operation::Remove if is_held && (is_all || is_rejected || gap.extent == GapExtent::Shapes) => {
                Some(SceneGap { subject: GapSubject::Object, ..gap })
            }
            Operation::Remove => Some(gap).filter(|_| !is_held),
            Operation::Add if shapes.is_empty() => {
                Some(gap).filter(|gap| is_rejected || !is_held || gap.extent == GapExtent::Shapes)
            }
            Operation::Add => Some(gap).filter(|_| is_rejected),
            Operation::Append | Operation::Move => Some(gap),
        }
    }
}

impl SceneChange {
    fn remaining_gap(&self, gap: SceneGap, is_rejected: bool) -> Option<SceneGap> {
        let names = |sizes: &[(String, f64)]| sizes.iter().any(|(link, _)| *link == gap.name);
        let is_given = match gap.subject {
            GapSubject::Octomap => self.world.octomap.is_some(),
            GapSubject::Matrix => !self.matrix.entry_names.is_empty(),
            GapSubject::LinkPadding => names(&self.link_padding),
            GapSubject::LinkScale => names(&self.link_scale),
            GapSubject::Object | GapSubject::Attached => {
                let mut held = self.robot_state.attached.iter();
                let gap = held.try_fold(gap, |gap, attached| attached.remaining_gap(gap, is_rejected))?;
                let mut objects = self.world.objects.iter();
                return objects.try_fold(gap, |gap, object| object.remaining_gap(gap, is_rejected));
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

    fn gap(subject: GapSubject, extent: GapExtent) -> SceneGap {
        SceneGap::new(subject, "a", extent)
    }

    #[test]
    fn only_what_gives_all_of_an_object_closes_its_gap() {
        use GapExtent::{Pose, Shapes};
        use GapSubject::{Attached, Object};
        use Operation::{Add, Append, Move, Remove};
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
                let found = update.remaining_gap(gap.clone(), false).map(|gap| (gap.subject, gap.extent));
                assert_eq!(found, left, "{update:?} after {gap:?}");
            }
        }
    }

    #[test]
    fn what_was_rejected_itself_closes_nothing_but_by_a_removal() {
        use Operation::{Add, Move, Remove};
        for subject in [GapSubject::Object, GapSubject::Attached] {
            for update in
                [object(Add), object(Move), attached(Add, true), attached(Add, false), scene(true, true)]
            {
                let gap = gap(subject, GapExtent::Pose);
                assert_eq!(update.remaining_gap(gap.clone(), true), Some(gap), "{update:?}");
            }
        }
        assert_eq!(object(Remove).remaining_gap(gap(GapSubject::Object, GapExtent::Shapes), true), None);
        // an object that was never attached, and is detached, must be in the world
        let left = attached(Remove, false).remaining_gap(gap(GapSubject::Attached, GapExtent::Pose), true);
        assert_eq!(left, Some(gap(GapSubject::Object, GapExtent::Pose)));
    }

    #[test]
    fn what_a_link_should_have_released_is_a_gap_until_it_does() {
        let held = gap(GapSubject::Attached, GapExtent::Held);
        let detach = |id: &str, link: &str| {
            let object = ObjectChange::named(id, Operation::Remove);
            let change = AttachedChange { link: link.to_owned(), object, touch_links: vec![] };
            SceneUpdate::Attached(Box::new(change))
        };
        // an object that was detached before there was a robot is in the world
        assert_eq!(detach("a", "").announced_gaps(), [gap(GapSubject::Object, GapExtent::Pose)]);
        assert_eq!(detach("", "tip").announced_gaps(), []);
        for (id, link) in [("a", ""), ("a", "tip"), ("", "")] {
            assert_eq!(detach(id, link).remaining_gap(held.clone(), false), None, "{id} {link}");
            assert_eq!(detach(id, link).remaining_gap(held.clone(), true), Some(held.clone()), "{id} {link}");
        }
        // objects of one link, and another object
        for (id, link) in [("", "tip"), ("b", "")] {
            assert_eq!(
                detach(id, link).remaining_gap(held.clone(), false),
                Some(held.clone()),
                "{id} {link}"
            );
        }
        let of_link = SceneGap { name: "tip".to_owned(), ..held };
        for (id, link, is_closed) in
            [("", "", true), ("", "tip", true), ("", "arm", false), ("a", "tip", false), ("a", "", false)]
        {
            let left = detach(id, link).remaining_gap(of_link.clone(), false);
            assert_eq!(left.is_none(), is_closed, "{id} {link}");
            assert_eq!(detach(id, link).remaining_gap(of_link.clone(), true), Some(of_link.clone()));
        }
    }

    #[test]
    fn an_octomap_a_matrix_and_sizes_are_closed_by_others_of_their_kind_alone() {
        let octomap = SceneGap::new(GapSubject::Octomap, "", GapExtent::Shapes);
        assert_eq!(SceneUpdate::Octomap(None).remaining_gap(octomap.clone(), false), None);
        assert_eq!(SceneUpdate::Octomap(None).remaining_gap(octomap.clone(), true), Some(octomap.clone()));
        assert_eq!(scene(true, true).remaining_gap(octomap.clone(), false), Some(octomap.clone()));
        let world = SceneUpdate::World(Box::default());
        assert_eq!(world.remaining_gap(octomap, false), None);
        let padding = SceneGap::new(GapSubject::LinkPadding, "tip", GapExtent::Shapes);
        let with = |link: &str| {
            let link_padding = vec![(link.to_owned(), 0.1)];
            SceneUpdate::Scene(Box::new(SceneChange { is_diff: true, link_padding, ..Default::default() }))
        };
        assert_eq!(with("base").remaining_gap(padding.clone(), false), Some(padding.clone()));
        assert_eq!(with("tip").remaining_gap(padding.clone(), true), Some(padding.clone()));
        assert_eq!(with("tip").remaining_gap(padding.clone(), false), None);
        assert_eq!(world.remaining_gap(padding.clone(), false), Some(padding));
    }
}
