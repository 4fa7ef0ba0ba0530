//! Checks that the intervals of a segment's proofs have no gap.

use clearance_geometry::math::Extremes;
use clearance_motion::Proof;

use super::Rejection;
use super::body_pair::BodyPair;

/// Rejects malformed proofs, also those that leave no margin (m), and pairs for which some part of the segment has no proof. Comparisons are exact.
pub(super) fn check(
    segment: usize,
    margin: f64,
    proofs: &[Proof],
    pairs: &[BodyPair],
) -> Result<(), Rejection> {
    for (proof, p) in proofs.iter().enumerate() {
        well_formed((segment, margin), proof, p, pairs)?;
    }
    let mut order: Vec<&Proof> = proofs.iter().collect();
    // mostly in this order already
    order.sort_by(|p, q| p.0.cmp(&q.0).then(p.1.total_cmp(&q.1)));
    let mut rest = order.into_iter().peekable();
    for (number, pair) in pairs.iter().enumerate() {
        let gap = |from: f64, to: f64| Rejection::Gap { segment, pair: pair.names.clone(), from, to };
        let mut reached = 0.0;
        while let Some(Proof(_, from, to, ..)) = rest.next_if(|p| p.0 == number) {
            if *from > reached {
                return Err(gap(reached, *from));
            }
            reached = reached.greater(*to);
        }
        if reached < 1.0 {
            return Err(gap(reached, 1.0));
        }
    }
    Ok(())
}

fn well_formed(
    (segment, margin): (usize, f64),
    proof: usize,
    p: &Proof,
    pairs: &[BodyPair],
) -> Result<(), Rejection> {
    let Proof(pair, from, to, lower, bound) = *p;
    let Some(of) = pairs.get(pair) else {
        return Err(Rejection::PairNumber { segment, proof, pair });
    };
    // comparisons with NaN are false
    if !(0.0 <= from && from < to && to <= 1.0) {
        return Err(Rejection::Interval { segment, proof, from, to });
    }
    if !(lower.is_finite() && bound.is_finite() && bound >= 0.0) {
        return Err(Rejection::Lengths { segment, proof, lower, bound });
    }
    let padding = of.padding + margin;
    if lower > bound + padding {
        Ok(())
    } else {
        Err(Rejection::Short { segment, proof, lower, bound, padding })
    }
}
