//! Point clouds of sensors as obstacles of the scene.

use std::collections::BTreeMap;
use std::sync::Arc;

use clearance_geometry::Shape;
use clearance_geometry::math::{Extremes, Point, Pose, Vector};
use clearance_monitor::cloud::{CloudFilter, SelfFilter};
use clearance_monitor::{Coverage, Now, Observation, Time};
use clearance_robot::RobotModel;
use clearance_scene::Obstacle;
use clearance_scene::SceneContext;
use clearance_scene::is_at_origin;
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::PointCloud2;

use crate::monitor_events::cloud_report::CloudReport;
use crate::parameters::parameter_set::Parameters;
use crate::scene::cloud_inbox::{CloudMessage, delay_of};
use crate::scene::loader_scene::LoaderScene;
use crate::scene::point_cloud_decoder::decode;
use crate::scene::scene_update_context::{PosesAtStamp, SceneUpdateContext};

impl LoaderScene {
    /// Replaces the previous clouds by the newest ones; returns whether anything changed.
    ///
    /// A cloud that shows nothing of the environment does not replace the previous cloud, unless the parameter
    /// `blind_cloud` accepts such clouds.
    pub fn apply_clouds(
        &mut self,
        messages: BTreeMap<String, CloudMessage>,
        robot: &Arc<RobotModel>,
        update_context: &SceneUpdateContext,
    ) -> bool {
        let parameters = &update_context.parameters;
        let mut changed = self.remove_unconfigured(parameters);
        for (topic, message) in messages {
            if !parameters.point_cloud_topics.contains(&topic) {
                continue;
            }
            let (since, stamp) = (message.since, message.stamp());
            let known = self.clouds.get(&topic).and_then(|cloud| cloud.seen);
            let seen = check_source(message.is_shared)
                .and_then(|()| check_stamp(stamp, message.received_at, parameters))
                .and_then(|()| check_order(stamp, known, message.received_at))
                .and_then(|()| self.filter_cloud(&topic, &message.cloud, robot, update_context))
                .and_then(|(obstacle, report)| {
                    let is_kept = report.blind.is_some() && parameters.blind_makes_unknown();
                    let set = if is_kept { Ok(()) } else { self.state.set_sensed(&topic, obstacle) };
                    set.map(|()| (report, is_kept))
                });
            let cloud = self.clouds.entry(topic.clone()).or_default();
            match seen {
                Ok((report, is_kept)) => {
                    cloud.report = report;
                    cloud.seen = Some(Observation { stamp, at: message.received_at.steady });
                    cloud.since = Some(since);
                    if let Some(cause) = cloud.report.blind.clone() {
                        cloud.log_fault(&topic, &cause);
                    }
                    if is_kept {
                        continue;
                    }
                    let context = SceneContext::new(
                        robot,
                        None,
                        &update_context.transforms,
                        update_context.now.ros,
                        parameters.transform_ttl,
                    );
                    self.state.anchor(&topic, &message.cloud.header.frame_id, &context);
                    self.dropped.retain(|name| *name != topic);
                    changed = true;
                }
                Err(fault) => {
                    cloud.log_fault(&topic, &fault);
                    cloud.report.fault = Some(fault);
                }
            }
        }
        self.is_changed |= changed;
        changed
    }

    /// Removes the clouds of topics that are no longer configured.
    fn remove_unconfigured(&mut self, parameters: &Parameters) -> bool {
        let watched = &parameters.point_cloud_topics;
        let gone: Vec<String> =
            self.clouds.keys().filter(|topic| !watched.contains(topic)).cloned().collect();
        for topic in &gone {
            self.clouds.remove(topic);
            self.state.remove_sensed(topic);
        }
        !gone.is_empty()
    }

    fn filter_cloud(
        &mut self,
        topic: &str,
        message: &PointCloud2,
        robot: &Arc<RobotModel>,
        update_context: &SceneUpdateContext,
    ) -> Result<(Option<Obstacle>, CloudReport), String> {
        let SceneUpdateContext { now, parameters, transforms, .. } = update_context;
        let points = decode(message)?;
        let PosesAtStamp { poses, coverage } = update_context
            .poses_at(robot, topic)
            .ok_or("without a fresh joint state the points on the robot are not known")?;
        let context = SceneContext::new(robot, Some(&poses), transforms, now.ros, parameters.transform_ttl);
        let frame = &message.header.frame_id;
        let pose_rc =
            context.frame_pose(frame, &self.state).map_err(|why| format!("header.frame_id: {why}"))?;
        match coverage {
            Coverage::Known => {}
            Coverage::Before if context.stands_still(frame, &self.state) => {}
            Coverage::Before => {
                let frame = frame.escape_debug();
                return Err(format!(
                    "header.stamp is older than the joint states that are kept (those of the last 3 s): where frame '{frame}', which \
                     moves with the robot, was then is not known"
                ));
            }
            Coverage::Gap => {
                return Err(
                    "header.stamp is in a time without evaluated joint states that is longer than 'stale_after': where the robot was then \
                     is not known"
                        .to_owned(),
                );
            }
        }
        let pose_rc = pose_rc * Pose::from(Vector::from(points.origin));
        let filter = match self.filter.take().filter(|filter| Arc::ptr_eq(filter.robot(), robot)) {
            Some(filter) => filter,
            None => SelfFilter::new(Arc::clone(robot)),
        };
        let filter = self.filter.insert(filter);
        filter.hold(&self.state.world);
        let cloud_filter = cloud_filter(parameters);
        let filtered = cloud_filter.apply(&points.points, points.rounding, &pose_rc, (filter, &poses))?;
        let placed: Vec<[f64; 3]> = points.positions().collect();
        let is_origin_cropped = |(p, in_frame): &(&[f32; 3], &[f64; 3])| {
            is_at_origin(in_frame) && cloud_filter.crops(**p, points.rounding, &pose_rc)
        };
        let at_origin = points.points.iter().zip(&placed).filter(is_origin_cropped).count();
        let others_cropped = filtered.cropped - at_origin;
        let report = CloudReport {
            points: filtered.cloud.as_ref().map_or(0, |cloud| cloud.points().len()),
            not_finite: points.dropped,
            cropped: filtered.cropped,
            of_robot: filtered.of_robot,
            blind: blindness(points.dropped, &placed, others_cropped),
            ..CloudReport::default()
        };
        let shape = filtered.cloud.map(Shape::Points);
        Ok((shape.map(|shape| Obstacle::of_shape(topic, Pose::identity(), shape)), report))
    }
}

/// Rejects a cloud of one of several sensors: it would replace that of another one.
fn check_source(is_shared: bool) -> Result<(), String> {
    if is_shared {
        return Err("several publishers send on this topic, and each cloud would replace that of the other: give each sensor a \
                    topic of its own"
            .to_owned());
    }
    Ok(())
}

/// Rejects a cloud with the stamp of another clock: its age is unknown.
fn check_stamp(stamp: Time, received_at: Now, parameters: &Parameters) -> Result<(), String> {
    let ahead = received_at.ros.map_or(0.0, |ros| stamp.seconds_since(ros));
    if ahead > parameters.point_cloud_ttl {
        return Err(format!(
            "header.stamp lies {ahead:.3} s in the future: synchronise the clocks, or set use_sim_time if its publisher does"
        ));
    }
    Ok(())
}

/// Rejects a cloud that is older than the last one, as of a second sensor or on a slow way: the newer one remains.
fn check_order(stamp: Time, known: Option<Observation>, received_at: Now) -> Result<(), String> {
    let Some(delay) = known.and_then(|known| delay_of(stamp, known.stamp, received_at)) else {
        return Ok(());
    };
    Err(format!(
        "header.stamp is {delay:.3} s older than that of the last cloud, which remains; two sensors need two topics"
    ))
}

fn cloud_filter(parameters: &Parameters) -> CloudFilter {
    let corner = |numbers: &[f64]| <[f64; 3]>::try_from(numbers).ok();
    CloudFilter {
        point_radius: parameters.point_radius,
        crop_min: corner(&parameters.cloud_crop_min),
        crop_max: corner(&parameters.cloud_crop_max),
        self_filter_padding: parameters.self_filter_padding,
        voxel_size: parameters.cloud_voxel_size,
    }
}

/// Reason why a cloud shows nothing of the environment; `None` if it is usable.
///
/// `cropped` is the number of points outside of the crop box, without points at the sensor's origin, which are ignored
/// anyway. Points on the robot prove that the sensor works: a cloud that contains only such points shows an empty
/// environment.
fn blindness(no_place: usize, points: &[[f64; 3]], cropped: usize) -> Option<String> {
    let seen: Vec<&[f64; 3]> = points.iter().filter(|point| !is_at_origin(point)).collect();
    let all = no_place + points.len();
    if all == 0 {
        return Some("it has no points".to_owned());
    }
    if seen.is_empty() {
        return Some(format!(
            "none of its {all} points is a place: they are NaN, infinite, too far away, or zero, where the sensor is"
        ));
    }
    let others = all - seen.len();
    let others = if others > 0 { format!(", and {others} more are no place") } else { String::new() };
    if cropped == seen.len() {
        let count = seen.len();
        return Some(format!(
            "all of its {count} points are outside of cloud_crop_min and cloud_crop_max{others}"
        ));
    }
    range_limit(&seen).map(|range| {
        let count = seen.len();
        format!(
            "all of its {count} points are {range:.3} m away, as if that were the range of the sensor{others}"
        )
    })
}

/// Common distance (m) of all points from the origin of the cloud's frame; `None` if there are too few points or the
/// distances differ. Only a sphere around the sensor has the same distance everywhere, but a sensor that detects
/// nothing may report its maximum range in all directions. Points that are very far away in almost one direction, as in the frame of
/// a map, are no such sphere.
fn range_limit(points: &[&[f64; 3]]) -> Option<f64> {
    /// Minimum number of points: two points of a wall may have the same distance.
    const SOME: usize = 3;
    /// Relative tolerance for the rounding to 32-bit numbers.
    const ROUNDING: f64 = 1e-5;
    /// Least angle (rad) that a sensor sees.
    const FIELD_OF_VIEW: f64 = 1e-3;
    let mut ranges = points.iter().map(|p| p.iter().map(|c| c.powi(2)).sum::<f64>().sqrt());
    let first = ranges.next().filter(|_| points.len() >= SOME)?;
    if !ranges.all(|range| (range - first).abs() <= ROUNDING * first) {
        return None;
    }
    let from_first = points.iter().map(|p| nalgebra::distance(&Point::from(**p), &Point::from(*points[0])));
    let spread = from_first.fold(0.0, f64::greater);
    (spread == 0.0 || spread >= FIELD_OF_VIEW * first).then_some(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cloud_without_a_usable_point_is_blind_for_the_cause_it_names() {
        let place = [[1.0, 2.0, 3.0]];
        assert_eq!(blindness(0, &place, 0), None);
        assert_eq!(blindness(9, &place, 0), None);
        let cause = |no_place, points, cropped| blindness(no_place, points, cropped).unwrap();
        assert!(cause(0, &[], 0).contains("no points"));
        assert!(cause(7, &[], 0).contains("none of its 7 points"));
        assert!(cause(7, &[[0.0, 1e-7, -0.0]], 0).contains("none of its 8 points"));
        let cropped = cause(2, &place, 1);
        assert!(cropped.contains("all of its 1 points") && cropped.contains("and 2 more"), "{cropped}");
        let with_zero = [place[0], [0.0; 3]];
        assert!(cause(0, &with_zero, 1).contains("all of its 1 points are outside"));
        assert_eq!(blindness(0, &with_zero, 0), None);
    }

    fn at_range(range: f32, count: u16) -> Vec<[f64; 3]> {
        let direction = |i| f32::from(i) * 0.1;
        (0..count).map(direction).map(|a| [a.cos(), a.sin(), 0.0].map(|c| f64::from(range * c))).collect()
    }

    #[test]
    fn points_that_all_lie_at_the_range_limit_are_a_blind_sensor() {
        for count in [3, 10, 31, 32, 1000] {
            let cause = blindness(0, &at_range(12.5, count), 0).unwrap();
            assert!(cause.contains("12.500 m away"), "{cause}");
        }
        // the same point repeated, such as zeros transformed to the frame of another link
        assert!(blindness(0, &[[0.3, -0.2, 1.1]; 3], 0).is_some());
        let mut with_zero = at_range(12.5, 100);
        with_zero.push([0.0; 3]);
        assert!(blindness(400, &with_zero, 0).unwrap().contains("100 points are 12.500 m away"));
    }

    #[test]
    fn whatever_is_seen_at_several_ranges_is_no_range_limit() {
        // a few points may have equal distances by chance
        assert_eq!(blindness(0, &at_range(12.5, 2), 0), None);
        let mut one_is_nearer = at_range(12.5, 100);
        one_is_nearer[50] = [1.0, 0.0, 0.0];
        assert_eq!(blindness(0, &one_is_nearer, 0), None);
        // points on a wall have many distances, even if all have the same depth
        let wall: Vec<[f64; 3]> = (0..100u16).map(|i| [2.0, f64::from(i) * 0.01, 0.0]).collect();
        assert_eq!(blindness(500, &wall, 0), None);
        // a floor in a map whose origin is far away
        let floor: Vec<[f64; 3]> = (0..100u16).map(|i| [5e5 + 0.1 * f64::from(i), 5.4e6, 0.0]).collect();
        assert_eq!(blindness(0, &floor, 0), None);
    }
}
