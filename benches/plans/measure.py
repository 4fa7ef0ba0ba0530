"""Plans with each planner, and counts the paths that are found, colliding, and confirmed as colliding by Coal."""

import collections
import sys

import numpy as np

import clearance as cl
from long_edges import LongEdges
from oracle import Oracle
from planners import contestants
from problems import problems
from vamp_planner import Vamp, problem_of_vamp

COLLIDING_STEP = 1e-3  # rad, between states of colliding edges
AGREEMENT = 200  # states of each problem
FREE_STEP = 1e-2  # rad, between states of free paths that Coal checks


class Tally:
    def __init__(self):
        self.counts, self.depths, self.lengths = collections.Counter(), [], []
        self.has_own_model = False

    def row(self, name):
        paths, colliding = self.counts["paths"], self.counts["colliding"]
        deepest, median = (f"{1e3 * f(self.depths):.1f}" if self.depths else "" for f in (max, np.median))
        longest = f"{max(self.lengths):.3f}" if self.lengths else ""
        share = f"{100 * colliding / paths:.1f} %" if paths else ""
        cells = [name, paths, self.counts["none"], colliding, share, median, deepest, longest, self.counts["confirmed"]]
        cells += [self.counts["undecided"], self.counts["contradicted"], self.counts["valid"] if self.has_own_model else ""]
        return "| " + " | ".join(map(str, cells)) + " |"


HEAD = (
    "| planner | paths | no path | colliding | share | median depth (mm) | largest depth (mm) | largest colliding length of a path (rad) "
    "| confirmed by Coal | undecided | contradicted by Coal | valid for the planner's own model |\n|---|" + "---:|" * 11
)


def states_of(q0, q1, step):
    count = max(2, int(np.ceil(np.linalg.norm(q1 - q0) / step)) + 1)
    return q0 + np.linspace(0, 1, count)[:, None] * (q1 - q0)


def examine(checker, oracle, path, tally, is_valid=None):
    """Counts a path. `is_valid` checks a state with the planner's own model of the robot, if it has one."""
    tally.counts["paths"] += 1
    report = checker.check_trajectory(None, path)
    if report.verdict == cl.Verdict.FREE:
        states = np.concatenate([states_of(*ends, FREE_STEP) for ends in zip(path, path[1:])])
        tally.counts["contradicted"] += bool(oracle.collide(states).any())
        return
    if report.verdict == cl.Verdict.UNDECIDED:
        tally.counts["undecided"] += 1
        return
    tally.counts["colliding"] += 1
    edges = checker.check_edges(path[:-1], path[1:])
    confirmed, depth, length, deepest = False, -np.inf, 0.0, None
    for i in np.flatnonzero(edges.verdicts == cl.Verdict.CONTACT):
        ends = path[i], path[i + 1]
        states = states_of(*ends, COLLIDING_STEP)
        hit = ~checker.is_free(states)
        length += hit.sum() * np.linalg.norm(ends[1] - ends[0]) / len(states)
        # where the samples miss it, the contact itself
        colliding = np.concatenate([states[hit], [ends[0] + edges.t[i, 1] * (ends[1] - ends[0])]])
        near = checker.distance(colliding, 0.0, gradients=True)
        signed = np.minimum(near.self_distance, near.world_distance)
        if -signed.min() > depth:
            depth, deepest = -signed.min(), colliding[signed.argmin()]
        confirmed = confirmed or oracle.collide(colliding[np.argsort(signed)[:20]]).any()
    tally.counts["confirmed"] += confirmed
    if is_valid is not None and deepest is not None:
        tally.counts["valid"] += is_valid(deepest)
    tally.depths.append(max(depth, 0.0))
    tally.lengths.append(length)


def check_agreement(problem, oracle):
    """Both libraries have to give the same result for states."""
    states = problem.checker.robot.random(1, AGREEMENT)[:, : len(problem.checker.joint_names)]
    if (problem.checker.is_free(states) == oracle.collide(states)).any():
        sys.exit(f"{problem.name}: clearance and Coal differ on a state")


class Measurement:
    def __init__(self, arguments):
        self._arguments, self._tallies, self._edges = arguments, collections.defaultdict(Tally), LongEdges()
        self._problems, self._step = 0, 0.0

    def run(self):
        """The tables of all planners and of long edges on all problems, and a line about the run."""
        for problem in problems(self._arguments.shared, self._arguments.problems):
            self._problems += 1
            oracle = self._oracle(problem)
            for planner in contestants(problem):
                self._step = max(self._step, getattr(planner, "step", 0.0))
                self._search(planner, problem, oracle)
            self._measure_vamp(problem_of_vamp(problem))
            found = ", ".join(f"{t.counts['colliding']}/{t.counts['paths']}" for t in self._tallies.values())
            print(f"{problem.name}: {found}", file=sys.stderr)
        about = (
            f"{self._problems} problems, {self._arguments.seeds} searches of each planner on each; "
            f"OMPL's default step is {self._step:.3f} rad"
        )
        rows = [tally.row(name) for name, tally in self._tallies.items()]
        return about, "\n".join([HEAD, *rows, "", self._edges.table()])

    def _measure_vamp(self, problem):
        if problem is None:
            return
        oracle = self._oracle(problem)
        for planner in Vamp("VAMP, default", problem), Vamp("VAMP, default, not simplified", problem, is_simplified=False):
            self._search(planner, problem, oracle)
        self._edges.measure(problem, oracle)

    def _oracle(self, problem):
        oracle = Oracle(problem)
        check_agreement(problem, oracle)
        return oracle

    def _search(self, planner, problem, oracle):
        tally, is_valid = self._tallies[planner.name], getattr(planner, "is_valid", None)
        tally.has_own_model = is_valid is not None
        for seed in range(1, self._arguments.seeds + 1):
            path = planner.plan(seed, self._arguments.seconds)
            if path is None:
                tally.counts["none"] += 1
            else:
                examine(problem.checker, oracle, path, tally, is_valid)
