//! Test oracle: distance of two bodies, which descends both RSS trees of the reference engine.

use clearance::geometry::constants::CONTACT_DISTANCE;
use clearance::geometry::math::Pose;
use clearance::proximity::{Separation, element_separation};

use super::body::ReferenceBody;
use super::bounding_volume::BoundingVolume;
use super::tree::{Content, ROOT};

/// Least distance of two bodies and their nearest points, or `None` if it was proven larger than `limit` (m).
///
/// Descends both RSS trees at once, the nearer children first (Larsen, Gottschalk, Lin & Manocha 1999).
pub fn distance(a: &ReferenceBody, b: &ReferenceBody, pose_ab: &Pose, limit: f64) -> Option<Separation> {
    // what touches is within any limit
    let bound = limit.max(CONTACT_DISTANCE);
    let mut search = Search { a, b, pose_ab, bound, nearest: None };
    let lower = search.lower_bound(ROOT, ROOT);
    search.nodes(ROOT, ROOT, lower);
    search.nearest
}

struct Search<'s> {
    a: &'s ReferenceBody,
    b: &'s ReferenceBody,
    pose_ab: &'s Pose,
    /// Nothing farther than this matters.
    bound: f64,
    nearest: Option<Separation>,
}

impl Search<'_> {
    fn lower_bound(&self, i: u32, j: u32) -> f64 {
        let (va, vb) = (&self.a.rss.node(i).volume, &self.b.rss.node(j).volume);
        va.lower_bound(vb, self.pose_ab)
    }

    /// Whether nothing at distance `lower` or more is of interest any more.
    fn settled(&self, lower: f64) -> bool {
        match self.nearest {
            Some(found) => lower >= found.distance || found.distance == 0.0,
            None => lower > self.bound,
        }
    }

    fn nodes(&mut self, i: u32, j: u32, lower: f64) {
        if self.settled(lower) {
            return;
        }
        let (na, nb) = (self.a.rss.node(i), self.b.rss.node(j));
        match (na.content, nb.content) {
            (Content::Leaf(fa, ta), Content::Leaf(fb, tb)) => self.leaves((fa, ta), (fb, tb)),
            (Content::Children([l, r]), Content::Leaf(..)) => self.nearer_first((l, j), (r, j)),
            (Content::Children([l, r]), _) if na.volume.size() >= nb.volume.size() => {
                self.nearer_first((l, j), (r, j));
            }
            (_, Content::Children([l, r])) => self.nearer_first((i, l), (i, r)),
        }
    }

    fn nearer_first(&mut self, first: (u32, u32), second: (u32, u32)) {
        let lower_first = self.lower_bound(first.0, first.1);
        let lower_second = self.lower_bound(second.0, second.1);
        let mut children = [(first, lower_first), (second, lower_second)];
        if lower_second < lower_first {
            children.swap(0, 1);
        }
        for ((i, j), lower) in children {
            self.nodes(i, j, lower);
        }
    }

    fn leaves(&mut self, in_a: (u32, u32), in_b: (u32, u32)) {
        for &i in self.a.rss.leaf(in_a.0, in_a.1) {
            for &j in self.b.rss.leaf(in_b.0, in_b.1) {
                let (ea, eb) = (&self.a.elements[i as usize], &self.b.elements[j as usize]);
                let found = element_separation(ea, eb, self.pose_ab);
                let better = match self.nearest {
                    Some(n) => found.distance < n.distance,
                    None => found.distance <= self.bound,
                };
                if better {
                    self.nearest = Some(found);
                }
            }
        }
    }
}
