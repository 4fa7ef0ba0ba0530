//! RRT-Connect (J. Kuffner, S. LaValle: RRT-Connect: An efficient approach to single-query path planning, ICRA 2000): two trees grow
//! towards random states and, after each step, towards each other.

use std::time::Instant;

use clearance_checker::{CollisionChecker, MotionOptions, Watch, Workspace};
use clearance_motion::MotionSegment;

use crate::options::PlanOptions;
use crate::plan::{NoPlan, Path, Plan};
use crate::shortcuts;
use crate::space::{Space, between, squared_distance};
use crate::tree::Tree;

/// A search, and the edges that it has checked.
pub struct Search<'s> {
    checker: &'s CollisionChecker,
    space: &'s Space<'s>,
    options: &'s PlanOptions,
    motion: MotionOptions,
    workspace: &'s mut Workspace,
    pub random: fastrand::Rng,
    edges: u64,
}

/// The search ended without a result.
pub struct Over;

impl<'s> Search<'s> {
    pub fn new(
        checker: &'s CollisionChecker,
        space: &'s Space<'s>,
        options: &'s PlanOptions,
        workspace: &'s mut Workspace,
    ) -> Self {
        let motion = MotionOptions {
            tolerance: options.tolerance,
            deadline: options.deadline,
            watch: options.watch.clone(),
            ..MotionOptions::default()
        };
        let random = fastrand::Rng::with_seed(options.seed);
        Self { checker, space, options, motion, workspace, random, edges: 0 }
    }

    pub fn run(mut self) -> Plan {
        let (start, goal) = (self.space.start(), self.space.goal());
        for (end, reason) in [(&start, NoPlan::StartNotFree), (&goal, NoPlan::GoalNotFree)] {
            if !self.checker.is_free(&self.space.state(end), self.workspace) {
                return Plan::NotFound(reason);
            }
        }
        let mut trees = [Tree::new(&start), Tree::new(&goal)];
        let Ok(way) = self.connect(&mut trees) else {
            return Plan::NotFound(self.reason());
        };
        let way = shortcuts::shortened(way, self.options.shortcuts, &mut self);
        let states = way.iter().map(|positions| self.space.state(positions)).collect();
        Plan::Found(Path { states, edges: self.edges, nodes: trees.iter().map(Tree::len).sum() })
    }

    fn reason(&self) -> NoPlan {
        let edges = self.edges;
        if self.is_stopped() {
            NoPlan::Canceled { edges }
        } else if self.is_late() {
            NoPlan::Deadline { edges }
        } else {
            NoPlan::MostEdges { edges }
        }
    }

    fn is_stopped(&self) -> bool {
        self.options.watch.as_ref().is_some_and(Watch::is_stopped)
    }

    fn is_late(&self) -> bool {
        self.options.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Counts an edge; an error if the search is over.
    fn count_edge(&mut self) -> Result<(), Over> {
        if self.edges >= self.options.most_edges || self.is_stopped() || self.is_late() {
            return Err(Over);
        }
        self.edges += 1;
        Ok(())
    }

    /// Whether the line between two states is proven free.
    pub fn is_free(&mut self, from: &[f64], to: &[f64]) -> Result<bool, Over> {
        self.count_edge()?;
        let [from, to] = [from, to].map(|positions| self.space.state(positions));
        let segment = MotionSegment::straight(self.checker.robot(), &from, &to);
        Ok(self.checker.is_motion_free_with(&segment, &self.motion, self.workspace))
    }

    /// Grows both trees until they meet: the states from the start to the goal.
    fn connect(&mut self, trees: &mut [Tree; 2]) -> Result<Vec<Vec<f64>>, Over> {
        if self.is_free(trees[0].state(0), trees[1].state(0))? {
            return Ok(vec![self.space.start(), self.space.goal()]);
        }
        for round in 0_usize.. {
            let (of_start, of_goal) = trees.split_at_mut(1);
            let (growing, other) = if round % 2 == 0 {
                (&mut of_start[0], &mut of_goal[0])
            } else {
                (&mut of_goal[0], &mut of_start[0])
            };
            let sample = self.space.sample(&mut self.random);
            let nearest = growing.nearest(&sample);
            let Some(node) = self.step(growing, nearest, &sample)? else { continue };
            let target = growing.state(node).to_vec();
            if let Some(met) = self.grow_to(other, &target)? {
                let [mut first, mut second] = [growing.way_to_root(node), other.way_to_root(met)];
                if round % 2 == 1 {
                    (first, second) = (second, first);
                }
                first.reverse();
                // both ways have the state where they meet
                first.extend(second.into_iter().skip(1));
                return Ok(first);
            }
        }
        unreachable!("the loop ends only by a result")
    }

    /// Grows a tree straight to a state, as far as the edges are free; the node of the state if it is reached.
    fn grow_to(&mut self, tree: &mut Tree, target: &[f64]) -> Result<Option<usize>, Over> {
        let mut node = tree.nearest(target);
        while tree.state(node) != target {
            match self.step(tree, node, target)? {
                Some(next) => node = next,
                None => return Ok(None),
            }
        }
        Ok(Some(node))
    }

    /// Adds the state towards a target, at most the range away, if the edge to it is free.
    fn step(&mut self, tree: &mut Tree, from: usize, target: &[f64]) -> Result<Option<usize>, Over> {
        let distance = squared_distance(tree.state(from), target).sqrt();
        if distance == 0.0 {
            // nothing is checked, but a search all of whose samples are in the tree has to end
            self.count_edge()?;
            return Ok(None);
        }
        let range = self.options.range;
        let next = if distance <= range {
            target.to_vec()
        } else {
            between(tree.state(from), target, range / distance)
        };
        if !self.is_free(tree.state(from), &next)? {
            return Ok(None);
        }
        Ok(Some(tree.add(&next, from)))
    }
}
