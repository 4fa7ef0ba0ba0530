"""Counts of paths: found, colliding, confirmed."""

import collections
import sys

import numpy as np

import clearance as cl
from oracle import Oracle
from planners import contestants
from problems import problems

COLLIDING_STEP = 1e-3  # rad, between states of colliding edges
AGREEMENT = 200  # states of each problem
FREE_STEP = 1e-2  # rad, between states of free paths that Coal checks


class Tally:
    def __init__(self):
        self.counts, self.depths, self.lengths = collections.Counter(), [], []

    def row(self, name):
        paths, colliding = self.counts["paths"], self.counts["colliding"]
        deepest, median = (f"{1e3 * f(self.depths):.1f}" if self.depths else "" for f in (max, np.median))
        longest = f"{max(self.lengths):.3f}" if self.lengths else ""
        share = f"{100 * colliding / paths:.1f} %" if paths else ""
        cells = [name, paths, self.counts["none"], colliding, share, median, deepest, longest, self.counts["confirmed"]]
        return "| " + " | ".join(map(str, [*cells, self.counts["undecided"], self.counts["contradicted"]])) + " |"


HEAD = (
    "| planner | paths | no path | colliding | share | median depth (mm) | largest depth (mm) | largest colliding length of a path (rad) "
    "| confirmed by Coal | undecided | contradicted by Coal |\n|---|" + "---:|" * 10
)


def states_of(q0, q1, step):
    count = max(2, int(np.ceil(np.linalg.norm(q1 - q0) / step)) + 1)
    return q0 + np.linspace(0, 1, count)[:, None] * (q1 - q0)


def examine(checker, oracle, path, tally):
    """Counts a path."""
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
    confirmed, depth, length = False, 0.0, 0.0
    for i in np.flatnonzero(edges.verdicts == cl.Verdict.CONTACT):
        ends = path[i], path[i + 1]
        states = states_of(*ends, COLLIDING_STEP)
        hit = ~checker.is_free(states)
        length += hit.sum() * np.linalg.norm(ends[1] - ends[0]) / len(states)
        # where the samples miss it, the contact itself
        colliding = np.concatenate([states[hit], [ends[0] + edges.t[i, 1] * (ends[1] - ends[0])]])
        near = checker.distance(colliding, 0.0, gradients=True)
        signed = np.minimum(near.self_distance, near.world_distance)
        depth = max(depth, -signed.min())
        confirmed = confirmed or oracle.collide(colliding[np.argsort(signed)[:20]]).any()
    tally.counts["confirmed"] += confirmed
    tally.depths.append(depth)
    tally.lengths.append(length)


def check_agreement(problem, oracle):
    """Both libraries have to give the same result for states."""
    states = problem.checker.robot.random(1, AGREEMENT)[:, : len(problem.checker.joint_names)]
    if (problem.checker.is_free(states) == oracle.collide(states)).any():
        sys.exit(f"{problem.name}: clearance and Coal differ on a state")


def measure(arguments):
    """The table of all planners on all problems, and a line about the run."""
    tallies, count, step = collections.defaultdict(Tally), 0, 0.0
    for problem in problems(arguments.shared, arguments.problems):
        count += 1
        oracle = Oracle(problem)
        check_agreement(problem, oracle)
        for planner in contestants(problem):
            tally = tallies[planner.name]
            step = max(step, getattr(planner, "step", 0.0))
            for seed in range(1, arguments.seeds + 1):
                path = planner.plan(seed, arguments.seconds)
                if path is None:
                    tally.counts["none"] += 1
                else:
                    examine(problem.checker, oracle, path, tally)
        found = ", ".join(f"{t.counts['colliding']}/{t.counts['paths']}" for t in tallies.values())
        print(f"{problem.name}: {found}", file=sys.stderr)
    about = f"{count} problems, {arguments.seeds} searches of each planner on each; OMPL's default step is {step:.3f} rad"
    return about, "\n".join([HEAD, *(tally.row(name) for name, tally in tallies.items())])
