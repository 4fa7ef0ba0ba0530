//! Frames that others publish: the latest transform of each, as `tf` and `tf_static` tell it.

use std::collections::HashMap;

use crate::math::Pose;
use crate::monitor::Time;

/// Frames known at most, so that a hostile network can not fill the memory.
const MOST_FRAMES: usize = 10_000;

/// A frame in its parent.
#[derive(Clone, Debug, PartialEq)]
pub struct Transform {
    pub parent: String,
    /// Pose of the frame in its parent.
    pub pose_pf: Pose,
    /// When it was so; `None` if it always is.
    pub stamp: Option<Time>,
}

/// The latest transform of every frame.
#[derive(Clone, Debug, Default)]
pub struct TransformTree {
    by_frame: HashMap<String, Known>,
}

/// What was told last of a frame.
#[derive(Clone, Debug)]
struct Known {
    transform: Transform,
    /// Whether it was ever told anew, with another stamp; what was told once need not be told again.
    is_alive: bool,
}

/// One frame in another.
#[derive(Clone, Debug, PartialEq)]
pub struct Between {
    pub pose: Pose,
    /// Stamp of the oldest transform on the way, if one of them changes.
    pub oldest: Option<Time>,
    /// The same of those that are told again and again.
    pub oldest_alive: Option<Time>,
}

/// A frame that is told again and again.
#[derive(Clone, Debug, PartialEq)]
pub struct Link<'t> {
    pub name: &'t str,
    /// Its pose in its parent.
    pub pose_pf: Pose,
    pub stamp: Time,
}

/// A frame above another one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ancestor<'t> {
    pub name: &'t str,
    /// Pose, in this frame, of the frame that was asked about.
    pub pose_af: Pose,
    /// The oldest transform on the way, if one of them changes: its frame and stamp.
    pub oldest: Option<(&'t str, Time)>,
    /// The stamp of the oldest on the way that is told again and again.
    oldest_alive: Option<Time>,
}

/// A clock that was set back by more than this (s) starts anew.
const SET_BACK: f64 = 1.0;

impl TransformTree {
    /// Takes note of a transform; one that is older than the known one is passed over. `false` when there are too many frames.
    #[expect(clippy::needless_pass_by_value, reason = "it is kept")]
    pub fn note(&mut self, frame: &str, transform: Transform) -> bool {
        let frame = frame.trim_start_matches('/');
        let known = self.by_frame.get(frame);
        if known.is_none() && self.by_frame.len() >= MOST_FRAMES {
            return false;
        }
        let stamps = known.and_then(|known| known.transform.stamp).zip(transform.stamp);
        let is_older = stamps
            .is_some_and(|(known, new)| (0.0..SET_BACK).contains(&known.seconds_since(new)) && known != new);
        if !is_older {
            let is_anew = stamps.is_some_and(|(known, new)| known != new);
            let is_alive = is_anew || known.is_some_and(|known| known.is_alive);
            let parent = transform.parent.trim_start_matches('/').to_owned();
            let known = Known { transform: Transform { parent, ..transform }, is_alive };
            self.by_frame.insert(frame.to_owned(), known);
        }
        true
    }

    /// The frame `frame` in the frame `reference`; `None` if nothing connects them.
    #[must_use]
    pub fn between(&self, reference: &str, frame: &str) -> Option<Between> {
        let ways = self.ways_to_meet(reference, frame)?;
        let [of_reference, of_frame] = ways.each_ref().map(|way| &way[way.len() - 1]);
        let ends = [of_reference, of_frame];
        Some(Between {
            pose: of_reference.pose_af.inverse() * of_frame.pose_af,
            oldest: ends.iter().filter_map(|end| end.oldest).map(|(_, stamp)| stamp).min(),
            oldest_alive: ends.iter().filter_map(|end| end.oldest_alive).min(),
        })
    }

    /// The frames between two that are told again and again.
    #[must_use]
    pub fn live_links(&self, reference: &str, frame: &str) -> Vec<Link<'_>> {
        let ways = self.ways_to_meet(reference, frame).unwrap_or_default();
        let below = ways.iter().flat_map(|way| way.iter().rev().skip(1));
        let known = below.filter_map(|ancestor| self.by_frame.get_key_value(ancestor.name));
        let live = known.filter(|(_, known)| known.is_alive).filter_map(|(name, known)| {
            let Transform { pose_pf, stamp, .. } = &known.transform;
            Some(Link { name, pose_pf: *pose_pf, stamp: (*stamp)? })
        });
        live.collect()
    }

    /// Pose of `frame` in the frame `reference`, if a frame on the way were elsewhere in its parent.
    #[must_use]
    pub fn pose_if(&self, reference: &str, frame: &str, (link, pose_pf): (&str, &Pose)) -> Option<Pose> {
        let [of_reference, of_frame] = self.ways_to_meet(reference, frame)?.map(|way| {
            let links = &way[..way.len() - 1];
            links.iter().fold(Pose::identity(), |pose, ancestor| match self.by_frame.get(ancestor.name) {
                _ if ancestor.name == link => pose_pf * pose,
                Some(known) => known.transform.pose_pf * pose,
                None => pose,
            })
        });
        Some(of_reference.inverse() * of_frame)
    }

    /// The ways from both frames up to the first that is above both.
    fn ways_to_meet<'t>(&'t self, reference: &'t str, frame: &'t str) -> Option<[Vec<Ancestor<'t>>; 2]> {
        let [mut of_reference, mut of_frame] = [reference, frame].map(|frame| self.ancestors(frame));
        let (above, below) = of_frame
            .iter()
            .enumerate()
            .find_map(|(i, a)| Some((i, of_reference.iter().position(|r| r.name == a.name)?)))?;
        of_reference.truncate(below + 1);
        of_frame.truncate(above + 1);
        Some([of_reference, of_frame])
    }

    /// The highest frame above another one, if there is one above it.
    #[must_use]
    pub fn topmost_above<'t>(&'t self, frame: &'t str) -> Option<&'t str> {
        let mut above = frame;
        // loops end where they would come around
        for _ in 0..self.by_frame.len() {
            let known = self.by_frame.get(above).filter(|known| known.transform.parent != frame);
            let Some(Known { transform, .. }) = known else { break };
            above = &transform.parent;
        }
        (above != frame).then_some(above)
    }

    /// The frame itself and those above it, nearest first; ends before it would come around.
    pub(super) fn ancestors<'t>(&'t self, frame: &'t str) -> Vec<Ancestor<'t>> {
        let mut above =
            vec![Ancestor { name: frame, pose_af: Pose::identity(), oldest: None, oldest_alive: None }];
        while let Some(last) = above.last()
            && let Some(Known { transform, is_alive }) = self.by_frame.get(last.name)
            && above.iter().all(|a| a.name != transform.parent)
        {
            let stamped = transform.stamp.map(|stamp| (last.name, stamp));
            let oldest = match (last.oldest, stamped) {
                (Some(a), Some(b)) => Some(if b.1 < a.1 { b } else { a }),
                (a, b) => a.or(b),
            };
            let alive = transform.stamp.filter(|_| *is_alive);
            let oldest_alive = [last.oldest_alive, alive].into_iter().flatten().min();
            let pose_af = transform.pose_pf * last.pose_af;
            above.push(Ancestor { name: &transform.parent, pose_af, oldest, oldest_alive });
        }
        above
    }
}
