"""Data types of the results of a run, for robots and mesh pairs."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from .agreement import Agreement
from .edge_measures import EdgesMeasured
from .race import Timing

# The measures of a whole robot: question, set of states, and what they are called in the report.
MEASURES = {
    ("free", "random"): "State boolean, random states",
    ("free", "free"): "State boolean, collision-free states",
    ("pairs", "random"): "All colliding pairs, random states",
    ("distance", "free"): "Least self distance, collision-free states (exact, cold)",
    ("near", "walk"): "Boolean and least distance within 0.1 m, successive states at 1 kHz",
}

# The buckets of mesh pairs.
GAPS = ("0.1mm", "1mm", "3mm", "10mm", "30mm", "100mm")
TOUCHING = "touching"


@dataclass
class Measured:
    timings: dict[str, Timing]
    agreements: list[Agreement]

    def ratio(self, peer: str, of: str = "clearance") -> float | None:
        """How many times longer the peer takes; by best passes, which disturbances of the machine touch least."""
        if peer not in self.timings or of not in self.timings:
            return None
        return self.timings[peer].best / self.timings[of].best


@dataclass
class RobotResult:
    name: str
    facts: dict[str, str]
    figures: dict[str, str] = field(default_factory=dict)
    measures: dict[tuple[str, str], Measured] = field(default_factory=dict)
    edges: EdgesMeasured = field(default_factory=dict)
    # What certificates cost; empty where the library does not tell.
    certificates: dict[str, str] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)


@dataclass
class MeshPairResult:
    name: str
    facts: dict[str, str]
    # by question and bucket
    measures: dict[tuple[str, str], Measured] = field(default_factory=dict)
    # volume type, question, N_bv, C_bv, N_p, C_p
    costs: list[str] = field(default_factory=list)


@dataclass
class Results:
    robots: list[RobotResult] = field(default_factory=list)
    mesh_pairs: list[MeshPairResult] = field(default_factory=list)
    # What is missing from the edges.
    edge_notes: list[str] = field(default_factory=list)

    def ratios(self, measures: list[tuple[str, str]], peer: str, of: str = "clearance") -> dict[str, float]:
        """The ratio of every robot; of several measures the worst."""
        found: dict[str, float] = {}
        for robot in self.robots:
            each = [robot.measures[m].ratio(peer, of) for m in measures if m in robot.measures]
            known = [ratio for ratio in each if ratio is not None]
            if known:
                found[robot.name] = min(known)
        return found

    def edge_ratios(self, key: str, peer: str) -> dict[tuple[str, float], float]:
        """Of every robot and length."""
        return {
            (robot.name, length): ratio
            for robot in self.robots
            for (measure, length), measured in robot.edges.items()
            if measure == key and (ratio := measured.ratio(peer)) is not None
        }

    def bucket(self, question: str, gap: str, peer: str) -> float | None:
        """Geometric mean over mesh pairs of the peer's ratio."""
        each = [p.measures[question, gap].ratio(peer) for p in self.mesh_pairs if (question, gap) in p.measures]
        return geometric_mean([ratio for ratio in each if ratio is not None])


def geometric_mean(values: list[float]) -> float | None:
    return math.exp(sum(map(math.log, values)) / len(values)) if values else None
