//! Test helper: linear programming in few variables (Seidel 1991).
//! *Small-dimensional linear programming and convex hulls made easy*: constraints are added one by one in random
//! order. If the optimum violates the next one, the new optimum is on its boundary, a program with one variable
//! less.

use crate::random::Random;

/// Violation up to which a constraint with coefficients of at most 1 holds.
const TOLERANCE: f64 = 1e-13;

/// Coefficient below which a constraint does not depend on a variable.
const NO_COEFFICIENT: f64 = 1e-14;

/// All x with `normal · x <= bound`.
#[derive(Clone, Debug)]
pub struct HalfSpace {
    pub normal: Vec<f64>,
    pub bound: f64,
}

/// Maximises `objective · x` with every variable between plus and minus its limit. `None` if no x fulfils all constraints.
pub fn maximise(
    objective: &[f64],
    limits: &[f64],
    mut constraints: Vec<HalfSpace>,
    random: &mut Random,
) -> Option<Vec<f64>> {
    for last in (1..constraints.len()).rev() {
        let count = u32::try_from(last + 1).expect("few constraints");
        constraints.swap(last, random.below(count) as usize);
    }
    let scaled = constraints.iter().filter_map(HalfSpace::scaled);
    optimum(objective, limits, &scaled.collect::<Vec<_>>())
}

fn optimum(objective: &[f64], limits: &[f64], constraints: &[HalfSpace]) -> Option<Vec<f64>> {
    if let ([objective], [limit]) = (objective, limits) {
        return on_a_line(*objective, *limit, constraints);
    }
    let mut best: Vec<f64> = objective.iter().zip(limits).map(|(c, limit)| limit.copysign(*c)).collect();
    for (i, constraint) in constraints.iter().enumerate() {
        if constraint.excess(&best) > TOLERANCE {
            best = on_boundary(constraint, objective, limits, &constraints[..i])?;
        }
    }
    Some(best)
}

/// With one variable, the constraints leave an interval.
fn on_a_line(objective: f64, limit: f64, constraints: &[HalfSpace]) -> Option<Vec<f64>> {
    let (mut low, mut high) = (-limit, limit);
    for HalfSpace { normal, bound } in constraints {
        let coefficient = normal[0];
        if coefficient > NO_COEFFICIENT {
            high = high.min(bound / coefficient);
        } else if coefficient < -NO_COEFFICIENT {
            low = low.max(bound / coefficient);
        } else if *bound < -TOLERANCE {
            return None;
        }
    }
    let is_empty = low > high + 100.0 * TOLERANCE;
    (!is_empty).then(|| vec![if objective >= 0.0 { high } else { low }])
}

/// The optimum on the boundary of a constraint: the variable with the largest coefficient is replaced.
fn on_boundary(
    boundary: &HalfSpace,
    objective: &[f64],
    limits: &[f64],
    others: &[HalfSpace],
) -> Option<Vec<f64>> {
    let sizes = boundary.normal.iter().map(|c| c.abs());
    let (replaced, size) = sizes.enumerate().max_by(|p, q| p.1.total_cmp(&q.1))?;
    if size <= NO_COEFFICIENT {
        return None;
    }
    let mut inner = Vec::with_capacity(others.len() + 2);
    for side in [1.0, -1.0] {
        let mut normal = vec![0.0; limits.len()];
        normal[replaced] = side;
        inner.push(HalfSpace { normal, bound: limits[replaced] });
    }
    inner.extend_from_slice(others);
    let inner: Vec<HalfSpace> =
        inner.iter().map(|c| c.on(boundary, replaced)).filter_map(|c| c.scaled()).collect();
    if inner.iter().any(|c| c.normal.iter().all(|x| *x == 0.0)) {
        return None;
    }
    let of_objective = HalfSpace { normal: objective.to_vec(), bound: 0.0 }.on(boundary, replaced);
    let mut rest = limits.to_vec();
    rest.remove(replaced);
    let mut best = optimum(&of_objective.normal, &rest, &inner)?;
    best.insert(replaced, 0.0);
    best[replaced] = -boundary.excess(&best) / boundary.normal[replaced];
    Some(best)
}

impl HalfSpace {
    /// How far a point is beyond the boundary, in units of the largest coefficient.
    fn excess(&self, x: &[f64]) -> f64 {
        self.normal.iter().zip(x).map(|(c, x)| c * x).sum::<f64>() - self.bound
    }

    /// The same constraint within the boundary of another one, without the variable that this boundary replaces.
    fn on(&self, boundary: &Self, replaced: usize) -> Self {
        let share = self.normal[replaced] / boundary.normal[replaced];
        let mut normal: Vec<f64> =
            self.normal.iter().zip(&boundary.normal).map(|(c, b)| c - share * b).collect();
        normal.remove(replaced);
        Self { normal, bound: self.bound - share * boundary.bound }
    }

    /// The same constraint with a largest coefficient of 1; `None` if every x fulfils it. All coefficients are 0 if none does.
    fn scaled(&self) -> Option<Self> {
        let largest = self.normal.iter().map(|c| c.abs()).fold(0.0, f64::max);
        if largest > NO_COEFFICIENT {
            let normal = self.normal.iter().map(|c| c / largest).collect();
            return Some(Self { normal, bound: self.bound / largest });
        }
        let none = || Self { normal: vec![0.0; self.normal.len()], bound: -1.0 };
        (self.bound < -TOLERANCE).then(none)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn below(normal: &[f64], bound: f64) -> HalfSpace {
        HalfSpace { normal: normal.to_vec(), bound }
    }

    #[test]
    fn known_optima() {
        let mut random = Random::new(1);
        // 3x + 2y under x + y <= 4, x + 3y <= 6, x <= 3: the corner (3, 1)
        let constraints = vec![below(&[1.0, 1.0], 4.0), below(&[1.0, 3.0], 6.0), below(&[1.0, 0.0], 3.0)];
        for _ in 0..20 {
            let found = maximise(&[3.0, 2.0], &[100.0; 2], constraints.clone(), &mut random).unwrap();
            assert!((found[0] - 3.0).abs() < 1e-12 && (found[1] - 1.0).abs() < 1e-12, "{found:?}");
        }
        // the sum of four variables on a simplex of edge 2
        let constraints = vec![below(&[1.0; 4], 2.0)];
        let found = maximise(&[1.0; 4], &[10.0; 4], constraints, &mut random).unwrap();
        assert!((found.iter().sum::<f64>() - 2.0).abs() < 1e-12);
    }

    #[test]
    fn contradictions_have_no_optimum() {
        let mut random = Random::new(2);
        let constraints = vec![below(&[1.0, 0.0, 1.0], -1.0), below(&[-1.0, 0.0, -1.0], 0.5)];
        assert!(maximise(&[0.0, 0.0, 1.0], &[10.0; 3], constraints, &mut random).is_none());
    }

    /// In two variables an optimum is a corner: the best of all that fulfil the constraints.
    #[test]
    fn random_programs_in_two_variables_agree_with_enumeration() {
        let mut random = Random::new(3);
        for _ in 0..300 {
            let mut all: Vec<HalfSpace> = (0..8)
                .map(|_| {
                    below(&[random.within(-1.0, 1.0), random.within(-1.0, 1.0)], random.within(0.1, 1.0))
                })
                .collect();
            let objective = [random.within(-1.0, 1.0), random.within(-1.0, 1.0)];
            let value = |x: &[f64]| objective[0] * x[0] + objective[1] * x[1];
            let found = maximise(&objective, &[5.0; 2], all.clone(), &mut random).unwrap();
            for axis in 0..2 {
                for side in [1.0, -1.0] {
                    let normal = if axis == 0 { [side, 0.0] } else { [0.0, side] };
                    all.push(below(&normal, 5.0));
                }
            }
            let corners = all.iter().flat_map(|p| all.iter().map(|q| corner(p, q))).flatten();
            let truth = corners
                .filter(|x| all.iter().all(|c| c.excess(x) < 1e-9))
                .map(|x| value(&x))
                .fold(f64::NEG_INFINITY, f64::max);
            assert!((value(&found) - truth).abs() < 1e-8, "{} {truth}", value(&found));
        }
    }

    fn corner(p: &HalfSpace, q: &HalfSpace) -> Option<[f64; 2]> {
        let determinant = p.normal[0] * q.normal[1] - p.normal[1] * q.normal[0];
        let x = (p.bound * q.normal[1] - q.bound * p.normal[1]) / determinant;
        let y = (p.normal[0] * q.bound - q.normal[0] * p.bound) / determinant;
        (determinant.abs() > 1e-9).then_some([x, y])
    }
}
