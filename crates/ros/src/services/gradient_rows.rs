//! Signed distances, normals and derivatives of the pairs in a response to `~/get_distances`.

use std::collections::HashMap;

use clearance_checker::{Clearance, PairClearance, WitnessCount};
use clearance_geometry::math::Vector;
use clearance_robot::RobotModel;
use clearance_scene::BodyId;

use crate::messages::clearance_srvs::GetDistancesResponse;
use crate::messages::time_and_geometry::vector_message;
use crate::services::request_rejection::shortened;

/// Size of the signed distance, its upper bound, the normal and the witness count of a pair (bytes).
const BYTES_WITHOUT_ROW: usize = 41;

/// Size of the data that gradients add to each pair (bytes).
pub fn bytes_of_gradient(robot: &RobotModel) -> usize {
    BYTES_WITHOUT_ROW + size_of::<f64>() * robot.position_names().len()
}

/// Adds what is known on these pairs, the listed ones, to a response, in their order. Pairs that the timeout left out have NaN
/// instead of numbers, and the message reports them.
pub fn add_gradients(
    response: &mut GetDistancesResponse,
    robot: &RobotModel,
    listed: &[(BodyId, BodyId)],
    found: &Clearance,
) {
    response.gradient_joints = robot.position_names().to_vec();
    let by_bodies: HashMap<_, _> =
        found.pairs.iter().enumerate().map(|(row, pair)| ((pair.a, pair.b), (pair, row))).collect();
    for bodies in listed {
        match by_bodies.get(bodies) {
            Some((pair, row)) => add_row(response, pair, found.row(*row)),
            None => add_unknown(response, robot.position_names().len()),
        }
    }
    let open = listed.len() - by_bodies.len();
    if open > 0 {
        let note = format!("the timeout left the gradients of {open} of {} pairs open", listed.len());
        let notes: Vec<&str> =
            [response.message.as_str(), &note].into_iter().filter(|n| !n.is_empty()).collect();
        response.message = shortened(notes.join("; "));
        "deadline".clone_into(&mut response.reason_code);
    }
}

fn add_row(response: &mut GetDistancesResponse, pair: &PairClearance, row: &[f64]) {
    response.signed_distances.push(pair.distance);
    response.signed_distances_upper.push(pair.upper);
    response.normals.push(vector_message(&pair.normal.unwrap_or_default()));
    response.witness_counts.push(match pair.witnesses {
        WitnessCount::One => GetDistancesResponse::ONE,
        WitnessCount::Several => GetDistancesResponse::SEVERAL,
        WitnessCount::Unknown => GetDistancesResponse::MANY_UNKNOWN,
    });
    response.gradient.extend_from_slice(row);
}

fn add_unknown(response: &mut GetDistancesResponse, columns: usize) {
    response.signed_distances.push(f64::NAN);
    response.signed_distances_upper.push(f64::NAN);
    response.normals.push(vector_message(&Vector::zeros()));
    response.witness_counts.push(GetDistancesResponse::MANY_UNKNOWN);
    response.gradient.resize(response.gradient.len() + columns, f64::NAN);
}
