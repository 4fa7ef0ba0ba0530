//! Nearest obstacle to the robot parts that no joint moves. Computed once per robot and world, since it is the same in
//! all states.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_proximity::Effort;
use clearance_robot::Chain;

use super::nearest_search::{DistanceScratch, NearestSearch};
use super::pair_evaluation::PairEvaluation;
use super::queried_state::QueriedState;
use crate::collision_report::CollisionReport;
use crate::pairs::{NearestToFixed, SearchedBodies};

/// The nearest obstacle to fixed parts, computed at the first call; all bodies must be placed. Like the building of
/// hierarchies, this does not count as work of a state. With a deadline the result is `None`: the report must depend
/// neither on the time this takes nor on earlier queries.
pub fn nearest_to_fixed(evaluation: &mut PairEvaluation) -> Option<NearestToFixed> {
    if evaluation.effort.deadline.is_some() {
        return None;
    }
    let known = &evaluation.state.pairs.state_independent().nearest_to_fixed;
    Some(known.get().copied().unwrap_or_else(|| {
        // two threads may both compute it, with the same result; neither waits for the other
        let found = find_nearest_to_fixed(evaluation.state.without_stream());
        let _ = known.set(found);
        found
    }))
}

#[cold]
fn find_nearest_to_fixed(state: QueriedState) -> NearestToFixed {
    let (pairs, work) = (state.pairs, state.scratch.work);
    let (effort, mut report) = (Effort::default(), CollisionReport::default());
    let mut evaluation = PairEvaluation { state, effort: &effort, report: &mut report };
    let mut scratch = DistanceScratch::default();
    let mut search = NearestSearch::new(&mut evaluation, &mut scratch, f64::INFINITY);
    search.place_capsules();
    for part in pairs.robot().parts_on(|body| body == Chain::ROOT) {
        search.add_obstacles(part);
    }
    search.add_inside(SearchedBodies::Fixed);
    search.run();
    let nearest = search.measured();
    evaluation.state.scratch.work = work;
    match nearest {
        None => NearestToFixed::Nothing,
        Some(nearest) if nearest.padded > CONTACT_DISTANCE => NearestToFixed::Apart(nearest),
        Some(_) => NearestToFixed::Touching,
    }
}

#[cfg(test)]
mod tests {
    use crate::{CollisionChecker, Question};
    use clearance_geometry::math::Point;
    use clearance_geometry::testing::Random;
    use clearance_geometry::{Primitive, Shape, TriangleMesh};
    use clearance_proximity::Effort;
    use clearance_robot::{MeshFiles, RobotModel};
    use clearance_scene::{BodyId, Settings};
    use clearance_scene::{Obstacle, World};
    use std::sync::Arc;

    /// A base with a mast that is fixed to it, and an arm that turns.
    const URDF: &str = "<robot name='r'>
        <link name='base'><collision><geometry><box size='0.4 0.4 0.2'/></geometry></collision></link>
        <link name='mast'><collision><geometry><cylinder radius='0.05' length='0.8'/></geometry></collision></link>
        <link name='arm'><collision><origin xyz='0.3 0 0'/><geometry><box size='0.6 0.1 0.1'/></geometry></collision></link>
        <joint name='stand' type='fixed'><parent link='base'/><child link='mast'/><origin xyz='0 0 0.5'/></joint>
        <joint name='turn' type='continuous'><parent link='mast'/><child link='arm'/><origin xyz='0.2 0 0.2'/><axis xyz='0 1 1'/></joint></robot>";

    const ROUGH: Effort = Effort {
        relative_tolerance: 0.3,
        absolute_tolerance: 0.01,
        exact_within: 0.0,
        exact_cost: 0,
        deadline: None,
    };

    /// The start of a distance search changes the last bits of its result.
    const ROUNDING: f64 = 1e-12;

    fn scattered(random: &mut Random, name: &str) -> Obstacle {
        let shape = match random.below(3) {
            0 => Shape::Primitive(Primitive::Sphere { radius: 0.1 }),
            1 => Shape::Primitive(Primitive::Box { half_extents: [0.1, 0.2, 0.1] }),
            _ => {
                let corners = (0..12).map(|_| Point::from(random.vector(0.2))).collect();
                let faces = (0..4).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
                Shape::Mesh(Arc::new(TriangleMesh::new(corners, faces).unwrap()))
            }
        };
        Obstacle::of_shape(name, random.pose(1.2), shape)
    }

    /// Counts of each kind of result.
    #[derive(Debug, Default)]
    struct Counts {
        of_fixed: u32,
        of_moving: u32,
        none: u32,
        touching: u32,
    }

    /// Queries checkers of one world; the first checker existed before the last edit of the world.
    fn compare(
        robot: &RobotModel,
        [own, anew]: [&CollisionChecker; 2],
        random: &mut Random,
        counts: &mut Counts,
    ) {
        let fixed = ["base", "mast"].map(|name| BodyId::Link(robot.link_by_name(name).unwrap()));
        let [mut workspace, mut other] = [own.workspace(), anew.workspace()];
        let mut stream = anew.streaming_workspace();
        for _ in 0..10 {
            let q = robot.configuration(&[random.within(3.0)]).unwrap();
            let limit = [f64::INFINITY, 0.2, 0.0][random.below(3)];
            let question = Question::Distance { limit };
            let alone = own.check(&q, question, &mut workspace);
            let all = anew.check(&q, Question::PairDistances { limit }, &mut other);
            let streamed = anew.check(&q, question, &mut stream);
            assert_eq!(alone.is_free(), all.is_free());
            let distances = [&alone, &all, &streamed].map(|report| report.nearest.map(|n| n.distance));
            assert_eq!(distances, [distances[0]; 3], "up to {limit}");
            let Some(nearest) = alone.nearest else {
                counts.none += 1;
                continue;
            };
            for (checker, workspace) in [(own, &mut workspace), (anew, &mut stream)] {
                let rough = checker.check_with(&q, question, &ROUGH, workspace).nearest.unwrap();
                assert!(
                    rough.lower <= nearest.distance + ROUNDING
                        && nearest.distance <= rough.distance + ROUNDING
                );
            }
            if nearest.distance == 0.0 {
                counts.touching += 1;
                continue;
            }
            assert_eq!([alone.nearest, streamed.nearest], [all.nearest; 2]);
            *(if fixed.contains(&nearest.a) { &mut counts.of_fixed } else { &mut counts.of_moving }) += 1;
        }
    }

    #[test]
    fn what_no_joint_moves_is_as_near_as_every_other_question_says() {
        let robot = Arc::new(RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap());
        let (mut random, mut counts) = (Random::new(23), Counts::default());
        for _ in 0..40 {
            let padding = [0.0, 1e-7, 0.03][random.below(3)];
            let settings = Settings { padding, ..Settings::default() };
            let mut world = World::default();
            let mut checker = CollisionChecker::new(Arc::clone(&robot), &world, settings.clone()).unwrap();
            for edit in 0..8 {
                let name = format!("o{}", random.below(4));
                if world.obstacle_by_name(&name).is_some() {
                    world.remove(&name).unwrap();
                }
                if edit % 4 != 3 {
                    world.add(scattered(&mut random, &name)).unwrap();
                }
                checker.set_world(&world).unwrap();
                let anew = CollisionChecker::new(Arc::clone(&robot), &world, settings.clone()).unwrap();
                compare(&robot, [&checker, &anew], &mut random, &mut counts);
            }
        }
        let Counts { of_fixed, of_moving, none, touching } = counts;
        assert!([of_fixed, of_moving, none, touching].iter().all(|count| *count > 150), "{counts:?}");
    }
}
