"""Report section on robots among obstacles; it can be written alone."""

from __future__ import annotations

import statistics

from .agreement import Agreement
from .markdown import microseconds, table
from .results import Measured
from .world_required import requirements
from .world_results import CUBES, GROWTH, WorldResult, WorldsResult

START, END = "<!-- worlds: written by run.py -->", "<!-- end of worlds -->"

WORLD_VOICES = {
    "clearance": "this library, one call a state",
    "clearance_batch": "this library, all states in one call, one thread",
    "clearance_cubes": "this library, with the cubes of 2 cm in which points lie in their place",
    "coal_cpp_tree": "Coal from C++: each link asked of a dynamic tree of boxes, sphere tests before its queries",
    "coal_cpp_list": "Coal from C++: every link and obstacle, sphere tests before its queries",
    "coal_cpp_octree": "Coal from C++: each link against Coal's octree of cubes of 2 cm",
    "fcl_cpp_tree": "FCL from C++ with its managers: each link asked of a dynamic tree of boxes",
    "fcl_cpp_octree": "FCL from C++: each link against its octree of cubes of 2 cm",
    "pinocchio_coal_tree": "Pinocchio with Coal from Python, its tree of boxes for each joint",
    "pinocchio_coal_list": "Pinocchio with Coal from Python, all pairs in a list",
    "pinocchio_coal_octree": "Pinocchio with Coal from Python, Coal's octree of cubes of 2 cm",
}


def worlds(found: list[WorldsResult], conditions: list[str]) -> list[str]:
    if not found:
        return []
    required = [[r.measure, r.at_least, r.aim, r.measured, r.reached] for r in requirements(found)]
    voices = [[f"`{name}`", text] for name, text in WORLD_VOICES.items()]
    return [
        START,
        "## Worlds",
        "",
        "The robot against obstacles, not against itself. Worlds of the shared truth for its robots; around the others",
        "boxes, cylinders and spheres are scattered, so near that half of the states are free.",
        "",
        *conditions,
        "### Required of worlds",
        "",
        "Against the faster of what people run, Pinocchio with Coal or FCL with its managers; below each row stands the same",
        "against Coal as a careful C++ programmer drives it, of which nothing is required.",
        "",
        *table(["measure", "at least", "aim", "measured", "reached"], required),
        *table(["name", "what it is"], voices),
        *_times(found, "primitives", "free", "Boolean, primitives"),
        *_times(found, "mesh", "free", "Boolean, a mesh of 21 248 triangles"),
        *_times(found, "mesh", "distance", "Least distance, a mesh of 21 248 triangles (exact, cold)"),
        *_times(found, "cloud", "free", "Boolean, a cloud of 100 000 points of 1 cm radius"),
        *_latencies(found),
        *_growth(found),
        *_responses(found),
        END,
        "",
    ]


def put(text: str, section: list[str]) -> str:
    """The report with the section in the place of the one it had, else before the pairs of meshes or at the end."""
    new = "\n".join(section).rstrip() + "\n"
    before, start, rest = text.partition(START)
    if start:
        return before + new.rstrip() + rest.partition(END)[2]
    before, head, after = text.partition("## Pairs of meshes\n")
    return f"{before.rstrip()}\n\n{new}" + (f"\n{head}{after}" if head else "")


def _times(found: list[WorldsResult], kind: str, question: str, title: str) -> list[str]:
    each = [(r.robot, w, m) for r in found for w in r.worlds if w.kind == kind and (m := w.measures.get(question))]
    if not each:
        return []
    voices = [v for v in WORLD_VOICES if any(v in measured.timings for _, _, measured in each)]
    rows = [[robot, w.name, f"{w.free:.0%}", *(_cell(m, v) for v in voices)] for robot, w, m in each]
    return [f"### {title}", "", *table(["robot", "world", "free", *(f"`{v}`" for v in voices)], rows)]


def _cell(measured: Measured, voice: str) -> str:
    if voice not in measured.timings:
        return "–"
    timing, ratio = measured.timings[voice], measured.ratio(voice)
    times = f"{microseconds(timing.best)} / {microseconds(timing.median)}"
    return times if voice == "clearance" or ratio is None else f"{times} ({ratio:.2f}x)"


def _latencies(found: list[WorldsResult]) -> list[str]:
    rows = [
        [r.robot, *(f"{ms:.1f}" for ms in (w.latencies[0], min(w.latencies), statistics.median(w.latencies)))]
        for r in found
        for w in r.worlds
        if w.latencies
    ]
    text = "CPU time (ms) from 100 000 decoded points to the answer about a first state, in a checker that runs."
    head = ["robot", "the first cloud", "best", "median"]
    return ["### Cloud, message in to usable", "", text, "", *table(head, rows)] if rows else []


def _growth(found: list[WorldsResult]) -> list[str]:
    rows = []
    for result in found:
        if ratio := result.growth_ratio():
            times = (result.growth[str(count)] for count in GROWTH)
            cells = [f"{microseconds(t.best)} / {microseconds(t.median)}" for t in times]
            rows.append([result.robot, *cells, f"{ratio:.2f}x"])
    if not rows:
        return []
    text = "The same density everywhere: the 10 fill the robot's reach, the others stand farther and farther out."
    head = ["robot", *(f"{count} obstacles" for count in GROWTH), "last to first"]
    return ["### As the world grows", "", text, "", *table(head, rows)]


def _responses(found: list[WorldsResult]) -> list[str]:
    """Every answer that differs is told, except of those that put cubes in the place of points: they are counted."""
    same: list[tuple[str, Agreement]] = []
    cubes: list[list[str]] = []
    for result in found:
        for world in result.worlds:
            for question, agreement in _agreements(world):
                if agreement.voice in CUBES:
                    cubes.append([result.robot, f"`{agreement.voice}`", f"{agreement.different} of {agreement.compared}"])
                else:
                    same.append((f"{result.robot}, {world.name}, {question}", agreement))
            same += [(f"{result.robot}, cubes, free", agreement) for agreement in world.cubes]
    compared, truth = (sum(a.compared for _, a in same if (a.voice == "truth") == t) for t in (False, True))
    different = [(where, a) for where, a in same if a.different]
    text = (
        f"{compared} answers of others and {truth} of the truth were compared with those of `clearance`;"
        f" {sum(a.different for _, a in different)} differ."
    )
    rows = [[where, f"`{a.voice}`", f"{a.different} of {a.compared}", _worst(a), a.example] for where, a in different]
    parts = ["### Answers about worlds", "", text, ""]
    parts += table(["subject", "contestant", "differ", "worst", "example (distances in m)"], rows) if rows else []
    if cubes:
        parts += ["Cubes of 2 cm hold other space than balls of 1 cm radius around points:", ""]
        parts += table(["robot", "contestant", "answers that differ from those about balls"], cubes)
    problems = [f"- {result.robot}: {problem}" for result in found for problem in result.problems]
    return [*parts, *problems, *([""] if problems else [])]


def _agreements(world: WorldResult) -> list[tuple[str, Agreement]]:
    found = [(question, a) for question, measured in world.measures.items() for a in measured.agreements]
    return found + list(world.truth.items())


def _worst(agreement: Agreement) -> str:
    return "" if agreement.worst == float("inf") else f"{agreement.worst:.1e} m"
