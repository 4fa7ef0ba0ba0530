//! Collision checker: collision and distance queries on states and motions of a robot in a world.

use std::ops::RangeInclusive;
use std::sync::Arc;

use clearance_motion::{Certificate, MotionSegment, SegmentError, Trajectory};
use clearance_proximity::bvh::AxisBox;
use clearance_proximity::{Effort, Scratch};
use clearance_robot::{Configuration, LinkPoses, Reach, RobotModel};
use clearance_scene::{AllowedCollisionMatrix, BodyId, PairList, Settings, World};
use rayon::prelude::*;

use crate::collision_report::CollisionReport;
use crate::motion::{
    self, CertificateConstants, CertificateSubject, CheckedMotion, LookAhead, LookAheadState, MotionCheck,
    MotionOptions, MotionReport, SweptVolume, TrajectoryReport,
};
use crate::pair_kind::PairKind;
use crate::pairs::{CheckedPairs, PosedPair};
use crate::question::Question;
use crate::revision::Revision;
use crate::robot::{self, LinkVolume, RobotBody};
use crate::settings_error::SettingsError;
use crate::state::{Contact, FoundContact, PairContacts};
use crate::workspace::Workspace;
use crate::world::PlacedObstacle;

/// States that one thread takes at a time.
const BLOCK: usize = 256;

/// Collision checker of a robot in a world; can be queried from any number of threads: `Send + Sync`, no lock.
///
/// Each thread passes its own [`Workspace`]. Once a workspace is warm, queries on states do not allocate, except for
/// the vectors of their reports.
#[derive(Clone, Debug)]
pub struct CollisionChecker {
    pairs: CheckedPairs,
    settings: Settings,
    matrix: Option<AllowedCollisionMatrix>,
    certificates: CertificateConstants,
    /// Unique among all checkers that were built; a change of the world in place keeps it.
    identity: Revision,
}

impl CollisionChecker {
    /// Builds the hierarchies of every link and obstacle, and selects the pairs by SRDF or adjacency.
    pub fn new(robot: Arc<RobotModel>, world: &World, settings: Settings) -> Result<Self, SettingsError> {
        Self::with_matrix(robot, world, settings, None)
    }

    /// As [`Self::new`]; a scene's allowed collision matrix, if given, selects the pairs instead of the SRDF.
    pub fn with_matrix(
        robot: Arc<RobotModel>,
        world: &World,
        settings: Settings,
        matrix: Option<&AllowedCollisionMatrix>,
    ) -> Result<Self, SettingsError> {
        let pairs = CheckedPairs::new(robot, world, &settings, matrix, None)?;
        Ok(Self::of_pairs(pairs, settings, matrix))
    }

    /// The same robot in another world, or with other settings or another matrix. Hierarchies that do not change are
    /// shared.
    pub fn with_world(
        &self,
        world: &World,
        settings: Settings,
        matrix: Option<&AllowedCollisionMatrix>,
    ) -> Result<Self, SettingsError> {
        let robot = Arc::clone(self.robot());
        let pairs = CheckedPairs::new(robot, world, &settings, matrix, Some(&self.pairs))?;
        Ok(Self::of_pairs(pairs, settings, matrix))
    }

    fn of_pairs(pairs: CheckedPairs, settings: Settings, matrix: Option<&AllowedCollisionMatrix>) -> Self {
        let (certificates, identity) = (CertificateConstants::default(), Revision::next());
        Self { pairs, settings, matrix: matrix.cloned(), certificates, identity }
    }

    /// Changes the world in place: only obstacles that differ are updated, unless attached objects differ. If this is
    /// not possible, returns an error and changes nothing.
    pub fn set_world(&mut self, world: &World) -> Result<(), SettingsError> {
        let same = |(a, b): (&Arc<_>, &Arc<_>)| Arc::ptr_eq(a, b);
        let (held, holds) = (self.world().attached(), world.attached());
        if held.len() != holds.len() || !held.iter().zip(holds).all(same) {
            *self = self.with_world(world, self.settings.clone(), self.matrix.as_ref())?;
            return Ok(());
        }
        self.pairs.set_world(world, &self.settings)?;
        self.certificates = CertificateConstants::default();
        Ok(())
    }

    /// The robot model that the checker was built from.
    #[must_use]
    pub fn robot(&self) -> &Arc<RobotModel> {
        self.pairs.robot().model()
    }

    /// The present world.
    #[must_use]
    pub fn world(&self) -> &World {
        self.pairs.world().world()
    }

    /// The settings that the checker was built with.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// True if a scene's allowed collision matrix selects the pairs.
    pub(crate) fn has_matrix(&self) -> bool {
        self.matrix.is_some()
    }

    /// The pairs that are checked.
    #[must_use]
    pub fn pairs(&self) -> &PairList {
        self.pairs.world().pair_list()
    }

    /// Begins a query: adapts the workspace to this checker.
    pub(crate) fn begin(&self, workspace: &mut Workspace) -> &CheckedPairs {
        workspace.adapt(self.identity, &self.pairs);
        workspace.reset_work();
        &self.pairs
    }

    /// True if there are pairs of this kind that are checked.
    #[must_use]
    pub fn checks(&self, kind: PairKind) -> bool {
        self.pairs.include(kind)
    }

    #[cfg(test)]
    pub(crate) fn checked_pairs(&self) -> &CheckedPairs {
        &self.pairs
    }

    /// The name of a link or an object.
    #[must_use]
    pub fn body_name(&self, body: BodyId) -> &str {
        self.pairs.body_name(body)
    }

    /// Memory of all hierarchies and the triangles in them (bytes), and the number of triangles.
    #[must_use]
    pub fn hierarchy_size(&self) -> (usize, usize) {
        let of_parts = self.pairs.robot().parts().iter().map(RobotBody::solid);
        let of_obstacles = self.pairs.world().obstacles().iter().map(PlacedObstacle::solid);
        let solids = of_parts.chain(of_obstacles);
        solids.fold((0, 0), |(bytes, triangles), s| (bytes + s.bytes(), triangles + s.triangle_count()))
    }

    /// Scratch memory for one thread.
    #[must_use]
    pub fn workspace(&self) -> Workspace {
        Workspace::new(self.identity, &self.pairs, Scratch::default())
    }

    /// As [`Self::workspace`], but uses only the baseline instructions of this architecture. Results are the same, bit
    /// by bit.
    #[must_use]
    pub fn portable_workspace(&self) -> Workspace {
        Workspace::new(self.identity, &self.pairs, Scratch::portable())
    }

    /// As [`Self::workspace`], for states that follow each other closely: results of one state are reused for the next,
    /// and only pairs for which they do not suffice are searched again. Reports are the same, except for their work
    /// counts. Distances within a tolerance ([`Self::check_with`]) are bounds that depend on earlier queries, for a
    /// fraction of the work.
    #[must_use]
    pub fn streaming_workspace(&self) -> Workspace {
        self.workspace().with_stream(&self.pairs)
    }

    /// True if every pair is proven apart; stops at the first that is not.
    #[must_use]
    pub fn is_free(&self, q: &Configuration, workspace: &mut Workspace) -> bool {
        workspace.adapt(self.identity, &self.pairs);
        if workspace.has_stream_of(&self.pairs) {
            let (effort, mut report) = (Effort::default(), CollisionReport::default());
            return !workspace.state_query(&self.pairs, q, &effort, &mut report).any_contact();
        }
        !workspace.contact_search(&self.pairs).any_contact(q)
    }

    /// Evaluates `question` on the state `q`.
    #[must_use]
    pub fn check(&self, q: &Configuration, question: Question, workspace: &mut Workspace) -> CollisionReport {
        self.check_with(q, question, &Effort::default(), workspace)
    }

    /// As [`Self::check`], with tolerances for distances, or until a deadline. Pairs left open at the deadline are
    /// listed as undecided in the report, and the robot is not free. Queries with a deadline do not use a stream's
    /// memory. Results of a stream within a tolerance depend on earlier queries, and may include pairs of which only
    /// the lower bound is within the limit.
    #[must_use]
    pub fn check_with(
        &self,
        q: &Configuration,
        question: Question,
        effort: &Effort,
        workspace: &mut Workspace,
    ) -> CollisionReport {
        workspace.adapt(self.identity, &self.pairs);
        workspace.reset_work();
        let mut report = CollisionReport::default();
        workspace.state_query(&self.pairs, q, effort, &mut report).evaluate(question);
        report.work = workspace.work();
        report
    }

    /// Uses the idle time before the next state: renews the memory of pairs that the next state will probably have to
    /// search, so that its result comes sooner. Changes no exact result.
    pub fn prepare(&self, workspace: &mut Workspace) {
        workspace.prepare(self.identity, &self.pairs);
    }

    /// For each state, the result of [`Self::is_free`]. Results are the same for any number of threads.
    ///
    /// Runs on the threads of the rayon pool it is called in.
    #[must_use]
    pub fn are_free(&self, states: &[Configuration]) -> Vec<bool> {
        let mut free = vec![false; states.len()];
        (free.par_chunks_mut(BLOCK).zip(states.par_chunks(BLOCK))).for_each_init(
            || self.workspace(),
            |workspace, (free, states)| self.are_free_with(states, workspace, free),
        );
        free
    }

    /// As [`Self::are_free`], on this thread and with this workspace; writes to `free`, which is as long as `states`.
    ///
    /// # Panics
    /// When `free` is not as long as `states`.
    pub fn are_free_with(&self, states: &[Configuration], workspace: &mut Workspace, free: &mut [bool]) {
        assert_eq!(states.len(), free.len(), "a result for every state");
        workspace.adapt(self.identity, &self.pairs);
        workspace.batch_search(&self.pairs).find_free(states, free);
    }

    /// Evaluates `question` on each state, as [`Self::check`] does: the same reports, in the order of the states, for
    /// any number of threads.
    ///
    /// Runs on the threads of the rayon pool it is called in.
    #[must_use]
    pub fn check_states(&self, states: &[Configuration], question: Question) -> Vec<CollisionReport> {
        (states.par_iter())
            .with_min_len(16)
            .map_init(|| self.workspace(), |workspace, q| self.check(q, question, workspace))
            .collect()
    }

    /// The contact of a pair of the pair list in the state `q`; `None` if the bodies are apart, or if this is no such
    /// pair.
    ///
    /// The depth of bodies that overlap comes from [`penetration_depth`](clearance_proximity::penetration_depth): closed
    /// meshes count as solids, also where the checker takes them for surfaces. If only the paddings overlap, it comes
    /// from the distance. The first depth of a body takes milliseconds longer than others, for its preparation.
    #[must_use]
    pub fn contact(
        &self,
        q: &Configuration,
        bodies: (BodyId, BodyId),
        workspace: &mut Workspace,
    ) -> Option<Contact> {
        self.in_pair(q, bodies, workspace, |pair, index, scratch| {
            FoundContact::of_pair(pair, || self.pairs.solids(index), scratch).map(|found| found.contact)
        })
    }

    /// The contacts of a pair of the pair list in the state `q`, at most `max_contacts` and at least the deepest;
    /// `None` if the bodies are apart, or if this is no such pair.
    ///
    /// The deepest is that of [`Self::contact`], except that its point is always in both bodies. The others are spread
    /// over the region of contact ([`contact_points`](clearance_proximity::contact_points)): the corners of a box on a
    /// table, all feet of a chair. They take as long as a few queries of distances, tens of milliseconds for huge
    /// meshes. The result does not depend on earlier queries.
    #[must_use]
    pub fn contacts(
        &self,
        q: &Configuration,
        bodies: (BodyId, BodyId),
        max_contacts: usize,
        workspace: &mut Workspace,
    ) -> Option<PairContacts> {
        self.in_pair(q, bodies, workspace, |pair, index, scratch| {
            PairContacts::of_pair(pair, || self.pairs.solids(index), max_contacts, scratch)
        })
    }

    /// As [`Self::contact`], but without normal and depth unless only the paddings overlap: for callers without time.
    #[must_use]
    pub fn common_point(
        &self,
        q: &Configuration,
        bodies: (BodyId, BodyId),
        workspace: &mut Workspace,
    ) -> Option<Contact> {
        self.in_pair(q, bodies, workspace, |pair, _, scratch| {
            FoundContact::without_depth(pair, scratch).map(|found| found.contact)
        })
    }

    /// The positions that move one body of a pair relative to the other; none if this is no pair of the pair list.
    pub(crate) fn positions_between(&self, bodies: (BodyId, BodyId)) -> impl Iterator<Item = usize> {
        let path = self.pairs.number_of(bodies).map(|index| self.pairs.path_between(index));
        path.into_iter().flat_map(|path| self.pairs.robot().chain().positions_on(path))
    }

    /// Evaluates a pair of the pair list, with its number, in the state `q`.
    fn in_pair<T>(
        &self,
        q: &Configuration,
        bodies: (BodyId, BodyId),
        workspace: &mut Workspace,
        evaluate: impl FnOnce(&PosedPair, usize, &mut Scratch) -> Option<T>,
    ) -> Option<T> {
        workspace.adapt(self.identity, &self.pairs);
        let index = self.pairs.number_of(bodies)?;
        let (robot, scratch) = workspace.place(&self.pairs, q);
        evaluate(&self.pairs.pair(index, robot.frames()), index, scratch)
    }

    /// Upper bound (m) on the change of any distance while joints move between two configurations; infinite where there
    /// is no bound.
    #[must_use]
    pub fn travel(&self, from: &[f64], to: &[f64]) -> f64 {
        self.pairs.robot().displacement_rates().between(from, to)
    }

    /// Checks whether the straight line in joint space between two configurations is free, with default options.
    #[must_use]
    pub fn check_motion(
        &self,
        from: &Configuration,
        to: &Configuration,
        workspace: &mut Workspace,
    ) -> MotionReport {
        let segment = MotionSegment::straight(self.robot(), from, to);
        self.check_motion_with(&segment, &MotionOptions::default(), workspace)
    }

    /// Checks whether a motion is free: the result is proven free, contact, or undecided with a reason.
    #[must_use]
    pub fn check_motion_with(
        &self,
        segment: &MotionSegment,
        options: &MotionOptions,
        workspace: &mut Workspace,
    ) -> MotionReport {
        self.motion_check(options, workspace).check(segment)
    }

    /// Reports on many motions, in their order: the same for any number of threads, unless there is a deadline.
    ///
    /// Runs on the threads of the rayon pool it is called in.
    #[must_use]
    pub fn check_motions(&self, segments: &[MotionSegment], options: &MotionOptions) -> Vec<MotionReport> {
        (segments.par_iter())
            .with_min_len(4)
            .map_init(
                || self.workspace(),
                |workspace, segment| match options.stopped_by() {
                    Some(reason) => MotionReport::not_evaluated(reason),
                    None => self.check_motion_with(segment, options, workspace),
                },
            )
            .collect()
    }

    /// Checks whether a trajectory is free: either all segments are proven free, or the report is on the first that is
    /// not.
    #[must_use]
    pub fn check_trajectory(
        &self,
        trajectory: &Trajectory,
        options: &MotionOptions,
        workspace: &mut Workspace,
    ) -> TrajectoryReport {
        motion::check_trajectory(&mut self.motion_check(options, workspace), trajectory)
    }

    /// As [`Self::check_motion_with`], with the certificate if the motion is free.
    #[must_use]
    pub fn certify_motion(
        &self,
        segment: &MotionSegment,
        options: &MotionOptions,
        workspace: &mut Workspace,
    ) -> (MotionReport, Option<Certificate>) {
        let (report, proofs) = motion::prove_motion(&mut self.motion_check(options, workspace), segment);
        (report, proofs.map(|proofs| self.certificates.certificate(self.subject(), proofs, options)))
    }

    /// As [`Self::check_trajectory`], with the certificate if the trajectory is free.
    #[must_use]
    pub fn certify_trajectory(
        &self,
        trajectory: &Trajectory,
        options: &MotionOptions,
        workspace: &mut Workspace,
    ) -> (TrajectoryReport, Option<Certificate>) {
        let (report, proofs) =
            motion::prove_trajectory(&mut self.motion_check(options, workspace), trajectory);
        (report, proofs.map(|proofs| self.certificates.certificate(self.subject(), proofs, options)))
    }

    pub(crate) fn motion_check<'a>(
        &'a self,
        options: &'a MotionOptions,
        workspace: &'a mut Workspace,
    ) -> MotionCheck<'a> {
        workspace.adapt(self.identity, &self.pairs);
        MotionCheck::new(&self.pairs, options, workspace.motion())
    }

    fn subject(&self) -> CertificateSubject<'_> {
        CertificateSubject { pairs: &self.pairs, settings: &self.settings, matrix: self.matrix.as_ref() }
    }

    /// Time (s) before which no pair can touch, up to `horizon` (s), whatever motion follows within the limits of
    /// `state`. Floating joints must be at rest.
    pub fn look_ahead(
        &self,
        state: LookAheadState,
        horizon: f64,
        workspace: &mut Workspace,
    ) -> Result<LookAhead, SegmentError> {
        workspace.adapt(self.identity, &self.pairs);
        motion::look_ahead(&self.pairs, state, horizon, workspace.motion())
    }

    /// The swept volumes of all links and attached objects with geometry, in intervals of equal length; more intervals
    /// give smaller volumes. Padding is not included. Bodies with a plane, which sweep over everything, have no volume.
    #[must_use]
    pub fn swept_volumes(
        &self,
        segment: &MotionSegment,
        intervals: usize,
        workspace: &mut Workspace,
    ) -> Vec<SweptVolume> {
        workspace.adapt(self.identity, &self.pairs);
        let motion = CheckedMotion { pairs: &self.pairs, segment, margin: 0.0 };
        motion::swept_volumes(motion, intervals, workspace.motion())
    }

    /// The bounding volumes of links and their attached objects, at a given depth below the roots of their hierarchies
    /// ([`CollisionBody::volumes`](clearance_proximity::CollisionBody::volumes)); without padding.
    pub fn link_volumes(&self, level: usize) -> impl Iterator<Item = LinkVolume> {
        robot::link_volumes(self.pairs.robot(), level)
    }

    /// Capsules (root frame) that together contain a body, without padding. The radius of a plane's is infinite.
    #[must_use]
    pub fn bounding_capsules(&self, body: BodyId, poses: &LinkPoses) -> Vec<Reach> {
        if let BodyId::Obstacle(id) = body {
            return vec![self.pairs.world().obstacle(id.0 as usize).reach()];
        }
        let parts = self.pairs.robot().parts().iter().filter(|part| part.id() == body);
        parts.map(|part| robot::bounding_capsule(part, poses)).collect()
    }

    /// Upper bound (m) on the distance of any point of the robot and its attached objects from its root, padding
    /// included.
    #[must_use]
    pub fn extent(&self, poses: &LinkPoses) -> f64 {
        robot::extent(self.pairs.robot(), poses)
    }

    /// Upper bound (m) on [`Self::extent`] in all states in which the positions (m) of sliding joints are in their ranges,
    /// given by the index of the position; infinite where one has no range.
    #[must_use]
    pub fn largest_extent(&self, range_of: impl Fn(usize) -> Option<RangeInclusive<f64>>) -> f64 {
        robot::largest_extent(self.pairs.robot(), range_of)
    }

    /// Number of pairs, over all states, that level 0 passes on to the hierarchies. Runs only kinematics and capsules.
    // public for the benchmark that measures the share of level 0 in every check
    #[doc(hidden)]
    pub fn count_near_pairs(&self, states: &[Configuration], workspace: &mut Workspace) -> u64 {
        workspace.adapt(self.identity, &self.pairs);
        workspace.batch_search(&self.pairs).count_near_pairs(states)
    }

    /// Axis-aligned boxes around the robot's parts with their paddings: the queries of the broad phase.
    // public for the benchmark of the broad phase
    #[doc(hidden)]
    #[must_use]
    pub fn part_boxes(&self, q: &Configuration, workspace: &mut Workspace) -> Vec<AxisBox> {
        workspace.adapt(self.identity, &self.pairs);
        let (robot, _) = workspace.place(&self.pairs, q);
        let capsules = self.pairs.robot().padded_capsules(|body| robot.frame(body));
        capsules.map(|capsule| capsule.axis_box(0.0)).collect()
    }

    /// Content of the broad phase: numbered boxes around obstacles, or around their pieces if the obstacles are large.
    // public for the benchmark of the broad phase
    #[doc(hidden)]
    #[must_use]
    pub fn world_boxes(&self) -> Vec<(u32, AxisBox)> {
        self.pairs.world().obstacles().pieces().boxes()
    }
}
