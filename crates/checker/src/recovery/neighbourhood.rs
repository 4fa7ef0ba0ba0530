//! Contact and clearance in the states near a start: reuses distances at the start, and elements that touched in earlier states.

use clearance_robot::Configuration;
use clearance_scene::BodyId;

use crate::collision_checker::CollisionChecker;
use crate::pair_kind::SearchedPairs;
use crate::pairs::PairsAroundStart;
use crate::workspace::Workspace;

/// The states near a start.
pub struct Neighbourhood<'c> {
    checker: &'c CollisionChecker,
    self_pairs: PairsAroundStart,
    /// Distance (m) that states keep from every contact; 0 for states that are just free.
    clearance: f64,
}

impl<'c> Neighbourhood<'c> {
    pub fn new(
        checker: &'c CollisionChecker,
        start: &Configuration,
        clearance: f64,
        workspace: &mut Workspace,
    ) -> Self {
        let pairs = checker.begin(workspace);
        let (robot, _) = workspace.place(pairs, start);
        Self { checker, self_pairs: PairsAroundStart::new(pairs, robot.frames()), clearance }
    }

    /// Restricts it to the states that differ from the start in these positions only. Self pairs that none of them moves must
    /// keep the clearance at the start.
    pub fn restrict(&mut self, movable: &[bool], workspace: &mut Workspace) {
        let pairs = self.checker.begin(workspace);
        let chain = pairs.robot().chain();
        self.self_pairs.leave_out_unless(|index| {
            chain.positions_on(pairs.path_between(index)).any(|position| movable[position])
        });
    }

    /// True if no pair touches.
    pub fn is_free(&mut self, q: &Configuration, workspace: &mut Workspace) -> bool {
        let pairs = self.checker.begin(workspace);
        let (robot, scratch) = workspace.place(pairs, q);
        if self.self_pairs.known_elements_touch(pairs, robot.frames(), scratch) {
            return false;
        }
        let mut search = workspace.contact_search(pairs);
        search.start = Some(&mut self.self_pairs);
        !search.any_contact(q)
    }

    /// True if all pairs of a free state keep the clearance.
    pub fn keeps_clearance(&mut self, q: &Configuration, workspace: &mut Workspace) -> bool {
        let clearance = self.clearance;
        if clearance == 0.0 {
            return true;
        }
        let pairs = self.checker.begin(workspace);
        let mut state = workspace.queried_state(pairs, q);
        state.queue_candidates(SearchedPairs::All, clearance);
        let (robot, scratch) = (&*state.robot, &mut *state.scratch);
        !state.candidates.iter().any(|pair| {
            if pairs.is_self_pair(pair.index) {
                self.self_pairs.are_within(clearance, (pairs, pair.index), robot.frames(), scratch)
            } else {
                pairs.pair(pair.index, robot.frames()).comes_within(clearance, scratch)
            }
        })
    }

    /// True if a pair of the pair list keeps the clearance in a state.
    pub fn pair_keeps_clearance(
        &self,
        bodies: (BodyId, BodyId),
        q: &Configuration,
        workspace: &mut Workspace,
    ) -> bool {
        let pairs = self.checker.begin(workspace);
        let Some(index) = pairs.number_of(bodies) else { return true };
        let (robot, scratch) = workspace.place(pairs, q);
        !pairs.pair(index, robot.frames()).comes_within(self.clearance, scratch)
    }
}

#[cfg(test)]
mod tests {
    use clearance_geometry::testing::Random;
    use clearance_robot::Configuration;

    use super::Neighbourhood;
    use crate::random_scenes::{checker, state};
    use crate::{CollisionChecker, CollisionReport, Question, Workspace};

    /// Distances (m) nearer to the clearance than this may count either way.
    const ROUNDING: f64 = 1e-9;

    /// A state that differs from the start in the movable positions, by up to a random distance.
    fn near(
        start: &Configuration,
        movable: &[bool],
        checker: &CollisionChecker,
        random: &mut Random,
    ) -> Configuration {
        let radius = [1e-5, 1e-3, 0.02, 0.3][random.below(4)];
        let moved = start.positions().iter().zip(movable);
        let positions: Vec<f64> =
            moved.map(|(q, moves)| if *moves { q + random.within(radius) } else { *q }).collect();
        checker.robot().configuration(&positions).unwrap()
    }

    /// The distances of all pairs up to a little more than the clearance.
    fn distances(
        checker: &CollisionChecker,
        q: &Configuration,
        clearance: f64,
        workspace: &mut Workspace,
    ) -> CollisionReport {
        checker.check(q, Question::PairDistances { limit: clearance + ROUNDING }, workspace)
    }

    #[test]
    fn near_a_start_states_are_free_and_keep_the_clearance_as_anywhere() {
        let mut random = Random::new(53);
        let (mut free, mut hit, mut clear, mut restricted) = (0, 0, 0, 0);
        for _ in 0..400 {
            let checker = checker(&mut random);
            let start = state(checker.robot(), &mut random);
            let clearance = [0.0, 0.003, 0.05][random.below(3)];
            let mut workspace = checker.workspace();
            let mut neighbourhood = Neighbourhood::new(&checker, &start, clearance, &mut workspace);
            let mut movable: Vec<bool> = start.positions().iter().map(|_| random.below(2) == 0).collect();
            let report = distances(&checker, &start, clearance, &mut workspace);
            let moves = |bodies| checker.positions_between(bodies).any(|position| movable[position]);
            if report.pair_distances.iter().all(|pair| moves((pair.a, pair.b))) {
                neighbourhood.restrict(&movable, &mut workspace);
                restricted += 1;
            } else {
                movable.fill(true);
            }
            for _ in 0..20 {
                let q = near(&start, &movable, &checker, &mut random);
                let expected = checker.is_free(&q, &mut workspace);
                assert_eq!(neighbourhood.is_free(&q, &mut workspace), expected, "{start:?} {q:?}");
                (free, hit) = (free + u32::from(expected), hit + u32::from(!expected));
                let pairs = distances(&checker, &q, clearance, &mut workspace).pair_distances;
                if !expected || pairs.iter().any(|pair| (pair.distance - clearance).abs() <= ROUNDING) {
                    continue;
                }
                let keeps = neighbourhood.keeps_clearance(&q, &mut workspace);
                assert_eq!(keeps, pairs.is_empty() || clearance == 0.0, "{clearance} {start:?} {q:?}");
                clear += u32::from(keeps && clearance > 0.0);
            }
        }
        assert!(
            free > 500 && hit > 500 && clear > 100 && restricted > 50,
            "{free} {hit} {clear} {restricted}"
        );
    }
}
