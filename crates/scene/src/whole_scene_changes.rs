//! Applies whole scenes and scene differences: world, fixed frames, robot state, collision matrix and link sizes.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

use clearance_geometry::math::Pose;
use clearance_robot::quoted;

use super::{
    AllowedCollisionMatrix, Applied, FixedFrame, GapExtent, GapSubject, MatrixEntries, Operation,
    RobotStateChange, Scene, SceneChange, SceneContext, SceneGap, SceneRejection, WorldChange,
};

/// Upper limit; larger values are treated as a mistake.
const LARGEST_SCALE: f64 = 1000.0;

impl Scene {
    /// Replaces all obstacles; obstacles from sensors stay, except for the octomap.
    pub(super) fn replace_world(
        &mut self,
        change: &WorldChange,
        keeps_octomap: bool,
        context: &SceneContext,
        applied: &mut Applied,
    ) {
        applied.changed = true;
        for name in self.given_names() {
            let _ = self.world.remove(&name);
            self.anchors.remove(&name);
            self.twists.remove(&name);
        }
        if !keeps_octomap {
            self.remove_octomap();
        }
        self.kinds.retain(|name, _| self.world.attached_by_name(name).is_some());
        self.change_world(change, context, applied);
    }

    fn change_world(&mut self, change: &WorldChange, context: &SceneContext, applied: &mut Applied) {
        for object in &change.objects {
            let held = self.world.attached_by_name(&object.id).is_some();
            if object.operation == Operation::Remove && held {
                // a message that attaches an object often also removes it from the world
                let id = &object.id;
                applied
                    .warnings
                    .push(format!("object '{id}' is attached, and no longer in the world to remove"));
                continue;
            }
            let result = self.change_object(object, context, &mut applied.warnings);
            applied.record(result);
        }
        if let Some(octomap) = &change.octomap {
            applied.record(self.set_octomap(Some(octomap), context));
        }
    }

    pub(super) fn change_scene(
        &mut self,
        change: &SceneChange,
        context: &SceneContext,
        applied: &mut Applied,
    ) {
        let model = &change.robot_model_name;
        if !model.is_empty() && model != context.robot.name() {
            let robot = context.robot.name();
            let of = quoted(model);
            applied.warnings.push(format!("robot_model_name: the scene is of {of}, the robot is '{robot}'"));
        }
        // as in MoveIt: the robot state comes first, and places the frames of links
        let stated = context.poses_with(&change.robot_state.positions);
        let context = &match &stated {
            None => context.clone(),
            Some(Ok(poses)) => context.with_poses(Some(poses)),
            Some(Err(error)) => {
                applied.warnings.push(format!(
                    "robot_state: {error}; objects in the frames of moving links are rejected"
                ));
                context.with_poses(None)
            }
        };
        if !change.is_diff {
            applied.changed = true;
            self.fixed_frames.clear();
            self.frame_anchors.clear();
            self.matrix = None;
            self.link_padding.clear();
            self.link_scale.clear();
        }
        self.set_fixed_frames(change, context, applied);
        self.change_robot_state(&change.robot_state, change.is_diff, context, applied);
        self.set_matrix(&change.matrix, change.is_diff, applied);
        self.set_link_sizes(change, context, applied);
        if change.is_diff {
            self.change_world(&change.world, context, applied);
        } else {
            self.replace_world(&change.world, change.keeps_octomap, context, applied);
        }
    }

    /// Adds fixed frames to the existing ones, as in `MoveIt`. A rejected frame is removed: it is safer to reject an object with its
    /// frame than to place it by the frame's earlier pose. A frame that is placed in itself at zero is removed, too: this is how a
    /// difference states that there is no such frame any more. `MoveIt` ignores such an entry.
    fn set_fixed_frames(&mut self, change: &SceneChange, context: &SceneContext, applied: &mut Applied) {
        for name in &change.unreadable_frames {
            self.remove_fixed_frame(name);
        }
        let frames: Vec<_> =
            change.fixed_frames.iter().map(|frame| frame.relative_to_parent(context)).collect();
        let bare = |name: &'_ str| name.trim_start_matches('/').to_owned();
        let mut first: HashMap<String, (String, Pose)> = HashMap::new();
        let mut contradicted = HashSet::new();
        for frame in &frames {
            let given = (bare(&frame.parent), frame.pose_pf);
            if *first.entry(bare(&frame.name)).or_insert_with(|| given.clone()) != given {
                contradicted.insert(bare(&frame.name));
            }
        }
        for frame in &frames {
            self.remove_fixed_frame(&frame.name);
            applied.record(if contradicted.contains(&bare(&frame.name)) {
                Err(frame.rejection("it is given twice, at two places"))
            } else {
                self.set_fixed_frame(frame, context)
            });
        }
    }

    fn remove_fixed_frame(&mut self, name: &str) {
        let name = name.trim_start_matches('/');
        self.fixed_frames.remove(name);
        self.frame_anchors.remove(name);
    }

    fn set_fixed_frame(&mut self, frame: &FixedFrame, context: &SceneContext) -> Result<(), SceneRejection> {
        let FixedFrame { name, parent, pose_pf } = frame;
        let name = name.trim_start_matches('/');
        let refuse = |why: String| frame.rejection(&why);
        // MoveIt lists the planning frame relative to itself; some of its tools leave out the name
        let is_itself =
            name == parent.trim_start_matches('/') || name.is_empty() && context.is_planning_frame(parent);
        if is_itself && *pose_pf == Pose::identity() {
            return Ok(());
        }
        if is_itself {
            return Err(refuse("it is placed in itself, but not at zero".to_owned()));
        }
        if name.is_empty() {
            return Err(refuse("its name is empty".to_owned()));
        }
        if context.is_planning_frame(name) {
            return Err(refuse(format!(
                "it is the planning frame: the robot's state or tf gives the root's pose in it, and frames are given as \
                 poses in it (child_frame_id '{}')",
                context.planning_frame()
            )));
        }
        if context.robot.link_by_name(name).is_some() {
            return Err(refuse("it is a link of the robot, whose joints say where it is".to_owned()));
        }
        if !context.stands_still(parent, self) {
            return Err(refuse(format!("its parent {} moves with the robot", quoted(parent))));
        }
        let pose_rp = context.frame_pose(parent, self);
        let pose_rp = pose_rp.map_err(|why| refuse(format!("header.frame_id: {why}")))?;
        self.fixed_frames.insert(name.to_owned(), pose_rp * pose_pf);
        self.anchor_fixed_frame(name, parent, context);
        Ok(())
    }

    /// Changes the attached objects.
    pub fn change_robot_state(
        &mut self,
        change: &RobotStateChange,
        is_diff: bool,
        context: &SceneContext,
        applied: &mut Applied,
    ) {
        // a difference without a robot state keeps the attached objects
        if !change.is_diff && (!is_diff || change.names_joints) {
            applied.changed |= !self.world.attached().is_empty();
            self.drop_all_attached();
        }
        for attached in &change.attached {
            if !change.is_diff && attached.object.operation != Operation::Add {
                let message = "object.operation: only ADD is possible unless robot_state.is_diff is set";
                applied.refusals.push(SceneRejection::of(&attached.object.id, message).of_attached());
                continue;
            }
            let result = self.change_attached(attached, context, &mut applied.warnings);
            applied.record(result);
        }
    }

    /// Removes all attached objects; they do not become obstacles.
    fn drop_all_attached(&mut self) {
        let names: Vec<String> = self.world.attached().iter().map(|object| object.name.clone()).collect();
        for name in names {
            let _ = self.world.drop_attached(&name);
        }
    }

    /// A matrix with entries replaces the earlier one completely; a difference without entries keeps it.
    pub(super) fn set_matrix(&mut self, entries: &MatrixEntries, is_diff: bool, applied: &mut Applied) {
        if *entries == MatrixEntries::default() {
            return;
        }
        let matrix = match AllowedCollisionMatrix::from_entries(entries) {
            Ok(matrix) => matrix,
            Err(error) => {
                let refusal = SceneRejection::new(error.to_string());
                // the SRDF's pairs are always intended; the pairs of an earlier message may be the ones that this message withdraws
                let gap =
                    self.matrix.as_ref().map(|_| SceneGap::new(GapSubject::Matrix, "", GapExtent::Shapes));
                applied.refusals.push(SceneRejection { gap, ..refusal });
                return;
            }
        };
        if is_diff && entries.entry_names.is_empty() {
            applied.ineffective.push(
                "allowed_collision_matrix: a difference with default entries alone changes nothing, as in MoveIt; \
                 give entry_names"
                    .to_owned(),
            );
            return;
        }
        if self.matrix.as_ref() != Some(&matrix) {
            applied.changed = true;
            applied.warnings.push(
                "allowed_collision_matrix: it takes the place of all entries before, the SRDF's too, as in MoveIt; \
                 pairs that it does not name are checked"
                    .to_owned(),
            );
        }
        self.matrix = Some(matrix);
    }

    fn set_link_sizes(&mut self, change: &SceneChange, context: &SceneContext, applied: &mut Applied) {
        let padding = LinkSizes {
            field: "link_padding",
            subject: GapSubject::LinkPadding,
            is_right: |padding| padding.is_finite() && padding >= 0.0,
            wanted: "metres, zero or more".to_owned(),
        };
        padding.apply(&change.link_padding, &mut self.link_padding, context, applied);
        let scale = LinkSizes {
            field: "link_scale",
            subject: GapSubject::LinkScale,
            is_right: |scale| (f64::MIN_POSITIVE..=LARGEST_SCALE).contains(&scale),
            wanted: format!("above zero and at most {LARGEST_SCALE}"),
        };
        scale.apply(&change.link_scale, &mut self.link_scale, context, applied);
    }
}

/// Paddings or scales of links.
struct LinkSizes {
    field: &'static str,
    subject: GapSubject,
    is_right: fn(f64) -> bool,
    wanted: String,
}

impl LinkSizes {
    fn apply(
        &self,
        given: &[(String, f64)],
        sizes: &mut HashMap<String, f64>,
        context: &SceneContext,
        applied: &mut Applied,
    ) {
        let mut first: HashMap<&str, f64> = HashMap::new();
        for (link, size) in given {
            applied.record(check_link(self.field, link, context).and_then(|()| {
                let earlier = *first.entry(link).or_insert(*size);
                self.check(link, *size, (earlier != *size && !size.is_nan()).then_some(earlier))?;
                sizes.insert(link.clone(), *size);
                Ok(())
            }));
        }
    }

    fn check(&self, link: &str, size: f64, earlier: Option<f64>) -> Result<(), SceneRejection> {
        let Self { field, wanted, .. } = self;
        let message = match earlier {
            Some(earlier) => format!("{field} of '{link}' is given twice, as {earlier:?} and as {size:?}"),
            None if (self.is_right)(size) => return Ok(()),
            None => format!("{field} of '{link}' is {size:?}, but must be {wanted}"),
        };
        Err(SceneRejection::new(message).leaving(SceneGap::new(self.subject, link, GapExtent::Shapes)))
    }
}

impl FixedFrame {
    fn rejection(&self, why: &str) -> SceneRejection {
        let name = quoted(self.name.trim_start_matches('/'));
        SceneRejection::new(format!("fixed_frame_transforms: frame {name}: {why}"))
    }

    /// Pose of the frame in its parent, for either direction in which it was given.
    fn relative_to_parent(&self, context: &SceneContext) -> Cow<'_, Self> {
        if !context.is_planning_frame(&self.name) {
            return Cow::Borrowed(self);
        }
        Cow::Owned(Self { name: self.parent.clone(), parent: self.name.clone(), pose_pf: self.pose_pf })
    }
}

fn check_link(field: &str, link: &str, context: &SceneContext) -> Result<(), SceneRejection> {
    match context.robot.link_by_name(link) {
        Some(_) => Ok(()),
        None => Err(SceneRejection::new(format!("{field}: the robot has no link {}", quoted(link)))),
    }
}
