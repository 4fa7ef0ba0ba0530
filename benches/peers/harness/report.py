"""`docs/benchmarks.md`: the tables, and how they came about."""

from __future__ import annotations

import datetime
import os
import subprocess
from collections.abc import Iterable

from .agreement import DISTANCE_TOLERANCE
from .required import requirements
from .results import GAPS, MEASURES, TOUCHING, Measured, Results, geometric_mean

VOICES = {
    "clearance": "this library, one call a state",
    "clearance_batch": "this library, all states in one call, one thread",
    "clearance_stream": "this library, each state helped by the one before",
    "coal_cpp": "Coal from C++, as a careful programmer drives it",
    "pinocchio_coal": "Pinocchio with Coal, as Python users run it",
    "python_fcl": "FCL through python-fcl; its transforms are given, their kinematics not timed",
}


def markdown(results: Results, versions: dict[str, str], rounds: int, core: int, note: str) -> str:
    parts = [
        "# Benchmarks",
        "",
        "Written by `python3 benches/peers/run.py`; do not edit. Compare ratios, and only within this file.",
        "",
        *([note, ""] if note else []),
        *_conditions(versions, rounds, core),
        *_required(results),
        *_contestants(),
        *_robots(results),
        *_whole_robots(results),
        *_mesh_pairs(results),
        *_costs(results),
        *_disagreements(results),
    ]
    return "\n".join(parts).rstrip() + "\n"


def _table(head: list[str], rows: Iterable[list[str]]) -> list[str]:
    body = [f"| {' | '.join(row)} |" for row in rows]
    return [f"| {' | '.join(head)} |", f"|{'---|' * len(head)}", *body, ""]


def _conditions(versions: dict[str, str], rounds: int, core: int) -> list[str]:
    cpu = dict(
        (key.strip(), value.strip())
        for key, _, value in (line.partition(":") for line in subprocess.getoutput("lscpu").splitlines())
    )
    keys = ("Model name", "CPU family", "Model", "Stepping", "CPU(s)", "L2 cache", "L3 cache", "Hypervisor vendor")
    machine = ", ".join(f"{key} {cpu[key]}" if key != "Model name" else cpu[key] for key in keys if key in cpu)
    return [
        "## How it was measured",
        "",
        f"- Machine: {machine}; load {os.getloadavg()[0]:.1f} when this was written.",
        f"- Date: {datetime.date.today().isoformat()}.",
        f"- Versions: {', '.join(f'{name} {version}' for name, version in sorted(versions.items()))}.",
        f"- One process a contestant, all on core {core}, in turn, {rounds} rounds (slow ones fewer, never fewer than two);"
        " thread CPU time; µs a state: best pass / median pass (ratio of best passes to `clearance`).",
        "- The same triangles, pairs and states for all; kinematics included. What is fair and how every peer is set:"
        " [`benches/peers/README.md`](../benches/peers/README.md).",
        "",
    ]


def _required(results: Results) -> list[str]:
    rows = [[r.measure, r.at_least, r.aim, r.measured, r.reached] for r in requirements(results)]
    return ["## Required", "", *_table(["measure", "at least", "aim", "measured", "reached"], rows)]


def _contestants() -> list[str]:
    return ["## Contestants", "", *_table(["name", "what it is"], [[f"`{n}`", t] for n, t in VOICES.items()])]


def _robots(results: Results) -> list[str]:
    if not results.robots:
        return []
    head = ["robot", "triangles", "pairs", "left out: touch by design", "states random / free", "hierarchies built in"]
    rows = [
        [
            r.name,
            r.facts["triangles"],
            r.facts["pairs"],
            r.facts["touching_by_design"],
            f"{r.facts['random']} / {r.facts['free']}",
            f"{float(r.figures['build_seconds']) * 1e3:.1f} ms" if r.figures else "–",
        ]
        for r in results.robots
    ]
    return ["## Robots", "", *_table(head, rows)]


def _cell(measured: Measured, voice: str) -> str:
    if voice not in measured.timings:
        return "–"
    timing, ratio = measured.timings[voice], measured.ratio(voice)
    times = f"{_microseconds(timing.best)} / {_microseconds(timing.median)}"
    return times if voice == "clearance" or ratio is None else f"{times} ({ratio:.2f}x)"


def _microseconds(value: float) -> str:
    return f"{value:.3f}" if value < 1 else f"{value:.2f}" if value < 100 else f"{value:.0f}"


def _whole_robots(results: Results) -> list[str]:
    parts: list[str] = []
    for measure, title in MEASURES.items():
        robots = [r for r in results.robots if measure in r.measures]
        voices = [v for v in VOICES if any(v in r.measures[measure].timings for r in robots)]
        if robots:
            rows = [[r.name, *(_cell(r.measures[measure], v) for v in voices)] for r in robots]
            parts += [f"## {title}", "", *_table(["robot", *(f"`{v}`" for v in voices)], rows)]
    return parts


def _mesh_pairs(results: Results) -> list[str]:
    if not results.mesh_pairs:
        return []
    parts = ["## Pairs of meshes", ""]
    parts += ["µs of `clearance` (ratio of `coal_cpp`) by gap; random rotations and directions.", ""]
    for question, title, buckets in (
        ("free", "Boolean", (TOUCHING, *GAPS)),
        ("distance", "Exact distance", GAPS),
    ):
        rows = []
        for pair in results.mesh_pairs:
            cells = []
            for bucket in buckets:
                measured = pair.measures.get((question, bucket))
                ratio = measured.ratio("coal_cpp") if measured else None
                cells.append("–" if ratio is None or measured is None else f"{_microseconds(measured.timings['clearance'].best)} ({ratio:.2f}x)")
            rows.append([pair.name, f"{pair.facts['a']} – {pair.facts['b']}", *cells])
        means = [results.bucket(question, bucket) for bucket in buckets]
        rows.append(["**geometric mean**", "", *("–" if mean is None else f"**{mean:.2f}x**" for mean in means)])
        parts += [f"### {title}", "", *_table(["pair", "triangles", *buckets], rows)]
        gaps = [mean for bucket in GAPS if (mean := results.bucket(question, bucket))]
        parts += [f"Geometric mean of the gaps: {geometric_mean(gaps):.2f}x.", ""] if gaps else []
    return parts


def _costs(results: Results) -> list[str]:
    """`T = N_bv * C_bv + N_p * C_p` of every volume type, once the library tells it."""
    parts = ["## Cost model", "", "T = N_bv · C_bv + N_p · C_p (Gottschalk, Lin & Manocha 1996).", ""]
    rows = [[r.name, *line.split()] for r in results.robots for line in r.costs]
    if not rows:
        return [*parts, "The library does not tell it yet.", ""]
    return [*parts, *_table(["robot", "volume", "N_bv", "C_bv (ns)", "N_p", "C_p (ns)"], rows)]


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
                    rows.append([subject, f"{question}, {states}", f"`{agreement.voice}`", count, worst, agreement.example])
    problems = [f"- {r.name}: {problem}" for r in results.robots for problem in r.problems]
    text = (
        f"{compared} answers were compared with those of `clearance` (hits and pairs identical, distances within"
        f" {DISTANCE_TOLERANCE:.0e} m); {sum(int(row[3].split()[0]) for row in rows)} differ."
    )
    head = ["subject", "question", "contestant", "differ", "worst", "example (distances in m)"]
    return ["## Answers", "", text, "", *(_table(head, rows) if rows else []), *problems, ""]
