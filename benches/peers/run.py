#!/usr/bin/env python3
"""Main program: benchmarks this library against Coal, Pinocchio, FCL and Tesseract; writes docs/benchmarks.md."""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from pathlib import Path

from harness import costs_report, environment, report, subjects, world_report
from harness.agreement import compare
from harness.contestant_process import Child, Failed
from harness.edge_comparison import MOST_CAST_PAIRS, MOST_FCL_PAIRS, EdgeComparison, Extent
from harness.edge_sets import name_of
from harness.race import Voice, race
from harness.results import GAPS, MEASURES, TOUCHING, Measured, MeshPairResult, Results, RobotResult
from harness.world_comparison import Extent as WorldExtent
from harness.world_comparison import WorldComparison
from harness.world_results import WorldsResult

# The edges whose certificates are made and verified.
CERTIFIED = name_of("free", 1.0)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", help="names, separated by commas; 'none' for none (default: all)")
    parser.add_argument("--pairs", type=int, help="how many pairs of meshes (default: all)")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--states", type=int, default=500, help="states drawn where no file gives them")
    parser.add_argument("--distance-states", type=int, default=200, help="of the free ones")
    parser.add_argument("--walk", type=int, default=1000, help="steps of the walk")
    parser.add_argument("--edges", type=int, default=20, help="edges of a robot and length; 0: none")
    parser.add_argument("--few-edges", type=int, default=5, help="of those, for continuous checks")
    parser.add_argument("--edges-only", action="store_true", help="no states, and no pairs of meshes")
    parser.add_argument("--worlds-only", action="store_true", help="robots among obstacles; writes that section alone")
    parser.add_argument("--costs-only", action="store_true", help="the cost of each volume; writes that section alone")
    parser.add_argument("--world-distance-states", type=int, default=100, help="of the random ones, against a mesh")
    parser.add_argument("--poses", type=int, default=50, help="poses of a pair of meshes and gap")
    parser.add_argument("--patience", type=float, default=30, help="seconds for one contestant and measure")
    parser.add_argument("--core", type=int, default=max(os.sched_getaffinity(0)))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=environment.ROOT / "docs/benchmarks.md")
    return parser.parse_args()


class Comparison:
    """The contestants' processes, and what they are asked one subject after the other."""

    def __init__(self, options: argparse.Namespace, made: environment.Environment, folder: Path) -> None:
        self.options, self.made, self.folder = options, made, folder
        self.among: list[WorldsResult] = []
        self.contestants = contestants = environment.PEERS / "contestants"
        self.clearance = Child("clearance", [made.clearance, "serve"])
        self.coal = Child("coal_cpp", [made.coal])
        self.pinocchio = Child("pinocchio_coal", [made.python, contestants / "pinocchio_coal.py"])
        self.fcl_cpp = Child("fcl_cpp", [made.fcl]) if made.fcl else None
        self.fcl = Child("python_fcl", [made.python, contestants / "python_fcl.py"])
        self.own = [
            Voice("clearance", self.clearance),
            Voice("clearance_batch", self.clearance, "-batch"),
            Voice("clearance_stream", self.clearance, "-stream"),
        ]

    def close(self) -> None:
        for child in (self.clearance, self.coal, self.pinocchio, self.fcl, self.fcl_cpp):
            if child:
                child.close()

    def robot(self, source: subjects.RobotSource) -> RobotResult:
        options, neutral = self.options, self.folder / "neutral"
        files = [source.urdf, source.srdf, source.package_root, source.random_states, source.free_states]
        words = [path if path else "-" for path in files]
        facts = self.clearance.ask("robot", *words, options.seed, options.states, options.walk, neutral)
        result = RobotResult(source.name, _facts(facts))
        if not options.worlds_only:
            result.figures = _facts(self.clearance.ask("figures"))
        urdf = self.folder / "absolute.urdf"
        subjects.with_absolute_meshes(source, urdf)
        voices = list(self.own)
        peers = [self.coal, self.pinocchio] + ([self.fcl] if source.small and not options.worlds_only else [])
        for peer in peers:
            try:
                peer.ask("load", neutral, urdf)
                voices.append(Voice(peer.name, peer))
            except Failed as failure:
                result.problems.append(str(failure))
        loaded = {voice.name: voice.child for voice in voices if voice.child in (self.coal, self.pinocchio)}
        if not options.edges_only:
            among = dict(loaded)
            if self.fcl_cpp:
                self.fcl_cpp.ask("load", neutral)
                among[self.fcl_cpp.name] = self.fcl_cpp
            self._worlds(source, result, among)
        if options.worlds_only:
            return result
        if options.edges:
            self._edges(result, loaded)
        for question, states in MEASURES if not options.edges_only else ():
            count = int(result.facts[states])
            if question == "distance":
                count = min(count, options.distance_states)
            if count:
                some = f"{states}:{count}"
                result.measures[question, states] = self._measure(voices, question, some, count)
        return result

    def _worlds(self, source: subjects.RobotSource, result: RobotResult, loaded: dict[str, Child]) -> None:
        options = self.options
        extent = WorldExtent(options.world_distance_states, options.rounds, options.patience, options.seed)
        comparison = WorldComparison(self.clearance, loaded, extent, self.folder)
        self.among.append(comparison.measure(source, int(result.facts["random"])))
        self.among[-1].problems += result.problems

    def _edges(self, result: RobotResult, loaded: dict[str, Child]) -> None:
        if self.coal.name not in loaded:  # nobody to judge
            return
        options, made, contestants = self.options, self.made, self.contestants
        extent = Extent(options.edges, options.few_edges, options.rounds, options.patience, options.seed)
        edges = EdgeComparison(self.clearance, loaded, extent, self.folder / "neutral", self.folder / "edges")
        pairs = int(result.facts["pairs"])
        if pairs <= MOST_FCL_PAIRS:
            edges.start(Child("python_fcl", [made.python, contestants / "python_fcl.py"]))
        if made.tesseract and pairs <= MOST_CAST_PAIRS:
            edges.start(Child("tesseract_cast", [made.tesseract, contestants / "tesseract_cast.py"]))
        result.edges = edges.measure()
        edges.close()
        result.problems += edges.problems
        if CERTIFIED in edges.counts:
            result.certificates = _facts(self.clearance.ask("certificates", CERTIFIED))

    def mesh_pair(self, source: subjects.MeshPairSource) -> MeshPairResult:
        options, neutral = self.options, self.folder / "neutral"
        facts = self.clearance.ask("meshes", source.a, source.b, options.seed, options.poses, neutral)
        result = MeshPairResult(source.name, _facts(facts))
        self.coal.ask("load", neutral)
        result.costs = self.clearance.ask("costs") or []
        voices = [
            Voice("clearance", self.clearance),
            Voice("coal_cpp", self.coal),
            Voice("coal_cpp_bare", self.coal, "-bare"),
        ]
        for question, buckets in (("free", (TOUCHING, *GAPS)), ("distance", GAPS)):
            for bucket in buckets:
                if count := int(result.facts[bucket]):
                    result.measures[question, bucket] = self._measure(voices, question, bucket, count)
        return result

    def _measure(self, voices: list[Voice], question: str, states: str, count: int) -> Measured:
        options = self.options
        agreements = compare(voices, question, states)
        return Measured(race(voices, question, states, count, options.rounds, options.patience), agreements)


def costs_alone(sources: list[subjects.MeshPairSource], options: argparse.Namespace) -> list[MeshPairResult]:
    """Needs no other contestant than this library."""
    clearance = Child("clearance", [environment.clearance(), "serve"])
    os.sched_setaffinity(clearance.pid, {options.core})
    results = []
    with tempfile.TemporaryDirectory() as folder:
        for source in sources:
            print(f"meshes {source.name}", file=sys.stderr)
            neutral = Path(folder) / "neutral"
            facts = clearance.ask("meshes", source.a, source.b, options.seed, options.poses, neutral)
            results.append(MeshPairResult(source.name, _facts(facts), costs=clearance.ask("costs") or []))
    clearance.close()
    return results


def write_costs(found: subjects.Subjects, options: argparse.Namespace) -> int:
    try:
        measured = costs_alone(found.mesh_pairs[: options.pairs], options)
    except (Failed, environment.MissingTool) as failure:
        print(f"peers: {failure}", file=sys.stderr)
        return 1
    before = options.out.read_text() if options.out.exists() else ""
    section = report.costs_alone(measured, environment.commit(), options.poses, options.core)
    options.out.write_text(costs_report.put(before, section))
    print(f"wrote {options.out}", file=sys.stderr)
    return 0


def _facts(words: list[str] | None) -> dict[str, str]:
    return dict(word.split("=", 1) for word in words or [])


def chosen(found: subjects.Subjects, names: str | None) -> list[subjects.RobotSource]:
    if names == "none":
        return []
    known = {robot.name: robot for robot in found.robots}
    wanted = names.split(",") if names else list(known)
    if unknown := [name for name in wanted if name not in known]:
        raise SystemExit(f"peers: no robot {', '.join(unknown)}; there are {', '.join(known)}")
    return [known[name] for name in wanted]


def main() -> int:
    options = arguments()
    found = subjects.find(environment.ROOT)
    robots = chosen(found, options.robots)
    if found.note:
        print(f"peers: {found.note}", file=sys.stderr)
    if options.costs_only:
        return write_costs(found, options)
    try:
        made = environment.prepare()
    except environment.MissingTool as missing:
        print(f"peers: {missing}", file=sys.stderr)
        return 2
    os.sched_setaffinity(0, {options.core})  # the children inherit it; this process sleeps while they work
    results = Results(edge_notes=made.notes)
    with tempfile.TemporaryDirectory() as folder:
        comparison = Comparison(options, made, Path(folder))
        try:
            for robot in robots:
                print(f"robot {robot.name}", file=sys.stderr)
                results.robots.append(comparison.robot(robot))
            for pair in found.mesh_pairs[: 0 if options.edges_only or options.worlds_only else options.pairs]:
                print(f"meshes {pair.name}", file=sys.stderr)
                results.mesh_pairs.append(comparison.mesh_pair(pair))
        except Failed as failure:
            print(f"peers: {failure}", file=sys.stderr)
            return 1
        comparison.close()
    options.out.parent.mkdir(parents=True, exist_ok=True)
    among = comparison.among
    if options.worlds_only:
        section = report.worlds_alone(among, made.versions, options.rounds, options.core)
        before = options.out.read_text() if options.out.exists() else ""
        options.out.write_text(world_report.put(before, section))
    else:
        text = report.markdown(results, among, made.versions, options.rounds, options.core, found.note)
        options.out.write_text(text)
    print(f"wrote {options.out}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
