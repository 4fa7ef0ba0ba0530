//! Least distance of a state: of all pairs, of self pairs, or of world pairs.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Extremes;
use clearance_robot::Chain;

use super::nearest_search::{DistanceScratch, NearestSearch};
use super::nearest_to_fixed::nearest_to_fixed;
use super::pair_evaluation::PairEvaluation;
use crate::collision_report::PairDistance;
use crate::pair_kind::{PairKind, SearchedPairs};
use crate::pairs::{NearestToFixed, SearchedBodies};

/// The least distance of some of the pairs, unless it exceeds `limit` (m). The nearest candidates are searched first,
/// and each pair only up to the least distance so far.
pub fn least_distance(
    evaluation: &mut PairEvaluation,
    scratch: &mut DistanceScratch,
    pairs: SearchedPairs,
    limit: f64,
) -> Option<PairDistance> {
    let limit = limit.greater(CONTACT_DISTANCE);
    let mut search = NearestSearch::new(evaluation, scratch, limit);
    add_pairs(&mut search, pairs, limit);
    search.run();
    search.nearest()
}

fn add_pairs(search: &mut NearestSearch, searched: SearchedPairs, limit: f64) {
    if !search.evaluation().state.place_unless_beyond(limit) {
        return;
    }
    if searched.include(PairKind::SelfPair) {
        add_self_pairs(search, searched);
    }
    if searched.include(PairKind::WorldPair) && !search.evaluation().state.pairs.world().is_empty() {
        add_world_pairs(search, searched);
    }
}

fn add_self_pairs(search: &mut NearestSearch, searched: SearchedPairs) {
    if searched == SearchedPairs::Only(PairKind::SelfPair) {
        search.start_from_last_state(PairKind::SelfPair);
    }
    let limit = search.bound();
    search.evaluation().state.queue_self_candidates(limit);
    search.add_self_pairs();
}

fn add_world_pairs(search: &mut NearestSearch, searched: SearchedPairs) {
    search.place_capsules();
    let is_fixed_known = start_from_fixed(search);
    if searched == SearchedPairs::Only(PairKind::WorldPair) {
        search.start_from_last_state(PairKind::WorldPair);
    }
    let robot = search.evaluation().state.pairs.robot();
    for part in robot.parts_on(|body| !is_fixed_known || body != Chain::ROOT) {
        search.add_obstacles(part);
    }
    search.add_inside(if is_fixed_known { SearchedBodies::Moving } else { SearchedBodies::All });
}

/// Starts from the known distance of the parts that no joint moves; returns true if they need not be searched.
fn start_from_fixed(search: &mut NearestSearch) -> bool {
    match nearest_to_fixed(search.evaluation()) {
        Some(NearestToFixed::Apart(nearest)) => {
            search.start_from(nearest);
            true
        }
        known => matches!(known, Some(NearestToFixed::Nothing)),
    }
}

#[cfg(test)]
mod tests {
    use crate::{CollisionChecker, Question};
    use clearance_geometry::math::{Point, Pose};
    use clearance_geometry::testing::Random;
    use clearance_geometry::{Primitive, Shape, TriangleMesh};
    use clearance_robot::{MeshFiles, RobotModel};
    use clearance_scene::Settings;
    use clearance_scene::{Obstacle, World};
    use std::sync::Arc;

    /// A ball of 0.5 m that slides along x, and another 5 m above it.
    const URDF: &str = "<robot name='r'><link name='root'/><link name='a'><collision><geometry><sphere radius='0.5'/></geometry></collision>
        <collision><origin xyz='0 0 5'/><geometry><box size='1 1 1'/></geometry></collision></link>
        <joint name='j' type='prismatic'><parent link='root'/><child link='a'/><axis xyz='1 0 0'/><limit lower='-9' upper='9' effort='1' velocity='1'/></joint></robot>";

    /// A wall that begins at x = 0: a box, or its face as triangles.
    fn wall(name: &str, of_triangles: bool, z: f64) -> Obstacle {
        let shape = if of_triangles {
            let corner = |y: f64, z: f64| Point::new(0.0, y, z);
            let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            Shape::Mesh(Arc::new(TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap()))
        } else {
            Shape::Primitive(Primitive::Box { half_extents: [0.5, 1.0, 1.0] })
        };
        let x = if of_triangles { 0.0 } else { 0.5 };
        Obstacle::of_shape(name, Pose::translation(x, 0.0, z), shape)
    }

    #[test]
    fn contacts_by_padding_agree_with_every_other_query() {
        let robot = Arc::new(RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap());
        let mut random = Random::new(7);
        for of_triangles in [false, true] {
            let mut world = World::default();
            world.add(wall("low", of_triangles, 0.0)).unwrap();
            world.add(wall("high", of_triangles, 5.0)).unwrap();
            for padding in [0.0, 1e-6, 0.02, 0.3] {
                let settings = Settings { padding, ..Settings::default() };
                let checker = CollisionChecker::new(Arc::clone(&robot), &world, settings).unwrap();
                let (mut workspace, mut stream) = (checker.workspace(), checker.streaming_workspace());
                for _ in 0..400 {
                    let gap = [-0.3, 0.0, 0.01, padding, padding + 1e-9, 0.5][random.below(6)]
                        + random.within(1e-7);
                    let q = robot.configuration(&[-0.5 - gap]).unwrap();
                    let alone =
                        checker.check(&q, Question::Distance { limit: f64::INFINITY }, &mut workspace);
                    let all = checker.check(&q, Question::PairDistances { limit: 10.0 }, &mut workspace);
                    let streamed =
                        checker.check(&q, Question::Distance { limit: f64::INFINITY }, &mut stream);
                    assert_eq!(alone.is_free(), checker.is_free(&q, &mut workspace), "{padding} {gap}");
                    assert_eq!(
                        (alone.is_free(), alone.nearest),
                        (all.is_free(), all.nearest),
                        "{padding} {gap}"
                    );
                    assert_eq!((alone.is_free(), alone.nearest), (streamed.is_free(), streamed.nearest));
                }
            }
        }
    }
}
