//! List of the pairs to check, with the reason for each pair that is skipped.

use std::collections::HashSet;
use std::sync::Arc;

use super::{AllowedCollisionMatrix, AttachedId, BodyId, ObstacleId, World};
use clearance_robot::{LinkId, RobotModel};

/// The pairs to check, and the number of skipped pairs by reason.
///
/// The robot's parts are its links and attached objects. Pairs of them are stored as a list. Pairs of a part with an obstacle are stored
/// as a table, so that an obstacle can be added or removed without changes to the others.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PairList {
    /// Parts that have geometry.
    parts: Vec<Part>,
    self_pairs: Vec<(BodyId, BodyId)>,
    /// By place of an obstacle: for each part, whether the pair is checked. `None` at gaps.
    checked: Vec<Option<Arc<[bool]>>>,
    /// For obstacles without an entry in the matrix.
    usual: Arc<[bool]>,
    world_count: usize,
    skipped: [usize; SkipReason::ALL.len()],
    rules: PairRules,
    /// Names of all links: entries of the matrix about such a name hold for the link alone.
    link_names: Arc<HashSet<String>>,
    checks_world: bool,
}

/// Source of the decision which pairs are skipped; the first of these that exists is used.
#[derive(Clone, Debug, Default, PartialEq)]
enum PairRules {
    /// The allowed collision matrix of a planning scene.
    Scene(AllowedCollisionMatrix),
    /// The matrix that the SRDF describes.
    Srdf(AllowedCollisionMatrix),
    /// Adjacency of rigid bodies.
    #[default]
    Adjacency,
}

impl PairRules {
    fn new(robot: &RobotModel, scene: Option<&AllowedCollisionMatrix>) -> Self {
        match (scene, robot.srdf()) {
            (Some(scene), _) => Self::Scene(scene.clone()),
            (None, Some(_)) => Self::Srdf(AllowedCollisionMatrix::from_srdf(robot)),
            (None, None) => Self::Adjacency,
        }
    }

    fn matrix(&self) -> Option<&AllowedCollisionMatrix> {
        match self {
            Self::Scene(matrix) | Self::Srdf(matrix) => Some(matrix),
            Self::Adjacency => None,
        }
    }

    /// The reason why the matrix allows contact of two parts, if it allows it.
    fn why_allowed(&self, a: &Part, b: &Part) -> Option<SkipReason> {
        let matrix = self.matrix()?;
        let (allows, has_entry) = match (&a.entry_name, &b.entry_name) {
            (Some(a), Some(b)) => (matrix.allows(a, b), matrix.has_entry(a, b)),
            (Some(one), None) | (None, Some(one)) => (matrix.allows_by_default(one), false),
            (None, None) => (false, false),
        };
        allows.then_some(match self {
            Self::Srdf(_) if has_entry => SkipReason::Disabled,
            Self::Srdf(_) => SkipReason::DisabledByDefault,
            Self::Scene(_) | Self::Adjacency => SkipReason::Allowed,
        })
    }

    /// The reason why pairs with an obstacle are skipped: the SRDF has no entries for obstacles, only defaults of links.
    fn world_reason(&self) -> SkipReason {
        match self {
            Self::Srdf(_) => SkipReason::DisabledByDefault,
            Self::Scene(_) | Self::Adjacency => SkipReason::Allowed,
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
struct Part {
    body: BodyId,
    /// Its name in the matrix; `None` for an object with the name of a link.
    entry_name: Option<String>,
}

/// Reason why a pair is skipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkipReason {
    /// The links are joined by fixed joints only, or the links that carry the two objects are.
    SameRigidBody,
    /// The links' rigid bodies are joined by one moving joint, and there is no SRDF that decides otherwise.
    Adjacent,
    /// The SRDF disables the pair.
    Disabled,
    /// The SRDF disables collisions of one of the bodies with every body that it does not enable.
    DisabledByDefault,
    /// The planning scene's allowed collision matrix allows contact.
    Allowed,
    /// The link carries the attached object, or is one of its touch links.
    Touches,
}

impl SkipReason {
    /// All reasons, in the order of their numbers.
    pub const ALL: [Self; 6] = [
        Self::SameRigidBody,
        Self::Adjacent,
        Self::Disabled,
        Self::DisabledByDefault,
        Self::Allowed,
        Self::Touches,
    ];
}

impl std::fmt::Display for SkipReason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::SameRigidBody => "same rigid body",
            Self::Adjacent => "adjacent rigid bodies (no SRDF)",
            Self::Disabled => "disabled by the SRDF",
            Self::DisabledByDefault => "disabled by the SRDF's disable_default_collisions",
            Self::Allowed => "allowed by the collision matrix",
            Self::Touches => "may touch the attached object",
        })
    }
}

impl PairList {
    /// Pairs of links and attached objects that have geometry, and their pairs with obstacles.
    ///
    /// A scene's matrix replaces the SRDF's, as in MoveIt; without either, adjacent rigid bodies are skipped. Default entries of either
    /// matrix hold for links, attached objects and obstacles alike. An entry about the name of a link does not hold for an object with this
    /// name. Attached objects are checked against all links except those that may
    /// touch them, and against each other unless one link carries both.
    #[must_use]
    pub fn new(robot: &RobotModel, world: &World, scene: Option<&AllowedCollisionMatrix>) -> Self {
        let links = robot.link_ids().filter(|l| !robot.link(*l).collisions.is_empty());
        let links =
            links.map(|l| Part { body: BodyId::Link(l), entry_name: Some(robot.link(l).name.clone()) });
        let link_names: HashSet<String> = robot.links().iter().map(|link| link.name.clone()).collect();
        let attached = (0..).map(AttachedId).zip(world.attached());
        let attached = attached.map(|(id, object)| {
            let entry_name = Some(&object.name).filter(|name| !link_names.contains(*name)).cloned();
            Part { body: BodyId::Attached(id), entry_name }
        });
        let parts: Vec<Part> = links.chain(attached).collect();
        let rules = PairRules::new(robot, scene);
        let usual = (parts.iter())
            .map(|part| {
                let name = part.entry_name.as_deref();
                !rules.matrix().zip(name).is_some_and(|(matrix, name)| matrix.allows_by_default(name))
            })
            .collect();
        let link_names = Arc::new(link_names);
        let mut list = Self { parts, usual, rules, link_names, checks_world: true, ..Self::default() };
        list.add_self_pairs(robot, world);
        for id in (0..).map(ObstacleId).take(world.place_count()) {
            list.set_obstacle(id, world.place(id).map(|obstacle| obstacle.name.as_str()));
        }
        list
    }

    fn add_self_pairs(&mut self, robot: &RobotModel, world: &World) {
        for (i, a) in self.parts.iter().enumerate() {
            for b in &self.parts[i + 1..] {
                match why_skipped(robot, world, [a, b], &self.rules) {
                    Some(reason) => self.skipped[reason as usize] += 1,
                    None => self.self_pairs.push((a.body, b.body)),
                }
            }
        }
    }

    /// Updates the table for the obstacle of this name at a place, or for an empty place.
    pub fn set_obstacle(&mut self, id: ObstacleId, name: Option<&str>) {
        let place = id.0 as usize;
        if self.checked.len() <= place {
            self.checked.resize(place + 1, None);
        }
        let reason = self.rules.world_reason() as usize;
        if let Some(before) = self.checked[place].take() {
            let checked = before.iter().filter(|checked| **checked).count();
            self.world_count -= checked;
            self.skipped[reason] -= before.len() - checked;
        }
        if !self.checks_world {
            return;
        }
        let Some(name) = name else { return };
        let is_meant =
            |matrix: &&AllowedCollisionMatrix| matrix.mentions(name) && !self.link_names.contains(name);
        let row = match self.rules.matrix().filter(is_meant) {
            Some(matrix) => {
                let allows = |part: &Part| match &part.entry_name {
                    Some(of_part) => matrix.allows(of_part, name),
                    None => matrix.allows_by_default(name),
                };
                self.parts.iter().map(|part| !allows(part)).collect()
            }
            None => Arc::clone(&self.usual),
        };
        let checked = row.iter().filter(|checked| **checked).count();
        self.world_count += checked;
        self.skipped[reason] += row.len() - checked;
        self.checked[place] = Some(row);
    }

    /// Pairs of links and attached objects that must be checked.
    #[must_use]
    pub fn self_pairs(&self) -> &[(BodyId, BodyId)] {
        &self.self_pairs
    }

    /// Pairs of links, without attached objects.
    pub fn link_pairs(&self) -> impl Iterator<Item = (LinkId, LinkId)> {
        self.self_pairs.iter().filter_map(|pair| match *pair {
            (BodyId::Link(a), BodyId::Link(b)) => Some((a, b)),
            _ => None,
        })
    }

    /// Pairs of a robot part and an obstacle, the part first.
    pub fn world_pairs(&self) -> impl Iterator<Item = (BodyId, ObstacleId)> {
        self.parts.iter().enumerate().flat_map(move |(i, part)| {
            let rows = (0..).map(ObstacleId).zip(&self.checked);
            rows.filter(move |(_, row)| row.as_ref().is_some_and(|row| row[i]))
                .map(move |(id, _)| (part.body, id))
        })
    }

    /// Links and attached objects that have geometry.
    pub fn parts(&self) -> impl Iterator<Item = BodyId> {
        self.parts.iter().map(|part| part.body)
    }

    /// True if a part, by its index among those with geometry, is checked against an obstacle.
    #[inline]
    pub fn checks(&self, part: usize, obstacle: ObstacleId) -> bool {
        self.checked.get(obstacle.0 as usize).is_some_and(|row| row.as_ref().is_some_and(|row| row[part]))
    }

    /// Number of pairs that are checked.
    #[must_use]
    pub fn len(&self) -> usize {
        self.self_pairs.len() + self.world_count
    }

    /// True if there is no pair to check.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of pairs of a part and an obstacle that are checked.
    #[must_use]
    pub fn world_len(&self) -> usize {
        self.world_count
    }

    /// The reasons for skipped pairs, with the number of pairs for each reason that occurs.
    pub fn skipped(&self) -> impl Iterator<Item = (SkipReason, usize)> {
        (SkipReason::ALL.into_iter().zip(self.skipped)).filter(|(_, count)| *count > 0)
    }

    /// Skips all pairs of parts, or all pairs with obstacles.
    pub fn restricted(mut self, check_self: bool, check_world: bool) -> Self {
        if !check_self {
            self.self_pairs.clear();
        }
        if !check_world {
            self.checks_world = false;
            self.world_count = 0;
            self.checked.fill(None);
        }
        self
    }
}

/// The reason why two parts are not checked, if there is one.
fn why_skipped(robot: &RobotModel, world: &World, pair: [&Part; 2], rules: &PairRules) -> Option<SkipReason> {
    let [a, b] = pair;
    let allowed = || rules.why_allowed(a, b);
    match (a.body, b.body) {
        (BodyId::Link(link_a), BodyId::Link(link_b)) => {
            if robot.same_rigid_body(link_a, link_b) {
                return Some(SkipReason::SameRigidBody);
            }
            match rules {
                PairRules::Adjacency => {
                    robot.adjacent_rigid_bodies(link_a, link_b).then_some(SkipReason::Adjacent)
                }
                PairRules::Scene(_) | PairRules::Srdf(_) => allowed(),
            }
        }
        (BodyId::Attached(id), BodyId::Attached(other)) => {
            let same = world.attached_object(id).link == world.attached_object(other).link;
            if same { Some(SkipReason::SameRigidBody) } else { allowed() }
        }
        (BodyId::Link(link), BodyId::Attached(id)) => {
            let may_touch = world.attached_object(id).may_touch(&robot.link(link).name);
            if may_touch { Some(SkipReason::Touches) } else { allowed() }
        }
        _ => None,
    }
}
