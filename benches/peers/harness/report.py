"""Composes `docs/benchmarks.md` from the results: tables of times, conditions, requirements and disagreements."""

from __future__ import annotations

import datetime
import os
import subprocess

from .agreement import DISTANCE_TOLERANCE
from .costs_report import costs
from .edge_measures import EDGE_VOICES
from .edge_report import edges
from .markdown import microseconds, table
from .requirements import requirements
from .results import GAPS, MEASURES, TOUCHING, Measured, MeshPairResult, RobotResult, Results
from .world_report import worlds
from .world_results import WorldsResult

VOICES = {
    "clearance": "this library, one call a state",
    "clearance_batch": "this library, all states in one call, one thread",
    "clearance_stream": "this library, each state helped by the one before",
    "coal_cpp": "Coal from C++, as a careful programmer drives it",
    "coal_cpp_bare": "Coal's own query of two meshes, without a sphere test before it",
    "pinocchio_coal": "Pinocchio with Coal, as Python users run it",
    "python_fcl": "FCL through python-fcl; its transforms are given, their kinematics not timed",
}


def markdown(
    results: Results, among: list[WorldsResult], versions: dict[str, str], rounds: int, core: int, note: str
) -> str:
    parts = [
        "# Benchmarks",
        "",
        "For readers who compare the speed with that of other libraries.",
        "",
        "Written by `python3 benches/peers/run.py`; do not edit. Compare ratios, and only within this file.",
        "",
        *([note, ""] if note else []),
        *_conditions(versions, rounds, core),
        *_required(results),
        *_contestants(),
        *_robots(results),
        *_whole_robots(results),
        *edges(results),
        *worlds(among, []),
        *_mesh_pairs(results),
        *costs(results.mesh_pairs, []),
        *_disagreements(results),
    ]
    return "\n".join(parts).rstrip() + "\n"


def worlds_alone(among: list[WorldsResult], versions: dict[str, str], rounds: int, core: int) -> list[str]:
    """The section about worlds from a run that measured nothing else."""
    return worlds(among, ["Measured by a run of its own:", "", *_conditions(versions, rounds, core)[2:]])


def costs_alone(pairs: list[MeshPairResult], commit: str, poses: int, core: int) -> list[str]:
    """The section about costs from a run that measured nothing else."""
    when = f"{datetime.date.today().isoformat()}, clearance {commit}"
    conditions = f"Measured by a run of its own (`--costs-only --poses {poses}`): {when}, core {core}, {_machine()}."
    return costs(pairs, [conditions, ""])


def _machine() -> str:
    lines = (line.partition(":") for line in subprocess.getoutput("lscpu").splitlines())
    cpu = {key.strip(): value.strip() for key, _, value in lines}
    keys = ("Model name", "CPU family", "Model", "Stepping", "CPU(s)", "L2 cache", "L3 cache", "Hypervisor vendor")
    machine = ", ".join(f"{key} {cpu[key]}" if key != "Model name" else cpu[key] for key in keys if key in cpu)
    return f"{machine}; load {os.getloadavg()[0]:.1f} when this was written"


def _conditions(versions: dict[str, str], rounds: int, core: int) -> list[str]:
    return [
        "## How it was measured",
        "",
        f"- Machine: {_machine()}.",
        f"- Date: {datetime.date.today().isoformat()}.",
        f"- Versions: {', '.join(f'{name} {version}' for name, version in sorted(versions.items()))}.",
        f"- One process a contestant, all on core {core}, in turn, {rounds} rounds (long ones fewer, but two).",
        "- CPU time; µs a state: best pass / median pass (ratio of best passes to `clearance`).",
        "- The same triangles, pairs and states for all; kinematics included. What is fair, and how every peer is set:",
        "  `benches/peers/README.md`.",
        "",
    ]


def _required(results: Results) -> list[str]:
    rows = [[r.measure, r.at_least, r.aim, r.measured, r.reached] for r in requirements(results)]
    return ["## Required", "", *table(["measure", "at least", "aim", "measured", "reached"], rows)]


def _contestants() -> list[str]:
    rows = [[f"`{name}`", text] for name, text in (VOICES | EDGE_VOICES).items()]
    return ["## Contestants", "", *table(["name", "what it is"], rows)]


def _robots(results: Results) -> list[str]:
    if not results.robots:
        return []
    head = ["robot", "triangles", "pairs", "left out: touch by design", "states random / free"]
    head += ["hierarchies built in", "bytes a triangle", "level 0 a state"]
    return ["## Robots", "", *table(head, [_robot(r) for r in results.robots])]


def _robot(robot: RobotResult) -> list[str]:
    facts, figures = robot.facts, robot.figures
    states = f"{facts['random']} / {facts['free']}"
    built = f"{float(figures['build_seconds']) * 1e3:.1f} ms"
    size, triangles = figures.get("hierarchy_bytes"), int(facts["triangles"])
    per_triangle = f"{float(size) / triangles:.0f}" if size and triangles else "–"
    level_0 = f"{figures['level_0_ns']} ns" if "level_0_ns" in figures else "–"
    row = [robot.name, facts["triangles"], facts["pairs"], facts["touching_by_design"]]
    return [*row, states, built, per_triangle, level_0]


def _cell(measured: Measured, voice: str) -> str:
    if voice not in measured.timings:
        return "–"
    timing, ratio = measured.timings[voice], measured.ratio(voice)
    times = f"{microseconds(timing.best)} / {microseconds(timing.median)}"
    return times if voice == "clearance" or ratio is None else f"{times} ({ratio:.2f}x)"


def _whole_robots(results: Results) -> list[str]:
    parts: list[str] = []
    for measure, title in MEASURES.items():
        robots = [r for r in results.robots if measure in r.measures]
        voices = [v for v in VOICES if any(v in r.measures[measure].timings for r in robots)]
        if robots:
            rows = [[r.name, *(_cell(r.measures[measure], v) for v in voices)] for r in robots]
            parts += [f"## {title}", "", *table(["robot", *(f"`{v}`" for v in voices)], rows)]
    return parts


def _mesh_pairs(results: Results) -> list[str]:
    if not results.mesh_pairs:
        return []
    parts = ["## Pairs of meshes", ""]
    for question, title, buckets, peers in (
        ("free", "Boolean", (TOUCHING, *GAPS), ("coal_cpp_bare", "coal_cpp")),
        ("distance", "Exact distance", GAPS, ("coal_cpp",)),
    ):
        ratios = ", then ".join(f"`{peer}`" for peer in peers)
        parts += [f"### {title}", ""]
        parts += [f"µs of `clearance` (ratio of {ratios}) by gap; random rotations and directions.", ""]
        rows = []
        for pair in results.mesh_pairs:
            cells = [_bucket_cell(pair.measures.get((question, bucket)), peers) for bucket in buckets]
            rows.append([pair.name, f"{pair.facts['a']} – {pair.facts['b']}", *cells])
        for peer in peers:
            means = [results.bucket(question, bucket, peer) for bucket in buckets]
            rows.append([f"**mean, `{peer}`**", "", *("–" if mean is None else f"**{mean:.2f}x**" for mean in means)])
        parts += table(["pair", "triangles", *buckets], rows)
    return [*parts, "Means are geometric.", ""]


def _bucket_cell(measured: Measured | None, peers: tuple[str, ...]) -> str:
    if measured is None:
        return "–"
    ratios = [ratio for peer in peers if (ratio := measured.ratio(peer)) is not None]
    return f"{microseconds(measured.timings['clearance'].best)} ({', '.join(f'{ratio:.2f}x' for ratio in ratios)})"


def _disagreements(results: Results) -> list[str]:
    """Every disagreement is told, whoever is wrong."""
    compared, rows = 0, []
    subjects = [(r.name, r.measures) for r in results.robots] + [(p.name, p.measures) for p in results.mesh_pairs]
    for subject, measures in subjects:
        for (question, states), measured in measures.items():
            for agreement in measured.agreements:
                compared += agreement.compared
                if agreement.different:
                    count = f"{agreement.different} of {agreement.compared}"
                    worst = "" if agreement.worst == float("inf") else f"{agreement.worst:.1e} m"
                    asked = f"{question}, {states}"
                    rows.append([subject, asked, f"`{agreement.voice}`", count, worst, agreement.example])
    problems = [f"- {r.name}: {problem}" for r in results.robots for problem in r.problems]
    text = (
        f"{compared} answers were compared with those of `clearance` (hits and pairs identical, distances within"
        f" {DISTANCE_TOLERANCE:.0e} m); {sum(int(row[3].split()[0]) for row in rows)} differ."
    )
    head = ["subject", "question", "contestant", "differ", "worst", "example (distances in m)"]
    return ["## Answers", "", text, "", *(table(head, rows) if rows else []), *problems, ""]
