//! Best-first search for the least distance of a state. The nearest candidates are bounded first, for triangles in single precision. Only
//! candidates that may still be the nearest at the end are measured exactly.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Extremes;
use clearance_geometry::simd::LANES;
use clearance_proximity::{DistanceCandidate, ElementPair, Piece, Scratch, Separation};
use clearance_robot::Chain;

use super::fixed_nearest::FixedNearest;
use super::nearby::Near;
use super::nearest_first::{NearestFirst, QueuedNear};
use super::pair::Pair;
use super::report::PairDistance;
use super::state_query::StateQuery;
use super::workspace::{QueuedPair, Workspace};

/// State of the search for the least distance.
pub(super) struct Least {
    /// Larger distances (m) are not reported.
    limit: f64,
    /// Upper bound (m) on the least distance.
    upper: f64,
    /// The nearest candidate that was measured at the end.
    measured: Option<Measured>,
    /// The nearest pair that was measured at once or is to be reported; of equally near pairs the first.
    nearest: Option<(usize, PairDistance)>,
    /// Lower bound (m) on the distances of the pairs measured at once.
    lower: f64,
    /// Number of candidates that were bounded so far.
    looks: usize,
}

/// A candidate to be measured at the end, and its pair.
#[derive(Clone, Copy, Debug)]
pub(super) struct InDoubt {
    /// Lower bound (m) on its padded distance.
    lower: f64,
    /// Number of candidates bounded before the one that found it.
    look: usize,
    index: usize,
    what: DistanceCandidate,
}

/// A measured candidate, and its pair.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measured {
    /// The padded distance (m).
    pub padded: f64,
    padding: f64,
    raw: Separation,
    numbers: Option<ElementPair>,
    index: usize,
    look: usize,
}

impl Measured {
    /// Order of preference for the report: the nearer first. Of equally near pairs the first is preferred, and of touching pairs the one
    /// that was found first. Within one pair the order of [`clearance_proximity`] applies.
    fn is_before(&self, other: &Self) -> bool {
        if self.index == other.index {
            return (self.raw.distance, self.numbers) < (other.raw.distance, other.numbers);
        }
        if self.padded == 0.0 && other.padded == 0.0 {
            return self.look < other.look;
        }
        (self.padded, self.index) < (other.padded, other.index)
    }

    /// True if it is within a limit (m), with the same rounding as in the other queries.
    fn is_within(&self, limit: f64) -> bool {
        self.raw.distance <= (limit + self.padding).next_up()
    }
}

impl StateQuery<'_> {
    /// The least distance of all pairs. The nearest candidates are searched first, and each pair only up to the least distance so far.
    pub fn least_distance(&mut self, limit: f64) {
        let mut least = Least::within(limit.greater(CONTACT_DISTANCE));
        let mut queue = std::mem::take(&mut self.workspace.nearest_first);
        self.fill(&mut queue, &mut least);
        self.search(&mut queue, &mut least);
        self.workspace.nearest_first = queue;
        if let Some(best) = least.measured {
            let found = self.told(&best);
            (least.lower, least.nearest) = (found.lower, Some((best.index, found)));
        }
        self.report.nearest = least.nearest.map(|(_, found)| PairDistance {
            // for other pairs it is only proven that they are not nearer than the tolerance allows
            lower: least.lower.lesser(self.certain(found.distance).greater(0.0)),
            ..found
        });
    }

    /// All candidates.
    fn fill(&mut self, queue: &mut NearestFirst, least: &mut Least) {
        queue.clear();
        if !self.checker.self_candidates(self.q, least.limit, self.workspace) {
            return;
        }
        for pair in &self.workspace.queue {
            queue.push(QueuedNear { lower: pair.lower, near: Near::Pair(pair.index) });
        }
        if self.checker.pairs().world_len() == 0 {
            return;
        }
        self.place_capsules();
        let knows_fixed = self.start_from_fixed(least);
        for part in self.checker.parts_on(|body| !knows_fixed || body != Chain::ROOT) {
            queue.push_world(self.checker, part);
        }
    }

    /// Starts from the known distance of the parts that no joint moves; returns true if they need not be searched.
    fn start_from_fixed(&mut self, least: &mut Least) -> bool {
        let nearest = match self.fixed_nearest() {
            Some(FixedNearest::Apart(nearest)) => nearest,
            known => return matches!(known, Some(FixedNearest::Nothing)),
        };
        if nearest.is_within(least.limit) {
            if self.postpones() {
                (least.measured, least.upper) = (Some(nearest), nearest.padded);
            } else {
                let found = self.told(&nearest);
                (least.lower, least.nearest) = (found.lower, Some((nearest.index, found)));
            }
        }
        true
    }

    /// Searches the queue, then measures the candidates that may be the nearest.
    pub fn search(&mut self, queue: &mut NearestFirst, least: &mut Least) {
        self.workspace.asked.clear();
        self.workspace.in_doubt.clear();
        while let Some(queued) = queue.pop() {
            let bound = least.bound(self);
            if queued.lower > bound || bound <= 0.0 {
                break;
            }
            self.look(queued, queue, least);
        }
        self.measure(least);
    }

    /// Bounds the queued candidates, nearest first.
    fn look(&mut self, QueuedNear { lower, near }: QueuedNear, queue: &mut NearestFirst, least: &mut Least) {
        let bound = least.bound(self);
        match near {
            Near::Boxed { part, piece } => {
                let found = self.looked_at(part, piece, lower).filter(|found| found.lower <= bound);
                if let Some(found) = found {
                    queue.push(found);
                }
            }
            Near::Node { part, node } => {
                let Workspace { nearby, scratch, .. } = &mut *self.workspace;
                scratch.work.volume_tests += LANES as u64;
                let (lowers, children) = self.checker.opened(node, (&nearby.capsules[part], scratch.level()));
                queue.push_children(part, lowers, children);
            }
            Near::Piece { part, piece } => {
                let index = self.checker.world_pair(part, self.checker.place_of(piece));
                if self.is_first(index) {
                    self.look_or_ask(QueuedPair { lower, index }, Some((part, piece)), least);
                }
            }
            Near::Pair(index) => {
                if index < self.checker.infos.len() || self.is_first(index) {
                    self.look_or_ask(QueuedPair { lower, index }, None, least);
                }
            }
        }
    }

    /// Bounds the pair, or the part and the obstacle's pieces, that a candidate belongs to; or measures the pair at once.
    fn look_or_ask(&mut self, queued: QueuedPair, nearest: Option<(usize, u32)>, least: &mut Least) {
        match nearest {
            _ if !self.postpones() => self.ask(queued, least),
            Some(part_and_piece) => self.look_at_pieces(queued.index, part_and_piece, least),
            None => self.look_at_pair(queued.index, least),
        }
    }

    /// False if the pair was measured before: several pieces may lead to one pair.
    fn is_first(&mut self, index: usize) -> bool {
        let first = !self.workspace.asked.contains(&index);
        if first {
            self.workspace.asked.push(index);
        }
        first
    }

    /// True if candidates are bounded before any is measured, obstacles piece by piece. Tolerances, deadlines and streams need
    /// pair-by-pair measurement instead.
    fn postpones(&self) -> bool {
        self.effort.is_exact()
            && !self.workspace.stream.as_ref().is_some_and(|stream| stream.is_of(self.checker.revision))
    }

    /// Measures a pair at once.
    fn ask(&mut self, queued: QueuedPair, least: &mut Least) {
        let bound = least.bound(self);
        if let Some(found) = self.distance(queued, bound) {
            least.lower = found.lower.lesser(least.lower);
            if least.nearest.is_none_or(|(other, n)| (found.distance, queued.index) < (n.distance, other)) {
                least.nearest = Some((queued.index, found));
            }
        }
    }

    /// Bounds a whole pair.
    fn look_at_pair(&mut self, index: usize, least: &mut Least) {
        let pair = self.checker.pair(index, &self.workspace.frames);
        let (scratch, in_doubt) = (&mut self.workspace.scratch, &mut self.workspace.in_doubt);
        least.look_at((index, &pair), None, scratch, in_doubt);
    }

    /// Bounds a part and the pieces of an obstacle: the nearest piece first, then the pieces that may be nearer.
    fn look_at_pieces(&mut self, index: usize, (part, piece): (usize, u32), least: &mut Least) {
        let checker = self.checker;
        let pair = checker.pair(index, &self.workspace.frames);
        let (scratch, in_doubt) = (&mut self.workspace.scratch, &mut self.workspace.in_doubt);
        let first = checker.piece(piece);
        least.look_at((index, &pair), Some(&[first]), scratch, in_doubt);
        let nearby = &mut self.workspace.nearby;
        let capsule = nearby.capsules[part];
        let bound = least.limit.lesser(least.upper);
        checker.pieces_near((part, checker.place_of(piece)), &capsule, bound, (scratch, nearby));
        nearby.pieces.retain(|other| *other != first);
        if !nearby.pieces.is_empty() {
            least.look_at((index, &pair), Some(&nearby.pieces), scratch, in_doubt);
        }
    }

    /// Measures the candidates that may be the nearest.
    fn measure(&mut self, least: &mut Least) {
        let mut in_doubt = std::mem::take(&mut self.workspace.in_doubt);
        in_doubt.retain(|other| other.lower <= least.upper);
        in_doubt.sort_unstable_by(|p, q| p.lower.total_cmp(&q.lower).then(p.look.cmp(&q.look)));
        let mut best = least.measured;
        for what in in_doubt.drain(..) {
            if best.is_some_and(|best| what.lower > best.padded) {
                break;
            }
            let measured = self.measured(&what);
            if best.is_none_or(|best| measured.is_before(&best)) {
                best = Some(measured);
            }
        }
        self.workspace.in_doubt = in_doubt;
        least.measured = best.filter(|best| best.is_within(least.limit));
    }

    fn measured(&mut self, InDoubt { look, index, what, .. }: &InDoubt) -> Measured {
        let pair = self.checker.pair(*index, &self.workspace.frames);
        let (raw, numbers) = pair.measured(what, &mut self.workspace.scratch);
        let (padded, padding) = (pair.padded(&raw).distance, pair.info.padding);
        Measured { padded, padding, raw, numbers, index: *index, look: *look }
    }

    fn told(&mut self, best: &Measured) -> PairDistance {
        let pair = self.checker.pair(best.index, &self.workspace.frames);
        pair.told(&best.raw, &mut self.workspace.scratch)
    }

    /// Capsules around all parts at their poses.
    fn place_capsules(&mut self) {
        let Workspace { frames, nearby, .. } = &mut *self.workspace;
        let robot_bodies = self.checker.robot_bodies.iter().enumerate();
        nearby.capsules.clear();
        nearby.capsules.extend(
            robot_bodies
                .map(|(part, robot_body)| self.checker.capsule_of(part, &frames[robot_body.body].frame())),
        );
    }

    /// The candidate for a piece of an obstacle.
    fn looked_at(&mut self, part: usize, piece: u32, known: f64) -> Option<QueuedNear> {
        let Workspace { nearby, scratch, .. } = &mut *self.workspace;
        scratch.work.volume_tests += 1;
        let (lower, near) = self.checker.looked_at(part, piece, &nearby.capsules[part])?;
        Some(QueuedNear { lower: lower.greater(known), near })
    }
}

impl Least {
    /// Start of a search; distances beyond `limit` (m) do not matter.
    pub fn within(limit: f64) -> Self {
        let none = f64::INFINITY;
        Self { limit, upper: none, measured: None, nearest: None, lower: none, looks: 0 }
    }

    /// The nearest candidate that was measured.
    pub fn measured(&self) -> Option<Measured> {
        self.measured
    }

    /// Distances larger than this (m) do not matter.
    fn bound(&self, asked: &StateQuery) -> f64 {
        let measured = self.nearest.map_or(self.limit, |(_, n)| asked.certain(n.distance));
        measured.lesser(self.upper)
    }

    /// Bounds some pieces of an obstacle, or a whole pair.
    fn look_at(
        &mut self,
        (index, pair): (usize, &Pair),
        pieces: Option<&[Piece]>,
        scratch: &mut Scratch,
        in_doubt: &mut Vec<InDoubt>,
    ) {
        let padding = pair.info.padding;
        // rounded up, so that of equally near ones none is left out
        let limit = (self.limit.lesser(self.upper) + padding).next_up();
        let upper = pair.distance_candidates(pieces, limit, scratch, |what| {
            let lower = (what.lower - padding).next_down().greater(0.0);
            in_doubt.push(InDoubt { lower, look: self.looks, index, what });
        });
        // a touching padded pair is no nearer than a pair that touches without padding
        let padded = if upper <= padding { 0.0 } else { (upper - padding).next_up() };
        self.upper = self.upper.lesser(padded);
        self.looks += 1;
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
    fn what_paddings_bring_in_touch_is_told_as_by_every_other_question() {
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
