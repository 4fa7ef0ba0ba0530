//! Do two bodies touch?

use super::containment::Interior;
use super::element_pair::element_contact;
use super::{CollisionBody, Work};
use crate::bounding_volume::BoundingVolume;
use crate::bvh::Content;
use crate::math::{Point, Pose};

/// A common point (frame of a) of two bodies, or `None` if every pair of elements was proven apart.
///
/// Descends both OBB trees at once, the larger volume first (Gottschalk, Lin & Manocha 1996).
#[must_use]
pub fn collide(a: &CollisionBody, b: &CollisionBody, pose_ab: &Pose, work: &mut Work) -> Option<Point> {
    let mut search = Search { a, b, pose_ab, work };
    (search.nodes(a.obb.root(), b.obb.root()))
        .or_else(|| Interior::contained_point(a.interior.as_ref(), b.interior.as_ref(), pose_ab))
}

struct Search<'s> {
    a: &'s CollisionBody,
    b: &'s CollisionBody,
    pose_ab: &'s Pose,
    work: &'s mut Work,
}

impl Search<'_> {
    fn nodes(&mut self, i: u32, j: u32) -> Option<Point> {
        let (na, nb) = (self.a.obb.node(i), self.b.obb.node(j));
        self.work.volume_tests += 1;
        if !na.volume.may_touch(&nb.volume, self.pose_ab) {
            return None;
        }
        match (na.content, nb.content) {
            (Content::Leaf(fa, ta), Content::Leaf(fb, tb)) => self.leaves((fa, ta), (fb, tb)),
            (Content::Children([l, r]), Content::Leaf(..)) => self.nodes(l, j).or_else(|| self.nodes(r, j)),
            (Content::Children([l, r]), _) if na.volume.size() >= nb.volume.size() => {
                self.nodes(l, j).or_else(|| self.nodes(r, j))
            }
            (_, Content::Children([l, r])) => self.nodes(i, l).or_else(|| self.nodes(i, r)),
        }
    }

    fn leaves(&mut self, in_a: (u32, u32), in_b: (u32, u32)) -> Option<Point> {
        for &i in self.a.obb.leaf(in_a.0, in_a.1) {
            for &j in self.b.obb.leaf(in_b.0, in_b.1) {
                self.work.primitive_tests += 1;
                let (ea, eb) = (&self.a.elements[i as usize], &self.b.elements[j as usize]);
                if let Some(point) = element_contact(ea, eb, self.pose_ab) {
                    return Some(point);
                }
            }
        }
        None
    }
}
