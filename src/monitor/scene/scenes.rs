//! Whole scenes and differences between them.

use super::state::{Applied, OCTOMAP};
use super::{
    Extent, FixedFrame, Gap, Operation, PlanningSceneState, RobotStateChange, SceneChange, SceneContext,
    SceneRefusal, Subject, WorldChange,
};
use crate::checker::AllowedCollisionMatrix;
use crate::monitor::status::quoted;
use crate::world::MatrixEntries;

/// More is a mistake.
const LARGEST_SCALE: f64 = 1000.0;

impl PlanningSceneState {
    /// Lets new obstacles take the place of all; what sensors see stays, but for the octomap.
    pub(super) fn replace_world(
        &mut self,
        (change, keeps_octomap): (&WorldChange, bool),
        context: &SceneContext,
        applied: &mut Applied,
    ) {
        applied.changed = true;
        for name in self.given_names() {
            let _ = self.world.remove(&name);
            self.anchors.remove(&name);
        }
        if !keeps_octomap {
            let _ = self.world.remove(OCTOMAP);
            self.anchors.remove(OCTOMAP);
        }
        self.kinds.retain(|name, _| self.world.attached_by_name(name).is_some());
        self.change_world(change, context, applied);
    }

    fn change_world(&mut self, change: &WorldChange, context: &SceneContext, applied: &mut Applied) {
        for object in &change.objects {
            let held = self.world.attached_by_name(&object.id).is_some();
            if object.operation == Operation::Remove && held {
                // who attaches an object often takes it from the world in the same message
                let id = &object.id;
                applied
                    .warnings
                    .push(format!("object '{id}' is attached, and no longer in the world to remove"));
                continue;
            }
            let result = self.change_object(object, context, &mut applied.warnings);
            applied.note(result);
        }
        if let Some(octomap) = &change.octomap {
            applied.note(self.set_octomap(Some(octomap), context));
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
        if !change.is_diff {
            applied.changed = true;
            self.fixed_frames.clear();
            self.frame_anchors.clear();
            self.matrix = None;
            self.link_padding.clear();
            self.link_scale.clear();
        }
        if change.names_frames || !change.fixed_frames.is_empty() {
            self.set_fixed_frames(&change.fixed_frames, context, applied);
        }
        self.change_robot_state(&change.robot_state, change.is_diff, context, applied);
        self.set_matrix(&change.matrix, change.is_diff, applied);
        self.set_link_sizes(change, context, applied);
        if change.is_diff {
            self.change_world(&change.world, context, applied);
        } else {
            self.replace_world((&change.world, change.keeps_octomap), context, applied);
        }
    }

    /// Takes note of frames that stand still; those given take the place of all, as in `MoveIt`, also where some are rejected: an
    /// object is better rejected with its frame than placed where the frame was before.
    fn set_fixed_frames(&mut self, frames: &[FixedFrame], context: &SceneContext, applied: &mut Applied) {
        self.fixed_frames.clear();
        self.frame_anchors.clear();
        for frame in frames {
            applied.note(self.set_fixed_frame(frame, context));
        }
    }

    fn set_fixed_frame(&mut self, frame: &FixedFrame, context: &SceneContext) -> Result<(), SceneRefusal> {
        let FixedFrame { name, parent, pose_pf } = frame;
        let name = name.trim_start_matches('/');
        let refuse =
            |why: String| SceneRefusal::new(format!("fixed_frame_transforms: frame {}: {why}", quoted(name)));
        if name.is_empty() {
            return Err(refuse("child_frame_id is empty".to_owned()));
        }
        // where the robot's own links are, its joints say
        if context.robot.link_by_name(name).is_some() {
            return Ok(());
        }
        if !context.stands_still(parent, self) {
            return Err(refuse(format!("its parent {} moves with the robot", quoted(parent))));
        }
        let pose_rp = context.frame_pose(parent, self);
        let pose_rp = pose_rp.map_err(|why| refuse(format!("header.frame_id: {why}")))?;
        self.fixed_frames.insert(name.to_owned(), pose_rp * pose_pf);
        self.anchor_frame(name, parent, context);
        Ok(())
    }

    /// Changes what the robot holds.
    pub fn change_robot_state(
        &mut self,
        change: &RobotStateChange,
        is_diff: bool,
        context: &SceneContext,
        applied: &mut Applied,
    ) {
        // a difference that says nothing about the robot leaves alone what it holds
        if !change.is_diff && (!is_diff || change.names_joints) {
            applied.changed |= !self.world.attached().is_empty();
            self.drop_all_attached();
        }
        for attached in &change.attached {
            if !change.is_diff && attached.object.operation != Operation::Add {
                let message = "object.operation: only ADD is possible unless robot_state.is_diff is set";
                applied.refusals.push(SceneRefusal::of(&attached.object.id, message).of_attached());
                continue;
            }
            let result = self.change_attached(attached, context, &mut applied.warnings);
            applied.note(result);
        }
    }

    /// Takes all attached objects away; they do not come back into the world.
    fn drop_all_attached(&mut self) {
        let names: Vec<String> = self.world.attached().iter().map(|object| object.name.clone()).collect();
        for name in names {
            let _ = self.world.drop_attached(&name);
        }
    }

    /// A matrix with entries takes the place of the one before, whole; a difference without entries leaves it alone.
    fn set_matrix(&mut self, entries: &MatrixEntries, is_diff: bool, applied: &mut Applied) {
        if *entries == MatrixEntries::default() {
            return;
        }
        let matrix = match AllowedCollisionMatrix::from_entries(entries) {
            Ok(matrix) => matrix,
            Err(error) => {
                let refusal = SceneRefusal::new(error.to_string());
                // the SRDF's pairs are those that were always meant; another message's may be just what this one takes back
                let gap = self.matrix.as_ref().map(|_| Gap::new(Subject::Matrix, "", Extent::Shapes));
                applied.refusals.push(SceneRefusal { gap, ..refusal });
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
        for (link, padding) in &change.link_padding {
            applied.note(check_link("link_padding", link, context).and_then(|()| {
                if padding.is_finite() && *padding >= 0.0 {
                    self.link_padding.insert(link.clone(), *padding);
                    return Ok(());
                }
                let message =
                    format!("link_padding of '{link}' is {padding}, but must be metres, zero or more");
                Err(SceneRefusal::new(message).leaving(Gap::new(Subject::LinkPadding, link, Extent::Shapes)))
            }));
        }
        for (link, scale) in &change.link_scale {
            applied.note(check_link("link_scale", link, context).and_then(|()| {
                if (f64::MIN_POSITIVE..=LARGEST_SCALE).contains(scale) {
                    self.link_scale.insert(link.clone(), *scale);
                    return Ok(());
                }
                let message = format!(
                    "link_scale of '{link}' is {scale}, but must be above zero and at most {LARGEST_SCALE}"
                );
                Err(SceneRefusal::new(message).leaving(Gap::new(Subject::LinkScale, link, Extent::Shapes)))
            }));
        }
    }
}

fn check_link(field: &str, link: &str, context: &SceneContext) -> Result<(), SceneRefusal> {
    match context.robot.link_by_name(link) {
        Some(_) => Ok(()),
        None => Err(SceneRefusal::new(format!("{field}: the robot has no link {}", quoted(link)))),
    }
}
