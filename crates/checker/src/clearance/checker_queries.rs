//! Methods of the collision checker for clearance: signed distances with derivatives, of one state or many.

use std::time::Instant;

use clearance_robot::Configuration;
use clearance_scene::BodyId;
use rayon::prelude::*;

use super::pair_clearances::{Clearance, ClearanceOptions};
use crate::collision_checker::CollisionChecker;
use crate::workspace::Workspace;

impl CollisionChecker {
    /// Signed distances of all pairs up to `influence_distance` (m, padding subtracted), with witness points, normals and
    /// derivatives with respect to the positions: [`Clearance`]. Distances of pairs that are apart are those of
    /// [`Question::PairDistances`](crate::Question::PairDistances), bit by bit.
    ///
    /// Does not use a stream's memory. The first depth of a body takes milliseconds longer than others, for its preparation.
    #[must_use]
    pub fn clearance(
        &self,
        q: &Configuration,
        influence_distance: f64,
        workspace: &mut Workspace,
    ) -> Clearance {
        self.clearance_with(q, &ClearanceOptions::new(influence_distance), workspace)
    }

    /// As [`Self::clearance`], with another tolerance for equally near points, or with all of them.
    #[must_use]
    pub fn clearance_with(
        &self,
        q: &Configuration,
        options: &ClearanceOptions,
        workspace: &mut Workspace,
    ) -> Clearance {
        let mut result = Clearance::default();
        self.clearance_into(q, options, workspace, &mut result);
        result
    }

    /// As [`Self::clearance_with`], into an earlier result, whose memory is reused. Once it and the workspace are warm,
    /// only depths of overlapping bodies allocate.
    pub fn clearance_into(
        &self,
        q: &Configuration,
        options: &ClearanceOptions,
        workspace: &mut Workspace,
        result: &mut Clearance,
    ) {
        let pairs = self.begin(workspace);
        result.clear(q.positions().len());
        workspace.clearance_query(pairs, q, options, result).evaluate();
    }

    /// As [`Self::clearance`], of these pairs of bodies at any distance, in their order. A pair whose evaluation would begin after the
    /// deadline is left out, and so are all that follow it; one that is not in the pair list is left out, too.
    #[must_use]
    pub fn clearance_of_pairs(
        &self,
        q: &Configuration,
        bodies: &[(BodyId, BodyId)],
        deadline: Option<Instant>,
        workspace: &mut Workspace,
    ) -> Clearance {
        let pairs = self.begin(workspace);
        let (mut result, options) = (Clearance::default(), ClearanceOptions::new(f64::INFINITY));
        result.clear(q.positions().len());
        let is_over = || deadline.is_some_and(|deadline| Instant::now() >= deadline);
        workspace.clearance_query(pairs, q, &options, &mut result).evaluate_pairs(bodies, is_over);
        result
    }

    /// The result of [`Self::clearance`] for each state, in their order: the same for any number of threads.
    ///
    /// Runs on the threads of the rayon pool it is called in.
    #[must_use]
    pub fn clearances(&self, states: &[Configuration], influence_distance: f64) -> Vec<Clearance> {
        self.clearances_with(states, &ClearanceOptions::new(influence_distance))
    }

    /// The result of [`Self::clearance_with`] for each state, as [`Self::clearances`].
    #[must_use]
    pub fn clearances_with(&self, states: &[Configuration], options: &ClearanceOptions) -> Vec<Clearance> {
        (states.par_iter())
            .with_min_len(16)
            .map_init(|| self.workspace(), |workspace, q| self.clearance_with(q, options, workspace))
            .collect()
    }
}
