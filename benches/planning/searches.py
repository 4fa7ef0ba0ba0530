"""Times of RRT-Connect by clearance (proven edges) and VAMP (sampled edges), on the same problems. Prints JSON.

Usage: searches.py SHARED PROBLEMS SEEDS.
"""

import json
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "plans")]

import numpy as np

import clearance as cl
from oracle import Oracle
from problems import problems
from vamp_planner import Vamp, problem_of_vamp

SECONDS = 60.0  # limit of a search
STEP = 1e-2  # rad, between states that Coal checks


class Clearance:
    def __init__(self, name, problem, **options):
        self.name, self._problem, self._options = name, problem, options

    @staticmethod
    def random(seed):
        return seed

    def search(self, seed):
        problem = self._problem
        return problem.checker.plan(problem.start, problem.goal, seed=seed, timeout=SECONDS, max_edges=2**40, **self._options).path


def contestants(problem):
    made = [
        Clearance("clearance", problem, shortcuts=0),
        Clearance("clearance, with shortcuts", problem),
        Clearance("clearance, with shortcuts and certificate", problem, certificate=True),
    ]
    # allowed pairs: VAMP has none
    if not problem.allowed_pairs:
        made += [Vamp("VAMP", problem, is_simplified=False), Vamp("VAMP, simplified", problem)]
    return made


def length(path):
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def outcome(problem, oracle, path):
    """`proven`, `refuted` or `undecided`; a path that Coal refutes is refuted, whatever clearance finds."""
    states = [a + np.linspace(0, 1, max(2, int(np.linalg.norm(b - a) / STEP) + 1))[:, None] * (b - a) for a, b in zip(path, path[1:])]
    if oracle.collide(np.concatenate(states)).any():
        return "refuted"
    verdict = problem.checker.check_trajectory(None, path).verdict
    return {cl.Verdict.FREE: "proven", cl.Verdict.CONTACT: "refuted"}.get(verdict, "undecided")


def search(planner, seed, problem, oracle):
    random = planner.random(seed)
    begins = time.process_time(), time.perf_counter()
    path = planner.search(random)
    cpu, wall = time.process_time() - begins[0], time.perf_counter() - begins[1]
    found = dict(planner=planner.name, problem=problem.name, scene=problem.scene, seed=seed, cpu=cpu, wall=wall, outcome="none")
    if path is not None:
        found |= dict(length=length(path), outcome=outcome(problem, oracle, path))
    return found


def main():
    shared, count, seeds = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    found = []
    for given in problems(shared, count):
        # the fingers of VAMP's Panda for all planners
        problem = problem_of_vamp(given) or given
        oracle, planners = Oracle(problem), contestants(problem)
        planners[0].search(1)
        # in turn, so that all meet the same machine
        found += [search(planner, seed, problem, oracle) for seed in range(1, seeds + 1) for planner in planners]
    print(json.dumps(found))


if __name__ == "__main__":
    main()
