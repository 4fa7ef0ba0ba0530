//! Resolves mimic joints to the free joint that each follows in the end.

use clearance_geometry::constants::LARGEST_COORDINATE;

use super::joint::{JointKind, Mimic};
use super::{Joint, JointId};

/// A remark on the mimic of a joint, or an error; other joints are named in the message.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct MimicNote {
    pub joint: JointId,
    pub message: String,
}

/// Replaces each joint's mimic, which may follow a joint that itself follows another, by one that follows a free joint:
/// `m1 (m2 q + o2) + o1 = (m1 m2) q + (m1 o2 + o1)`. One that follows a fixed joint, whose position is 0, becomes fixed at its offset.
///
/// # Errors
/// Cycles, leaders with several positions, and numbers that overflow. Remarks are about joints that became fixed.
pub(super) fn resolve(joints: &mut [Joint]) -> Result<Vec<MimicNote>, MimicNote> {
    let mut remarks = Vec::new();
    // 0: not visited, 1: on the current chain, 2: resolved
    let mut state = vec![0u8; joints.len()];
    for start in 0..joints.len() {
        let mut chain = Vec::new();
        let mut at = start;
        while let (0, Some(mimic)) = (state[at], joints[at].mimic) {
            state[at] = 1;
            chain.push(at);
            at = mimic.joint.index();
        }
        if state[at] == 1 {
            return Err(cycle(joints, &chain, at));
        }
        // leaders first
        for &follower in chain.iter().rev() {
            remarks.extend(follow(joints, follower)?);
            state[follower] = 2;
        }
        state[at] = 2;
    }
    Ok(remarks)
}

fn follow(joints: &mut [Joint], follower: usize) -> Result<Option<MimicNote>, MimicNote> {
    let Some(own) = joints[follower].mimic else {
        return Ok(None);
    };
    let leader = &joints[own.joint.index()];
    let leader_is_fixed = leader.kind == JointKind::Fixed;
    let note = |message: String| MimicNote { joint: joint_id(follower), message };
    if matches!(leader.kind, JointKind::Floating | JointKind::Planar(_)) {
        return Err(note(format!("mimics joint '{}', which has no single position", leader.name)));
    }
    let leader_name = leader.name.clone();
    if let Some(theirs) = leader.mimic {
        let composed = Mimic {
            joint: theirs.joint,
            multiplier: own.multiplier * theirs.multiplier,
            offset: own.multiplier * theirs.offset + own.offset,
        };
        if !composed.multiplier.is_finite() || !composed.offset.is_finite() {
            return Err(note("the multipliers of its mimic chain overflow".to_owned()));
        }
        joints[follower].mimic = Some(composed);
    }
    if !leader_is_fixed {
        return Ok(None);
    }
    let position = hold(&mut joints[follower]);
    if position.abs() > LARGEST_COORDINATE {
        return Err(note(format!("mimic offset {position:e} is larger than {LARGEST_COORDINATE:e}")));
    }
    let limits = joints[follower].limits.filter(|l| !(l.lower..=l.upper).contains(&position));
    let limits = limits
        .map_or_else(String::new, |l| format!(", which is outside its limits [{}, {}]", l.lower, l.upper));
    Ok(Some(note(format!(
        "mimics joint '{leader_name}', which is fixed: it is taken as fixed, too, at its offset {position}{limits}"
    ))))
}

/// Fixes a joint at the offset of its mimic. The mimic is kept, since a state may name the joint.
fn hold(joint: &mut Joint) -> f64 {
    let position = joint.mimic.map_or(0.0, |mimic| mimic.offset);
    joint.pose_pj *= joint.kind.motion(&[position]);
    joint.kind = JointKind::Fixed;
    position
}

fn cycle(joints: &[Joint], chain: &[usize], at: usize) -> MimicNote {
    let looped = chain.iter().skip_while(|&&j| j != at).chain([&at]);
    let names: Vec<String> = looped.map(|&j| format!("'{}'", joints[j].name)).collect();
    MimicNote { joint: joint_id(at), message: format!("mimics itself: {}", names.join(" mimics ")) }
}

fn joint_id(index: usize) -> JointId {
    JointId(u32::try_from(index).unwrap_or(u32::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LinkId;
    use clearance_geometry::math::{Pose, Vector};

    fn joint(name: &str, mimic: Option<(u32, f64, f64)>) -> Joint {
        Joint {
            name: name.to_owned(),
            kind: JointKind::Revolute(Vector::x_axis()),
            parent: LinkId(0),
            child: LinkId(1),
            pose_pj: Pose::identity(),
            limits: None,
            mimic: mimic.map(|(leader, multiplier, offset)| Mimic {
                joint: JointId(leader),
                multiplier,
                offset,
            }),
            passive: false,
        }
    }

    #[test]
    fn chains_in_any_order_compose() {
        let mut joints =
            [joint("a", Some((2, 2.0, 1.0))), joint("leader", None), joint("b", Some((1, -3.0, 0.5)))];
        resolve(&mut joints).unwrap();
        let a = joints[0].mimic.unwrap();
        assert_eq!((a.joint, a.multiplier, a.offset), (JointId(1), -6.0, 2.0));
    }

    #[test]
    fn cycles_are_named() {
        let mut joints = [
            joint("tail", Some((1, 1.0, 0.0))),
            joint("a", Some((2, 1.0, 0.0))),
            joint("b", Some((1, 1.0, 0.0))),
        ];
        let error = resolve(&mut joints).unwrap_err();
        assert_eq!(error.message, "mimics itself: 'a' mimics 'b' mimics 'a'");
    }

    #[test]
    fn a_leader_needs_one_position() {
        let mut joints = [joint("a", Some((1, 1.0, 0.0))), joint("b", None)];
        joints[1].kind = JointKind::Floating;
        assert!(resolve(&mut joints).unwrap_err().message.contains("'b'"));
    }

    #[test]
    fn followers_of_a_fixed_joint_are_fixed_at_their_offset() {
        let mut joints = [
            joint("second", Some((1, 2.0, 0.25))),
            joint("first", Some((2, -7.0, 0.5))),
            joint("leader", None),
        ];
        joints[2].kind = JointKind::Fixed;
        let remarks = resolve(&mut joints).unwrap();
        assert_eq!(remarks.iter().map(|r| r.joint).collect::<Vec<_>>(), [JointId(1), JointId(0)]);
        assert!(
            remarks[0].message.contains("'leader', which is fixed") && remarks[0].message.ends_with("0.5")
        );
        for (joint, angle) in joints.iter().zip([1.25, 0.5]) {
            assert_eq!(joint.kind, JointKind::Fixed);
            assert!((joint.pose_pj.rotation.angle() - angle).abs() < 1e-12);
        }
    }

    #[test]
    fn an_offset_at_a_fixed_joint_is_bounded() {
        let mut joints = [joint("a", Some((1, 1.0, 1e300))), joint("b", None)];
        joints[1].kind = JointKind::Fixed;
        assert!(resolve(&mut joints).unwrap_err().message.contains("1e300"));
    }

    #[test]
    fn long_chains_need_no_stack() {
        let count = 100_000;
        let mut joints: Vec<Joint> =
            (0..count).map(|i| joint("j", (i + 1 < count).then_some((i + 1, 1.0, 1.0)))).collect();
        resolve(&mut joints).unwrap();
        assert_eq!(joints[0].mimic.unwrap().joint, JointId(count - 1));
        assert!((joints[0].mimic.unwrap().offset - f64::from(count - 1)).abs() < 1e-6);
    }
}
