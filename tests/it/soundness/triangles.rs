//! Tests of triangle against triangle: slivers, needles, coplanar and degenerate ones, huge and tiny ones.

use clearance::geometry::math::{Point, Pose, Vector};

use super::laws::{Case, Scrutiny, judge};
use super::ledger::{Accuracy, Family, Ledger, survey};
use super::share;
use super::subject::Subject;
use crate::random::Random;

type Corners = [Point; 3];

/// What the rounding of posed corners may add up to.
pub const OF_TRIANGLES: Accuracy = Accuracy { absolute: 0.0, of_reach: 3e-14, shortfall: 0.0 };

/// Judges pairs made in one frame and asked about in two others.
fn ask(name: &'static str, seed: u64, make: impl Fn(&mut Random) -> [Corners; 2] + Sync) {
    let family = Family { name, accuracy: OF_TRIANGLES };
    let count = share(1500, 1_000_000);
    let ledger = survey(count, seed, |random, ledger| {
        let pair = make(random);
        judge_pair(pair, &family, random, ledger);
    });
    ledger.finish(&family, count);
}

/// One in four is asked about as it was made; the corners of the others are rounded in frames of their own.
fn judge_pair([s, t]: [Corners; 2], family: &Family, random: &mut Random, ledger: &mut Ledger) {
    let largest = s.iter().chain(&t).map(|p| p.coords.amax()).fold(0.0, f64::max);
    let mut frame = || if random.below(2) == 0 { Pose::identity() } else { random.pose(largest) };
    let (frame_a, frame_b) = (frame(), frame());
    let local = |frame: &Pose, corners: &Corners| corners.map(|p| frame.inverse_transform_point(&p));
    let (a, b) = (Subject::triangle(local(&frame_a, &s)), Subject::triangle(local(&frame_b, &t)));
    let case = Case { a: &a, b: &b, pose_ab: frame_a.inv_mul(&frame_b) };
    let scrutiny = Scrutiny::mostly_answers(random);
    judge(&case, family.accuracy, scrutiny, random, ledger);
}

/// Ten to a random power.
fn power(random: &mut Random, least: f64, most: f64) -> f64 {
    10f64.powf(random.within(least, most))
}

fn triangle(random: &mut Random, size: f64) -> Corners {
    random.triangle(size).corners()
}

fn shifted(corners: Corners, by: &Vector) -> Corners {
    corners.map(|p| p + by)
}

/// Long 1, wide down to 1e-7, and a point inside it.
fn sliver(random: &mut Random) -> (Corners, Point) {
    let along = random.vector(1.0).normalize();
    let across = along.cross(&random.vector(1.0)).normalize() * power(random, -7.0, 0.0);
    let a = random.point(1.0);
    let corners = [a, a + along, a + along * random.within(-0.2, 1.2) + across];
    let (u, v) = (random.within(0.05, 0.45), random.within(0.05, 0.45));
    (corners, corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v)
}

/// A gap or a depth so small that only a careful engine sees it; sometimes none.
fn small_shift(random: &mut Random) -> Vector {
    if random.below(4) == 0 {
        return Vector::zeros();
    }
    random.vector(1.0).normalize() * power(random, -12.0, -3.0)
}

#[test]
fn random_triangles() {
    ask("random triangles", 100, |random| {
        let shift = random.vector(1.2);
        [triangle(random, 1.0), shifted(triangle(random, 1.0), &shift)]
    });
}

#[test]
fn slivers() {
    ask("slivers to 1:1e7", 101, |random| {
        let (s, in_s) = sliver(random);
        let (t, in_t) = sliver(random);
        let shift = if random.below(3) == 0 { random.vector(0.5) } else { small_shift(random) };
        [s, shifted(t, &(in_s - in_t + shift))]
    });
}

#[test]
fn slivers_against_plain_triangles() {
    ask("slivers against triangles", 102, |random| {
        let (s, in_s) = sliver(random);
        let t = triangle(random, 1.0);
        let touching = if random.below(2) == 0 { t[0] } else { nalgebra::center(&t[0], &t[1]) };
        let shift = in_s - touching + small_shift(random);
        [s, shifted(t, &shift)]
    });
}

/// Slivers along one line: the hardest for the distance of edges.
#[test]
fn nearly_parallel_needles() {
    ask("nearly parallel needles", 103, |random| {
        let along = random.vector(1.0).normalize();
        let turn = along.cross(&random.vector(1.0)).normalize() * power(random, -14.0, -1.0);
        let start = random.point(1.0);
        let mut needle = |d: Vector| {
            let a = start + d * random.within(-1.0, 0.2) + small_shift(random);
            let aside = d.cross(&random.vector(1.0)) * power(random, -9.0, -2.0);
            [a, a + d, a + d * random.within(0.0, 1.0) + aside]
        };
        [needle(along), needle((along + turn).normalize())]
    });
}

/// In one plane: overlapping, touching or apart there, and lifted a little out of it.
#[test]
fn coplanar() {
    ask("coplanar", 104, |random| {
        let pose = random.pose(1.0);
        let lift = if random.below(2) == 0 { 0.0 } else { power(random, -12.0, -3.0) };
        let aside = random.within(-2.0, 2.0);
        let mut flat = |x: f64, z: f64| {
            [0; 3].map(|_| pose * Point::new(x + random.within(-1.0, 1.0), random.within(-1.0, 1.0), z))
        };
        [flat(0.0, 0.0), flat(aside, lift)]
    });
}

/// Equal corners, equal edges, one within the other, and the very same triangle.
#[test]
fn shared_corners_and_edges() {
    ask("shared corners and edges", 105, |random| {
        let s = triangle(random, 1.0);
        let mut t = triangle(random, 1.0);
        let (i, j) = (random.below(3) as usize, random.below(3) as usize);
        match random.below(5) {
            0 => t[i] = s[j],
            1 => (t[i], t[(i + 1) % 3]) = (s[j], s[(j + 1) % 3]),
            2 => (t[i], t[(i + 1) % 3]) = (s[(j + 1) % 3], s[j]),
            3 => t[i] = nalgebra::center(&s[j], &s[(j + 1) % 3]),
            _ => t = [s[i], s[(i + 1) % 3], s[(i + 2) % 3]],
        }
        let apart = if random.below(2) == 0 { Vector::zeros() } else { small_shift(random) };
        [s, shifted(t, &apart)]
    });
}

/// Points and segments, exactly and all but so.
#[test]
fn degenerate() {
    ask("degenerate", 106, |random| {
        let mut degenerate = |size: f64| {
            let [a, b, c] = triangle(random, size);
            match random.below(5) {
                0 => [a; 3],
                1 => [a, b, b],
                2 => [a, b, a],
                3 => [a, b, nalgebra::center(&a, &b)],
                _ => [a, b, c],
            }
        };
        let (s, t) = (degenerate(1.0), degenerate(1.0));
        let shift = match random.below(3) {
            0 => Vector::zeros(),
            1 => s[0] - t[0],
            _ => nalgebra::center(&s[0], &s[1]) - nalgebra::center(&t[0], &t[1]) + small_shift(random),
        };
        [s, shifted(t, &shift)]
    });
}

/// From a micrometre to a kilometre, each triangle of its own size.
#[test]
fn huge_and_tiny() {
    ask("1 um to 1 km", 107, |random| {
        let size = power(random, -6.0, 3.0);
        let other = if random.below(2) == 0 { size } else { power(random, -6.0, 3.0) };
        let (s, t) = (triangle(random, size), triangle(random, other));
        let shift = random.vector(size.max(other));
        let meets = s[0] + (s[1] - s[0]) * 0.3 + (s[2] - s[0]) * 0.4 - t[0];
        [s, shifted(t, if random.below(2) == 0 { &shift } else { &meets })]
    });
}

/// Frames whose origins lie up to a thousand kilometres away.
#[test]
fn far_from_the_origin() {
    ask("far from the origin", 108, |random| {
        let far = random.vector(1.0) * power(random, 1.0, 6.0);
        let (s, t) = (triangle(random, 1.0), triangle(random, 1.0));
        let apart = random.vector(1.0);
        [shifted(s, &far), shifted(t, &(far + apart))]
    });
}
