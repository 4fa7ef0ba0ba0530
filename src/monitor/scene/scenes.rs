//! Whole scenes and differences between them.

use super::{
    FixedFrame, Operation, PlanningSceneState, RobotStateChange, SceneChange, SceneContext, SceneRefusal,
    WorldChange,
};
use crate::checker::AllowedCollisionMatrix;
use crate::monitor::status::quoted;
use crate::world::MatrixEntries;

impl PlanningSceneState {
    /// Lets new obstacles take the place of all; what sensors see stays, but for the octomap.
    pub(super) fn replace_world(
        &mut self,
        change: &WorldChange,
        context: &SceneContext,
        warnings: &mut Vec<String>,
    ) -> Result<(), SceneRefusal> {
        for name in self.given_names() {
            let _ = self.world.remove(&name);
        }
        self.set_octomap(None, context)?;
        self.change_world(change, context, warnings)
    }

    fn change_world(
        &mut self,
        change: &WorldChange,
        context: &SceneContext,
        warnings: &mut Vec<String>,
    ) -> Result<(), SceneRefusal> {
        for object in &change.objects {
            let held = self.world.attached_by_name(&object.id).is_some();
            if object.operation == Operation::Remove && held {
                // who attaches an object often takes it from the world in the same message
                warnings.push(format!(
                    "object '{}' is attached, and no longer in the world to remove",
                    object.id
                ));
                continue;
            }
            self.change_object(object, context, warnings)?;
        }
        match &change.octomap {
            Some(octomap) => self.set_octomap(Some(octomap), context),
            None => Ok(()),
        }
    }

    pub(super) fn change_scene(
        &mut self,
        change: &SceneChange,
        context: &SceneContext,
        warnings: &mut Vec<String>,
    ) -> Result<(), SceneRefusal> {
        let model = &change.robot_model_name;
        if !model.is_empty() && model != context.robot.name() {
            let robot = context.robot.name();
            warnings
                .push(format!("robot_model_name: the scene is of {}, the robot is '{robot}'", quoted(model)));
        }
        if !change.is_diff {
            self.fixed_frames.clear();
            self.matrix = None;
            self.link_padding.clear();
            self.link_scale.clear();
        }
        self.set_fixed_frames(&change.fixed_frames, context)?;
        self.change_robot_state(&change.robot_state, change.is_diff, context, warnings)?;
        self.set_matrix(&change.matrix, change.is_diff, warnings)?;
        self.set_link_sizes(change, context)?;
        if change.is_diff {
            self.change_world(&change.world, context, warnings)
        } else {
            self.replace_world(&change.world, context, warnings)
        }
    }

    /// Takes note of frames that stand still; those given take the place of all, as in `MoveIt`.
    fn set_fixed_frames(
        &mut self,
        frames: &[FixedFrame],
        context: &SceneContext,
    ) -> Result<(), SceneRefusal> {
        if frames.is_empty() {
            return Ok(());
        }
        self.fixed_frames.clear();
        for FixedFrame { name, parent, pose_pf } in frames {
            let name = name.trim_start_matches('/');
            let refuse = |why: String| {
                SceneRefusal::new(format!("fixed_frame_transforms: frame {}: {why}", quoted(name)))
            };
            if name.is_empty() {
                return Err(refuse("child_frame_id is empty".to_owned()));
            }
            // where the robot's own links are, its joints say
            if context.robot.link_by_name(name).is_some() {
                continue;
            }
            if !context.stands_still(parent, self) {
                return Err(refuse(format!("its parent {} moves with the robot", quoted(parent))));
            }
            let pose_rp =
                context.frame_pose(parent, self).map_err(|why| refuse(format!("header.frame_id: {why}")))?;
            self.fixed_frames.insert(name.to_owned(), pose_rp * pose_pf);
        }
        Ok(())
    }

    fn change_robot_state(
        &mut self,
        change: &RobotStateChange,
        is_diff: bool,
        context: &SceneContext,
        warnings: &mut Vec<String>,
    ) -> Result<(), SceneRefusal> {
        // a difference that says nothing about the robot leaves alone what it holds
        if !change.is_diff && (!is_diff || change.names_joints) {
            self.drop_all_attached();
        }
        for attached in &change.attached {
            if !change.is_diff && attached.object.operation != Operation::Add {
                return Err(SceneRefusal::of(
                    &attached.object.id,
                    "object.operation: only ADD is possible unless robot_state.is_diff is set",
                ));
            }
            self.change_attached(attached, context, warnings)?;
        }
        Ok(())
    }

    /// Takes all attached objects away; they do not come back into the world.
    pub(super) fn drop_all_attached(&mut self) {
        let names: Vec<String> = self.world.attached().iter().map(|object| object.name.clone()).collect();
        for name in names {
            let _ = self.world.drop_attached(&name);
        }
    }

    /// A matrix with entries takes the place of the one before, whole; a difference without entries leaves it alone.
    fn set_matrix(
        &mut self,
        entries: &MatrixEntries,
        is_diff: bool,
        warnings: &mut Vec<String>,
    ) -> Result<(), SceneRefusal> {
        if *entries == MatrixEntries::default() {
            return Ok(());
        }
        let matrix = AllowedCollisionMatrix::from_entries(entries)
            .map_err(|error| SceneRefusal::new(error.to_string()))?;
        if is_diff && entries.entry_names.is_empty() {
            warnings.push(
                "allowed_collision_matrix: a difference with default entries alone changes nothing, as in MoveIt; \
                 give entry_names"
                    .to_owned(),
            );
            return Ok(());
        }
        warnings.push(
            "allowed_collision_matrix: it takes the place of all entries before, the SRDF's too, as in MoveIt; \
             pairs that it does not name are checked"
                .to_owned(),
        );
        self.matrix = Some(matrix);
        Ok(())
    }

    fn set_link_sizes(&mut self, change: &SceneChange, context: &SceneContext) -> Result<(), SceneRefusal> {
        for (link, padding) in &change.link_padding {
            check_link("link_padding", link, context)?;
            if !(padding.is_finite() && *padding >= 0.0) {
                let message =
                    format!("link_padding of '{link}' is {padding}, but must be metres, zero or more");
                return Err(SceneRefusal::new(message));
            }
            self.link_padding.insert(link.clone(), *padding);
        }
        for (link, scale) in &change.link_scale {
            check_link("link_scale", link, context)?;
            if !(scale.is_finite() && *scale > 0.0) {
                let message = format!("link_scale of '{link}' is {scale}, but must be a number above zero");
                return Err(SceneRefusal::new(message));
            }
            self.link_scale.insert(link.clone(), *scale);
        }
        Ok(())
    }
}

fn check_link(field: &str, link: &str, context: &SceneContext) -> Result<(), SceneRefusal> {
    match context.robot.link_by_name(link) {
        Some(_) => Ok(()),
        None => Err(SceneRefusal::new(format!("{field}: the robot has no link {}", quoted(link)))),
    }
}
