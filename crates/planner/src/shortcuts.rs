//! Shortcutting of paths (R. Geraerts, M. Overmars: Creating high-quality paths for motion planning, IJRR 2007): states
//! are left out, then edges replace the part of the path between two random states.

use crate::rrt_connect::{Over, Search};
use crate::space::{between, squared_distance};

/// A path of proven edges, at most as long as the given one. Every new edge is proven, too: a part of an edge rounds to another line.
pub fn shortened(way: Vec<Vec<f64>>, tries: u32, search: &mut Search<'_>) -> Vec<Vec<f64>> {
    let mut way = way;
    let _ = leave_out(&mut way, search);
    for _ in 0..tries {
        if way.len() <= 2 || cut(&mut way, search).is_err() {
            break;
        }
    }
    // shortcuts leave short edges behind
    let _ = leave_out(&mut way, search);
    way
}

/// From the start on, goes to the last state that an edge reaches.
fn leave_out(way: &mut Vec<Vec<f64>>, search: &mut Search<'_>) -> Result<(), Over> {
    let mut at = 0;
    while at + 2 < way.len() {
        for to in (at + 2..way.len()).rev() {
            if search.is_free(&way[at], &way[to])? {
                way.drain(at + 1..to);
                break;
            }
        }
        at += 1;
    }
    Ok(())
}

/// Replaces what is between random states of two different edges by an edge, if it is free.
fn cut(way: &mut Vec<Vec<f64>>, search: &mut Search<'_>) -> Result<(), Over> {
    let edges = way.len() - 1;
    let [first, second] = [search.random.usize(..edges), search.random.usize(..edges)];
    let (i, j) = (first.min(second), first.max(second));
    if i == j {
        return Ok(());
    }
    let p = between(&way[i], &way[i + 1], search.random.f64());
    let q = between(&way[j], &way[j + 1], search.random.f64());
    let length = |a: &[f64], b: &[f64]| squared_distance(a, b).sqrt();
    let before = length(&p, &way[i + 1])
        + way[i + 1..=j].windows(2).map(|ends| length(&ends[0], &ends[1])).sum::<f64>()
        + length(&way[j], &q);
    if length(&p, &q) >= before * (1.0 - 1e-9) {
        return Ok(());
    }
    if search.is_free(&p, &q)? && search.is_free(&way[i], &p)? && search.is_free(&q, &way[j + 1])? {
        way.splice(i + 1..=j, [p, q]);
    }
    Ok(())
}
