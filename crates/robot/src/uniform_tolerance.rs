//! One tracking tolerance for every joint of a robot.

use super::{ConfigurationError, JointKind, RobotModel};

impl RobotModel {
    /// Tolerances (rad, m) of all positions that allow every movable joint a deviation of `value`, mimic joints included: a leader gets
    /// the tolerance that the slowest of its mimic joints needs.
    ///
    /// # Errors
    /// If `value` is negative or not finite, or some movable joint cannot have a tolerance.
    pub fn uniform_tolerances(&self, value: f64) -> Result<Vec<f64>, ConfigurationError> {
        if value == 0.0 {
            return Ok(vec![0.0; self.position_names().len()]);
        }
        for joint in self.joint_ids().map(|id| self.joint(id)) {
            let stands = joint.mimic.is_some_and(|mimic| mimic.multiplier == 0.0);
            let why = match joint.kind {
                JointKind::Floating => "is floating",
                JointKind::Fixed => continue,
                _ if stands => "mimics another with multiplier 0",
                _ => continue,
            };
            let (joint, others) = (joint.name.clone(), self.names_with_tolerance());
            return Err(ConfigurationError::NoToleranceForAll { joint, why, others });
        }
        let mimicking = self.mimicking_joints().map(|(joint, _)| joint);
        let mimicking = mimicking.filter(|joint| joint.kind != JointKind::Fixed).map(|joint| &joint.name);
        let names: Vec<&str> = self.position_names().iter().chain(mimicking).map(String::as_str).collect();
        let values = vec![value; names.len()];
        self.named_joints(names)?.tolerances(&values)
    }

    fn names_with_tolerance(&self) -> String {
        let joints = self.joint_ids().map(|id| self.joint(id));
        let able = joints.filter(|joint| joint.mimic.is_none() && joint.kind != JointKind::Floating);
        let names = able.flat_map(|joint| {
            joint.kind.position_suffixes().iter().map(|suffix| format!("{}{suffix}", joint.name))
        });
        let names: Vec<String> = names.collect();
        if names.is_empty() { "none".to_owned() } else { names.join(", ") }
    }
}

#[cfg(test)]
mod tests {
    use crate::{MeshFiles, RobotModel};

    fn robot(joints: &str) -> RobotModel {
        let links = ["base", "a", "b", "c", "d"]
            .into_iter()
            .filter(|name| joints.contains(&format!("link='{name}'")));
        let links = links.map(|name| format!("<link name='{name}'/>")).collect::<Vec<_>>().concat();
        RobotModel::from_urdf(&format!("<robot name='r'>{links}{joints}</robot>"), &MeshFiles::default())
            .unwrap()
    }

    fn joint(name: &str, kind: &str, child: &str, more: &str) -> String {
        format!(
            "<joint name='{name}' type='{kind}'><parent link='base'/><child link='{child}'/><axis xyz='0 0 1'/>\
             <limit lower='-9' upper='9' effort='1' velocity='1'/>{more}</joint>"
        )
    }

    fn mimic(of: &str, multiplier: f64) -> String {
        format!("<mimic joint='{of}' multiplier='{multiplier}'/>")
    }

    #[test]
    fn every_movable_joint_may_be_off_by_it_mimic_joints_too() {
        for (multiplier, expected) in [(1.0, 0.01), (0.5, 0.02), (-0.25, 0.04), (4.0, 0.01), (-1.0, 0.01)] {
            let robot = robot(
                &[
                    joint("lead", "revolute", "a", ""),
                    joint("slide", "prismatic", "b", &mimic("lead", multiplier)),
                    joint("still", "fixed", "c", ""),
                    joint("held", "prismatic", "d", &mimic("still", 0.5)),
                ]
                .concat(),
            );
            assert_eq!(robot.uniform_tolerances(0.01).unwrap(), [expected], "{multiplier}");
        }
        let robot = robot(
            &[
                joint("lead", "revolute", "a", ""),
                joint("half", "revolute", "b", &mimic("lead", 0.5)),
                joint("quarter", "revolute", "c", &mimic("half", 0.5)),
                joint("drive", "planar", "d", ""),
            ]
            .concat(),
        );
        let by_name = |name: &str, value: f64| {
            let at = robot.position_names().iter().position(|other| other == name).unwrap();
            assert_eq!(robot.uniform_tolerances(0.01).unwrap()[at], value, "{name}");
        };
        by_name("lead", 0.04);
        for name in ["drive/x", "drive/y", "drive/theta"] {
            by_name(name, 0.01);
        }
    }

    #[test]
    fn joints_that_can_have_no_tolerance_are_named_with_the_others() {
        let lead = joint("lead", "revolute", "a", "");
        for (other, words) in [
            (joint("fl", "floating", "b", ""), "'fl' is floating"),
            (
                joint("slide", "prismatic", "b", &mimic("lead", 0.0)),
                "'slide' mimics another with multiplier 0",
            ),
            (
                joint("slide", "prismatic", "b", &mimic("lead", -0.0)),
                "'slide' mimics another with multiplier 0",
            ),
        ] {
            let robot = robot(&[lead.clone(), other].concat());
            let why = robot.uniform_tolerances(0.01).unwrap_err().to_string();
            assert!(why.contains(words) && why.contains("lead"), "{why}");
            // followed exactly by all
            assert!(robot.uniform_tolerances(0.0).unwrap().iter().all(|tolerance| *tolerance == 0.0));
        }
        for bad in [-0.1, f64::NAN, f64::INFINITY] {
            assert!(robot(&lead).uniform_tolerances(bad).unwrap_err().to_string().contains("'lead'"));
        }
    }
}
