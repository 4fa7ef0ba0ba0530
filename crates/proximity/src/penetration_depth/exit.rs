//! Shortest way of a point out of a body.

use clearance_geometry::math::{Point, Vector};

use super::convex_solid::ConvexSolid;
use super::solid_body::{Part, Union, distance_of_point};
use crate::elements::RoundedShape;
use crate::search::Scratch;

/// Distance (m) below which a direction is not defined.
const NEAR: f64 = 1e-9;

/// Shortest way of a point out of a body: out of the shape in which it is deepest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exit {
    /// Unit vector.
    pub direction: Vector,
    /// Depth (m); for a point outside, minus its distance.
    pub depth: f64,
}

impl Union {
    /// The way out for a point of the body's frame; for a point outside, away from the body. `None` where there is no direction.
    pub fn exit(&self, p: &Point, scratch: &mut Scratch) -> Option<Exit> {
        let of_convex = self.parts.iter().filter_map(|part| match part {
            Part::Convex(solid) => solid.exit(p),
            _ => None,
        });
        let of_meshes = self.is_in_mesh(p).then(|| self.exit_through_surface(p, scratch)).flatten();
        let inside = of_convex.chain(of_meshes).max_by(|a, b| a.depth.total_cmp(&b.depth));
        inside.or_else(|| {
            let found = distance_of_point(&self.whole, p, scratch)?;
            let direction = (p - found.witness_points[0]).try_normalize(NEAR)?;
            Some(Exit { direction, depth: -found.distance })
        })
    }

    fn exit_through_surface(&self, p: &Point, scratch: &mut Scratch) -> Option<Exit> {
        let found = distance_of_point(self.surface_only(), p, scratch)?;
        let direction = (found.witness_points[0] - p).try_normalize(NEAR)?;
        Some(Exit { direction, depth: found.distance })
    }
}

impl ConvexSolid {
    /// The way out for a point inside; `None` for others.
    fn exit(&self, p: &Point) -> Option<Exit> {
        match self {
            Self::Primitive(rounded) => rounded.exit(p),
            Self::Hull(hull) => {
                let depth = |face: &super::HalfSpace| face.offset - face.normal.dot(&p.coords);
                let nearest = hull.faces().iter().min_by(|a, b| depth(a).total_cmp(&depth(b)))?;
                let exit = Exit { direction: nearest.normal, depth: depth(nearest) };
                (exit.depth >= 0.0).then_some(exit)
            }
        }
    }
}

impl RoundedShape {
    fn exit(&self, p: &Point) -> Option<Exit> {
        let own = Point::from(self.pose.rotation.tr_mul(&(p.coords - self.pose.translation)));
        let (depth, out) = if let Some((depth, surface)) = self.core.depth(&own) {
            (depth, surface - own)
        } else {
            let away = own - self.core.nearest_point(&own);
            (-away.norm(), away)
        };
        let out = out.try_normalize(NEAR).unwrap_or_else(Vector::x);
        let exit = Exit { direction: self.pose.rotation * out, depth: depth + self.radius };
        (exit.depth >= 0.0).then_some(exit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::penetration_depth::SolidBody;
    use clearance_geometry::Shape;
    use clearance_geometry::testing::Random;

    /// The way out leads to the surface, and as deep as a ball around the point is large.
    #[test]
    fn the_way_out_ends_on_the_surface() {
        let (mut random, mut scratch) = (Random::new(6), Scratch::default());
        for _ in 0..500 {
            let primitive = random.primitive();
            let pose = random.pose(0.3);
            let body = SolidBody::new([(&pose, &Shape::Primitive(primitive))]);
            let union = body.union.as_ref().unwrap();
            for _ in 0..20 {
                let p = Point::from(random.vector(0.8));
                let Some(Exit { direction, depth }) = union.exit(&p, &mut scratch) else { continue };
                assert!((direction.norm() - 1.0).abs() < 1e-9);
                let expected = union.depth_of_point(&p, &mut scratch);
                assert!((depth - expected).abs() < 1e-6, "{primitive:?} {depth} {expected}");
                let end = union.depth_of_point(&(p + direction * depth), &mut scratch);
                assert!(end.abs() < 1e-6, "{primitive:?} {depth} {end}");
            }
        }
    }
}
