"""Counts colliding edges of up to 8 rad that VAMP's `validate_motion` accepts: it checks 8 states of an edge."""

import collections

import numpy as np

import clearance as cl
from vamp_planner import Vamp

LENGTHS = [0.5, 1.0, 2.0, 4.0, 8.0]  # rad, Euclidean norm
EDGES = 200  # of each length and problem
STEP = 1e-2  # rad, between states of a colliding edge that VAMP's spheres and Coal check

HEAD = (
    "| length (rad) | edges valid for `validate_motion` | colliding | share | confirmed by Coal "
    "| a state is invalid for VAMP's spheres |\n|---:|" + "---:|" * 5
)


class LongEdges:
    def __init__(self):
        self._counts = collections.defaultdict(collections.Counter)

    def measure(self, problem, oracle):
        """Counts edges between states that are free for both libraries, on a problem with the fingers of VAMP."""
        planner = Vamp("VAMP", problem)
        for length in LENGTHS:
            q0, q1 = _edges(problem.checker, planner, length)
            valid = [planner.robot.validate_motion(a.tolist(), b.tolist(), planner.environment) for a, b in zip(q0, q1)]
            q0, q1, counts = q0[valid], q1[valid], self._counts[length]
            reports = problem.checker.check_edges(q0, q1)
            counts["valid"] += len(q0)
            for i in np.flatnonzero(reports.verdicts == cl.Verdict.CONTACT):
                # with the contact itself, which the steps may miss
                t = np.append(np.linspace(0, 1, int(length / STEP) + 1), reports.t[i, 1])
                states = q0[i] + t[:, None] * (q1[i] - q0[i])
                counts["colliding"] += 1
                counts["confirmed"] += _collides(problem.checker, oracle, states)
                counts["invalid"] += not all(planner.is_valid(state) for state in states)

    def table(self):
        rows = []
        for length, counts in self._counts.items():
            share = f"{100 * counts['colliding'] / max(counts['valid'], 1):.1f} %"
            cells = [length, counts["valid"], counts["colliding"], share, counts["confirmed"], counts["invalid"]]
            rows.append("| " + " | ".join(map(str, cells)) + " |")
        return "\n".join([HEAD, *rows])


def _collides(checker, oracle, states):
    """Whether one of the deepest colliding states collides for Coal, too."""
    hit = states[~checker.is_free(states)]
    if not len(hit):
        hit = states[-1:]
    near = checker.distance(hit, 0.0, gradients=True)
    signed = np.minimum(near.self_distance, near.world_distance)
    return bool(oracle.collide(hit[np.argsort(signed)[:5]]).any())


def _edges(checker, planner, length):
    """Edges of this length (rad) within the limits, whose ends are free for both libraries."""
    random, firsts, seconds = np.random.default_rng(1), [], []
    lower, upper = checker.lower, checker.upper
    while len(firsts) < EDGES:
        q0 = random.uniform(lower, upper, (4096, len(lower)))
        way = random.normal(size=q0.shape)
        q1 = q0 + length * way / np.linalg.norm(way, axis=1)[:, None]
        inside = ((lower <= q1) & (q1 <= upper)).all(axis=1)
        q0, q1 = q0[inside], q1[inside]
        for i in np.flatnonzero(checker.is_free(q0) & checker.is_free(q1)):
            if planner.is_valid(q0[i]) and planner.is_valid(q1[i]):
                firsts.append(q0[i])
                seconds.append(q1[i])
    return np.array(firsts[:EDGES]), np.array(seconds[:EDGES])
