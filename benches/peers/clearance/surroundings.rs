//! Benchmark queries of a robot in one world, with self-collision checking switched off.

use clearance::{CollisionChecker, Configuration, Question, Settings, Workspace, World};

use crate::Outcome;
use crate::answer::Answer;
use crate::batch_and_stream::batch;

pub struct Surroundings {
    checker: CollisionChecker,
    workspace: Workspace,
}

impl Surroundings {
    /// Among the obstacles of `world`; what `checker` has built of the robot is shared.
    pub fn new(checker: &CollisionChecker, world: &World) -> Outcome<Self> {
        let settings = Settings { check_self: false, ..Settings::default() };
        let checker = checker.with_world(world, settings, None)?;
        Ok(Self { workspace: checker.workspace(), checker })
    }

    pub fn checker(&self) -> &CollisionChecker {
        &self.checker
    }

    /// Asks `question` about every state; false where the library has no call for it.
    pub fn ask(&mut self, question: &str, states: &[Configuration], mut hear: impl FnMut(Answer)) -> bool {
        let Self { checker, workspace } = self;
        match question {
            "free" => states.iter().for_each(|q| hear(Answer::Free(checker.is_free(q, workspace)))),
            "free-batch" => batch(checker, states).into_iter().for_each(|free| hear(Answer::Free(free))),
            "distance" => {
                for q in states {
                    let report = checker.check(q, Question::Distance { limit: f64::INFINITY }, workspace);
                    hear(Answer::Distance(report.nearest.map(|n| n.distance)));
                }
            }
            _ => return false,
        }
        true
    }
}
