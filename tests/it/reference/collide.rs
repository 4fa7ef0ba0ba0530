//! Test oracle: collision test of two bodies, which descends both OBB trees of the reference engine.

use clearance::geometry::math::{Point, Pose};
use clearance::proximity::element_contact;

use super::body::ReferenceBody;
use super::bounding_volume::BoundingVolume;
use super::tree::{Content, ROOT};

/// A common point (frame of a) of two bodies, or `None` if every pair of elements was proven apart.
///
/// Descends both OBB trees at once, the larger volume first (Gottschalk, Lin & Manocha 1996).
pub fn collide(a: &ReferenceBody, b: &ReferenceBody, pose_ab: &Pose) -> Option<Point> {
    Search { a, b, pose_ab }.nodes(ROOT, ROOT)
}

struct Search<'s> {
    a: &'s ReferenceBody,
    b: &'s ReferenceBody,
    pose_ab: &'s Pose,
}

impl Search<'_> {
    fn nodes(&self, i: u32, j: u32) -> Option<Point> {
        let (na, nb) = (self.a.obb.node(i), self.b.obb.node(j));
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

    fn leaves(&self, in_a: (u32, u32), in_b: (u32, u32)) -> Option<Point> {
        for &i in self.a.obb.leaf(in_a.0, in_a.1) {
            for &j in self.b.obb.leaf(in_b.0, in_b.1) {
                let (ea, eb) = (&self.a.elements[i as usize], &self.b.elements[j as usize]);
                if let Some(point) = element_contact(ea, eb, self.pose_ab) {
                    return Some(point);
                }
            }
        }
        None
    }
}
