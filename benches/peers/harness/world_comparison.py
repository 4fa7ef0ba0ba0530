"""Runs the benchmarks of one robot among obstacles on all contestants, without self-collision."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

from .agreement import compare
from .contestant_process import Child, Failed
from .race import Timing, Voice, race
from .results import Measured
from .subjects import RobotSource
from .world_results import CUBES, GROWTH, WorldResult, WorldsResult
from .world_sets import WorldSource, against_truth, worlds_of

# More obstacles than these take milliseconds a state from Pinocchio's list.
MOST_LISTED = 100


@dataclass(frozen=True)
class Extent:
    distance_states: int
    rounds: int
    patience: float
    seed: int


class WorldComparison:
    def __init__(self, clearance: Child, peers: dict[str, Child], extent: Extent, folder: Path) -> None:
        self.clearance, self.peers, self.extent = clearance, peers, extent
        self._file = folder / "world"

    def measure(self, robot: RobotSource, states: int) -> WorldsResult:
        """Of a robot that all have loaded, about so many random states."""
        result = WorldsResult(robot.name)
        for source in worlds_of(robot):
            print(f"  among {source.name}", file=sys.stderr)
            result.worlds.append(self._world(source, states, result))
        result.growth = self._growth(states)
        return result

    def _world(self, source: WorldSource, states: int, result: WorldsResult) -> WorldResult:
        seed = self.extent.seed
        words = ["world", source.file] if source.file else ["scatter", source.count, seed]
        facts = dict(word.split("=", 1) for word in self.clearance.ask(*words, self._file) or [])
        world = WorldResult(source.kind, source.name, facts)
        known = {}
        for name, child in self.peers.items():
            try:
                if child.ask("world", self._file) is not None:
                    known[name] = child
            except Failed as failure:
                result.problems.append(f"{source.name}: {failure}")
        responses = self.clearance.ask("answers", "free-world", "random") or []
        world.free = responses.count("1") / max(1, len(responses))
        short = int(facts["objects"]) <= MOST_LISTED
        voices = self._voices(source.kind, known, short)
        world.measures["free"] = self._measured(voices, "free", states)
        world.cubes = compare([voice for voice in voices if voice.name in CUBES], "free", f"random:{states}")
        if source.kind == "mesh":
            count = min(states, self.extent.distance_states)
            world.measures["distance"] = self._measured(self._distance_voices(known), "distance", count)
        if source.truth:
            for question in world.measures:
                reported = responses if question == "free" else self._responses("distance-world")
                world.truth[question] = against_truth(reported, question, source.truth)
        if source.kind == "cloud":
            world.latencies = [float(word) for word in self.clearance.ask("latency") or []]
        return world

    def _responses(self, question: str) -> list[str]:
        return self.clearance.ask("answers", question, "random") or []

    def _voices(self, kind: str, known: dict[str, Child], short: bool) -> list[Voice]:
        own = [
            Voice("clearance", self.clearance, "-world"),
            Voice("clearance_batch", self.clearance, "-world-batch"),
        ]
        manners = {"tree": "-world-tree", "list": "-world-list"}
        if kind == "cloud":
            own.append(Voice("clearance_cubes", self.clearance, "-cubes"))
            peers = [("coal_cpp", "tree", "-world-tree"), ("coal_cpp", "octree", "-world-octree")]
            peers += [("fcl_cpp", "tree", "-world-tree"), ("fcl_cpp", "octree", "-world-octree")]
            peers.append(("pinocchio_coal", "octree", "-world-list"))
        else:
            peers = [(name, way, manner) for name in known for way, manner in manners.items()]
            peers = [peer for peer in peers if short or peer[:2] != ("pinocchio_coal", "list")]
            peers = [peer for peer in peers if peer[:2] != ("fcl_cpp", "list")]
        return own + [Voice(f"{name}_{way}", known[name], manner) for name, way, manner in peers if name in known]

    def _distance_voices(self, known: dict[str, Child]) -> list[Voice]:
        ways = [("coal_cpp", "tree"), ("coal_cpp", "list"), ("fcl_cpp", "tree"), ("pinocchio_coal", "list")]
        own = Voice("clearance", self.clearance, "-world")
        return [own] + [Voice(f"{name}_{way}", known[name], f"-world-{way}") for name, way in ways if name in known]

    def _measured(self, voices: list[Voice], question: str, count: int) -> Measured:
        some, extent = f"random:{count}", self.extent
        agreements = compare(voices, question, some)
        return Measured(race(voices, question, some, count, extent.rounds, extent.patience), agreements)

    def _growth(self, states: int) -> dict[str, Timing]:
        """What a state costs among ever more obstacles; empty where the answers are not the same."""
        self.clearance.ask("growth", self.extent.seed)
        voices = [Voice(str(count), self.clearance, f"-growth-{count}") for count in GROWTH]
        if any(agreement.different for agreement in compare(voices, "free", f"random:{states}")):
            raise Failed("what is out of the robot's reach has changed answers")
        return race(voices, "free", f"random:{states}", states, self.extent.rounds, self.extent.patience)
