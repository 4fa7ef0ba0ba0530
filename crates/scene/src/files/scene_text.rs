//! Reader of MoveIt's `.scene` text, which RViz ("Save Scene") and `SceneLoader::saveGeometryToStream` write.
//!
//! A line with the scene's name; for every object `* id` and its shapes; a full stop at the end. In the newer format each object has a
//! pose before its shapes and subframes after them. As in `MoveIt`, the line after the first object's id decides: a single number, the
//! number of shapes, marks the older format.

use clearance_geometry::Shape;
use clearance_geometry::math::Pose;
use clearance_robot::RobotModel;

use super::scene_error::SceneError;
use super::scene_loader::SceneLoader;
use crate::message_shapes::{mesh, message_pose, plane, solid};
use crate::{Obstacle, ObstacleShape};

/// Deviation of a quaternion's length from 1 above which a warning is issued.
const QUATERNION_SLACK: f64 = 1e-3;

/// Tokenizer: the words of the text, and the line of the last one.
struct Words<'t> {
    text: &'t str,
    /// Position where the search for the next word starts.
    at: usize,
}

impl SceneLoader {
    /// True if a text is in this format, recognised by the mark of its first object or its end.
    #[must_use]
    pub fn is_scene_text(text: &str) -> bool {
        let first = text.lines().skip(1).find(|line| !line.trim().is_empty());
        first.is_some_and(|line| line.starts_with("* ") || line.trim_end() == ".")
    }

    /// Adds the objects of a `.scene` text; their poses are in MoveIt's planning frame.
    pub fn read_scene_text(&mut self, text: &str, file: &str, robot: &RobotModel) -> Result<(), SceneError> {
        let placed = self.robot_state.placed(robot);
        let context = placed.context(robot);
        let planning_frame = context.planning_frame();
        let remark = context.frame_remark(planning_frame, &self.scene);
        self.warnings.extend(remark.map(|remark| format!("{file}: {remark}")));
        let mut reader = self.file(file, &context);
        let newer = is_newer_dialect(text);
        let mut words = Words { text, at: 0 };
        words.rest_of_line();
        loop {
            let fault =
                |words: &Words, e: &str| SceneError::of_file(file, format!("line {}: {e}", words.line()));
            match words.next() {
                Some("*") => {}
                Some(".") => break,
                Some(_) => return Err(fault(&words, "expected '*' before an object, or '.' at the end")),
                None => return Err(fault(&words, "the file ends without '.': it is cut")),
            }
            let id = words.rest_of_line().trim().to_owned();
            let named = |words: &Words, e: String| {
                SceneError::of_object(file, &id, format!("line {}: {e}", words.line()))
            };
            let mut remarks = Vec::new();
            let object = words.object(&id, newer, &mut remarks).map_err(|e| named(&words, e))?;
            reader.warn_about(&id, remarks);
            if object.shapes.is_empty() && !id.is_empty() {
                reader.warn_about(&id, ["no shapes: it is left out".to_owned()]);
                continue;
            }
            reader.add_obstacle(object, planning_frame).map_err(|error| named(&words, error.message))?;
        }
        if let Some(word) = words.next() {
            let message =
                format!("'{}' after the '.' that ends the scene: a file holds one scene", short(word));
            return Err(SceneError::of_file(file, format!("line {}: {message}", words.line())));
        }
        if self.scene.world.is_empty() {
            self.warnings.push(format!("{file}: the scene has no objects"));
        }
        Ok(())
    }
}

/// True if the line after the first object's id holds more than one word.
fn is_newer_dialect(text: &str) -> bool {
    let mut lines = text.lines().skip(1).skip_while(|line| !line.starts_with('*'));
    lines.nth(1).is_some_and(|line| line.trim().contains(' '))
}

/// The start of a word.
fn short(word: &str) -> String {
    word.chars().take(40).collect()
}

impl<'t> Words<'t> {
    fn next(&mut self) -> Option<&'t str> {
        let rest = self.text[self.at..].trim_start();
        self.at = self.text.len() - rest.len();
        let word = rest.split_whitespace().next()?;
        self.at += word.len();
        Some(word)
    }

    fn rest_of_line(&mut self) -> &'t str {
        let line = self.text[self.at..].split_inclusive('\n').next().unwrap_or_default();
        self.at += line.len();
        line
    }

    /// Line of the last word, from 1.
    fn line(&self) -> usize {
        1 + self.text[..self.at].trim_end().matches('\n').count()
    }

    fn number<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, String> {
        let word = self.next().ok_or_else(|| format!("the file ends before {what}"))?;
        word.parse().map_err(|_| format!("{what}: '{}' is no number", short(word)))
    }

    fn numbers<T: std::str::FromStr + Copy + Default, const N: usize>(
        &mut self,
        what: &str,
    ) -> Result<[T; N], String> {
        let mut all = [T::default(); N];
        for number in &mut all {
            *number = self.number(what)?;
        }
        Ok(all)
    }

    fn pose(&mut self, what: &str, remarks: &mut Vec<String>) -> Result<Pose, String> {
        let position = self.numbers(what)?;
        let orientation: [f64; 4] = self.numbers(what)?;
        let length = orientation.iter().map(|c| c * c).sum::<f64>().sqrt();
        if length != 0.0 && (length - 1.0).abs() > QUATERNION_SLACK {
            remarks.push(format!("{what}: the quaternion has length {length:.4}; it is normalised"));
        }
        message_pose(position, orientation).map_err(|e| format!("{what}: {e}"))
    }

    fn object(&mut self, id: &str, newer: bool, remarks: &mut Vec<String>) -> Result<Obstacle, String> {
        let pose_ro = if newer { self.pose("the object's pose", remarks)? } else { Pose::identity() };
        let count: u32 = self.number("the number of shapes")?;
        let mut shapes = Vec::new();
        for i in 0..count {
            let shape = self.shape().map_err(|e| format!("shape {i}: {e}"))?;
            let pose_os = self.pose(&format!("the pose of shape {i}"), remarks)?;
            let _colour: [f64; 4] = self.numbers(&format!("the colour of shape {i}"))?;
            shapes.push(ObstacleShape { pose_os, shape });
        }
        let mut subframes = Vec::new();
        let count: u32 = if newer { self.number("the number of subframes")? } else { 0 };
        for i in 0..count {
            let name = self.next().ok_or_else(|| format!("the file ends before subframe {i}"))?;
            subframes.push((name.to_owned(), self.pose(&format!("the pose of subframe '{name}'"), remarks)?));
        }
        Ok(Obstacle { pose_ro, subframes, ..Obstacle::new(id, shapes) })
    }

    fn shape(&mut self) -> Result<Shape, String> {
        let kind = self.next().ok_or("the file ends before it")?;
        match kind {
            "box" => solid(1, &self.numbers::<f64, 3>("size")?),
            "sphere" => solid(2, &[self.number("radius")?]),
            // in this format the radius comes before the length, in messages after it
            "cylinder" | "cone" => {
                let [radius, length] = self.numbers("radius and length")?;
                solid(if kind == "cone" { 4 } else { 3 }, &[length, radius])
            }
            "plane" => plane(self.numbers("coefficients")?),
            "mesh" => {
                let [vertices, triangles]: [u32; 2] = self.numbers("numbers of vertices and triangles")?;
                // the file may declare more shapes than it contains
                let vertices: Result<Vec<[f64; 3]>, _> =
                    (0..vertices).map(|_| self.numbers("vertex")).collect();
                let vertices = vertices?;
                let triangles: Result<_, _> = (0..triangles).map(|_| self.numbers("triangle")).collect();
                mesh(vertices, triangles?)
            }
            other => Err(format!(
                "'{}' is no shape: box, sphere, cylinder, cone, plane and mesh are",
                short(other)
            )),
        }
    }
}

#[cfg(test)]
mod tests;
