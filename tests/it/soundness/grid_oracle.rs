//! Test oracle: exact distance of two triangles with integer corners, as a quotient of integers.

type Corner = [i64; 3];

/// A squared distance: numerator and positive denominator.
#[derive(Clone, Copy, Debug)]
pub struct Quotient {
    numerator: i128,
    denominator: i128,
}

impl Quotient {
    const FARTHEST: Self = Self { numerator: 1, denominator: 0 };

    fn of(numerator: i128, denominator: i128) -> Self {
        Self { numerator, denominator }
    }

    /// The smaller one; for coordinates below 2^12 no product overflows.
    pub fn least(self, other: Self) -> Self {
        if other.numerator * self.denominator < self.numerator * other.denominator { other } else { self }
    }

    pub fn is_zero(self) -> bool {
        self.numerator == 0
    }

    /// The distance, rounded at the very end.
    #[allow(clippy::cast_precision_loss)]
    pub fn root(self) -> f64 {
        (self.numerator as f64 / self.denominator as f64).sqrt()
    }
}

fn sub(a: Corner, b: Corner) -> Corner {
    [0, 1, 2].map(|i| a[i] - b[i])
}

fn cross(a: Corner, b: Corner) -> Corner {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: Corner, b: Corner) -> i128 {
    (0..3).map(|i| i128::from(a[i]) * i128::from(b[i])).sum()
}

fn edges(t: &[Corner; 3]) -> [[Corner; 2]; 3] {
    [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]
}

/// The least squared distance of two triangles, of any shape.
pub fn squared_distance(s: &[Corner; 3], t: &[Corner; 3]) -> Quotient {
    let crossing = |t: &[Corner; 3], s: &[Corner; 3]| edges(s).iter().any(|e| pierces(e, t));
    if crossing(t, s) || crossing(s, t) {
        return Quotient::of(0, 1);
    }
    let corners = s.iter().map(|p| point_triangle(*p, t)).chain(t.iter().map(|p| point_triangle(*p, s)));
    let sides = edges(s).into_iter().flat_map(|e| edges(t).map(|f| segments(e, f)));
    corners.chain(sides).fold(Quotient::FARTHEST, Quotient::least)
}

/// Whether an edge that does not lie in the triangle's plane meets the triangle.
fn pierces([p, q]: &[Corner; 2], t: &[Corner; 3]) -> bool {
    let normal = cross(sub(t[1], t[0]), sub(t[2], t[0]));
    let height = |x: &Corner| dot(normal, sub(*x, t[0]));
    let (above_p, above_q) = (height(p).signum(), height(q).signum());
    if above_p * above_q > 0 || (above_p == 0 && above_q == 0) {
        return false;
    }
    let side = |[a, b]: [Corner; 2]| dot(sub(*q, *p), cross(sub(a, *p), sub(b, *p))).signum();
    let sides = edges(t).map(side);
    sides.iter().all(|s| *s >= 0) || sides.iter().all(|s| *s <= 0)
}

fn point_triangle(p: Corner, t: &[Corner; 3]) -> Quotient {
    let normal = cross(sub(t[1], t[0]), sub(t[2], t[0]));
    let inside = |[a, b]: &[Corner; 2]| dot(cross(normal, sub(*b, *a)), sub(p, *a)) >= 0;
    if normal != [0; 3] && edges(t).iter().all(inside) {
        let height = dot(normal, sub(p, t[0]));
        return Quotient::of(height * height, dot(normal, normal));
    }
    edges(t).iter().map(|e| point_segment(p, e)).fold(Quotient::FARTHEST, Quotient::least)
}

fn point_segment(p: Corner, [a, b]: &[Corner; 2]) -> Quotient {
    let (d, r) = (sub(*b, *a), sub(p, *a));
    let (along, length) = (dot(d, r), dot(d, d));
    if along <= 0 {
        return Quotient::of(dot(r, r), 1);
    }
    if along >= length {
        let rest = sub(p, *b);
        return Quotient::of(dot(rest, rest), 1);
    }
    let across = cross(d, r);
    Quotient::of(dot(across, across), length)
}

/// Two segments that are nearest inside both; their ends are another's business.
fn segments([p, q]: [Corner; 2], [r, s]: [Corner; 2]) -> Quotient {
    let (d, e, offset) = (sub(q, p), sub(s, r), sub(r, p));
    let normal = cross(d, e);
    let squared = dot(normal, normal);
    let inside = |along: Corner| (0..=squared).contains(&dot(cross(offset, along), normal));
    if squared == 0 || !inside(e) || !inside(d) {
        return Quotient::FARTHEST;
    }
    let height = dot(offset, normal);
    Quotient::of(height * height, squared)
}

#[test]
fn known_distances() {
    let s = [[0, 0, 0], [4, 0, 0], [0, 4, 0]];
    let at = |t: [Corner; 3]| squared_distance(&s, &t).root();
    assert_eq!(at([[1, 1, 3], [9, 9, 9], [9, 0, 9]]), 3.0);
    assert_eq!(at([[3, 3, 0], [9, 9, 0], [9, 8, 0]]), 2f64.sqrt());
    assert_eq!(at([[-3, -4, 0], [-9, -9, 0], [-8, -9, 0]]), 5.0);
    assert_eq!(at([[1, 1, -1], [1, 1, 1], [9, 9, 0]]), 0.0);
    assert_eq!(at([[2, 2, 0]; 3]), 0.0);
    assert_eq!(at([[2, -2, 2], [2, 2, -2], [2, -2, -2]]), 0.0);
}
