"""Required and aimed-at speed ratios and figures, and whether the results reach them (states, mesh pairs, edges)."""

from __future__ import annotations

from dataclasses import dataclass

from .edge_measures import CAST, CASTS, COAL, FCL, FCL_SPHERES, PINOCCHIO
from .results import GAPS, Results, geometric_mean

STATE_BOOLEAN = [("free", "random"), ("free", "free")]
DISTANCE = [("distance", "free")]


@dataclass(frozen=True)
class Requirement:
    measure: str
    at_least: str
    aim: str
    measured: str
    reached: str


def requirements(results: Results) -> list[Requirement]:
    return [
        _ratios(results, "State boolean against Pinocchio + Coal", STATE_BOOLEAN, "pinocchio_coal", 10, 40),
        _ratios(results, "State boolean against careful Coal in C++", STATE_BOOLEAN, "coal_cpp", 4, 10),
        _ratios(results, "Least self distance against Pinocchio + Coal", DISTANCE, "pinocchio_coal", 100, 400),
        _ratios(results, "Least self distance against careful Coal in C++", DISTANCE, "coal_cpp", 5, 12),
        _buckets(results, "Mesh pair boolean against Coal's query, gaps 0.1–100 mm", "free", "coal_cpp_bare", 15),
        _buckets(results, "The same with a sphere test before Coal's query", "free", "coal_cpp", 15),
        _buckets(results, "Mesh pair exact distance against Coal's query", "distance", "coal_cpp", 12),
        _edges(results, "Certified edge against Pinocchio + Coal every 0.02 rad", "every 0.02", PINOCCHIO.name, 15, 40),
        _edges(results, "Certified edge against careful Coal in C++ every 0.01 rad", "every 0.01", COAL.name, 4, 12),
        _edges(results, "Certified edge against FCL's conservative advancement", "continuous", FCL.name, 50, 500),
        _edges(results, "The same with a sphere test before FCL's", "continuous", FCL_SPHERES.name, 50, 500),
        _edges(results, "Certified edge against Tesseract's Bullet cast", "continuous", CAST.name, 50, 500),
        _edges(results, "The same with a cast every 0.05 rad", "continuous", CASTS.name, 50, 500),
        _edges(results, "Colliding edge against Pinocchio + Coal every 0.02 rad", "colliding", PINOCCHIO.name, 5, 20),
        _disagreements(results),
        _figure("Verifying a certificate, of making it", _certificates(results), 100, 100, "x"),
        _figure("Level 0 with kinematics, a state", _level_0(results), 100, 50, "ns"),
        _streamed(results),
        _figure("Building all hierarchies, 200 000 triangles", _build_seconds(results), 1, 0.2, "s"),
        _figure("Memory a triangle", _bytes_per_triangle(results), 150, 100, "B"),
    ]


def verdict(least_reached: bool, aim_reached: bool) -> str:
    return "aim" if aim_reached else "at least" if least_reached else "**no**"


def _ratios(
    results: Results, name: str, measures: list[tuple[str, str]], peer: str, least: float, aim: float
) -> Requirement:
    """Every robot must reach what is required."""
    ratios = results.ratios(measures, peer)
    if not ratios:
        return Requirement(name, f"{least}x", f"{aim}x", "not measured", "–")
    worst = min(ratios, key=lambda robot: ratios[robot])
    mean = geometric_mean(list(ratios.values()))
    measured = f"{ratios[worst]:.2f}x at worst ({worst}), {mean:.2f}x in the mean of {len(ratios)} robots"
    return Requirement(name, f"{least}x", f"{aim}x", measured, verdict(ratios[worst] >= least, ratios[worst] >= aim))


def _edges(results: Results, name: str, key: str, peer: str, least: float, aim: float) -> Requirement:
    """Every robot must reach what is required, at every length."""
    ratios = results.edge_ratios(key, peer)
    if not ratios:
        return Requirement(name, f"{least}x", f"{aim}x", "not measured", "–")
    worst = min(ratios, key=lambda at: ratios[at])
    where, mean = f"{worst[0]}, {worst[1]:g} rad", geometric_mean(list(ratios.values()))
    robots = len({robot for robot, _ in ratios})
    measured = f"{ratios[worst]:.2f}x at worst ({where}), {mean:.2f}x in the mean of {robots} robots"
    return Requirement(name, f"{least}x", f"{aim}x", measured, verdict(ratios[worst] >= least, ratios[worst] >= aim))


def _disagreements(results: Results) -> Requirement:
    """An edge that is free here and in which a sample hits."""
    responses = [a for robot in results.robots for measured in robot.edges.values() for a in measured.agreements]
    name, count = "Edges called free in which a sample hits", sum(a.disagreements for a in responses)
    if not responses:
        return Requirement(name, "0", "0", "not measured", "–")
    measured = f"{count} of {sum(a.compared for a in responses)}"
    return Requirement(name, "0", "0", measured, verdict(count == 0, count == 0))


def _certificates(results: Results) -> list[float | None]:
    words = [robot.certificates for robot in results.robots if robot.certificates]
    return [float(w["verifying_s"]) / float(w["making_s"]) for w in words]


def _buckets(results: Results, name: str, question: str, peer: str, aim: float) -> Requirement:
    """Every bucket must reach 5x; the aim is for the mean of the buckets."""
    buckets = {gap: results.bucket(question, gap, peer) for gap in GAPS}
    known = {gap: ratio for gap, ratio in buckets.items() if ratio is not None}
    texts = ("5x in every bucket", f"{aim}x in the mean")
    if not known:
        return Requirement(name, *texts, "not measured", "–")
    worst = min(known, key=lambda gap: known[gap])
    mean = geometric_mean(list(known.values())) or 0.0
    measured = f"{known[worst]:.2f}x at worst ({worst}), {mean:.2f}x in the mean"
    return Requirement(name, *texts, measured, verdict(known[worst] >= 5, known[worst] >= 5 and mean >= aim))


def _streamed(results: Results) -> Requirement:
    name = "Streamed state, boolean + least distance within 0.1 m, against cold"
    ratios = {
        r.name: m.timings["clearance"].best / m.timings["clearance_stream"].best
        for r in results.robots
        if (m := r.measures.get(("near", "walk"))) and "clearance_stream" in m.timings
    }
    if not ratios:
        return Requirement(name, "5x", "20x", "not there yet", "–")
    worst = min(ratios, key=lambda robot: ratios[robot])
    measured = f"{ratios[worst]:.2f}x at worst ({worst}), {geometric_mean(list(ratios.values())):.2f}x in the mean"
    return Requirement(name, "5x", "20x", measured, verdict(ratios[worst] >= 5, ratios[worst] >= 20))


def _figure(name: str, values: list[float | None], least: float, aim: float, unit: str) -> Requirement:
    known = [value for value in values if value is not None]
    if not known:
        return Requirement(name, f"{least} {unit}", f"{aim} {unit}", "not there yet", "–")
    worst = max(known)
    measured = f"{worst:.3g} {unit} at worst"
    return Requirement(name, f"{least} {unit}", f"{aim} {unit}", measured, verdict(worst <= least, worst <= aim))


def _number(words: dict[str, str], key: str) -> float | None:
    return float(words[key]) if key in words else None


def _level_0(results: Results) -> list[float | None]:
    return [_number(robot.figures, "level_0_ns") for robot in results.robots]


def _build_seconds(results: Results) -> list[float | None]:
    """Of robots that have about so many triangles."""
    large = [r for r in results.robots if int(r.facts["triangles"]) > 100_000]
    return [float(r.figures["build_seconds"]) * 200_000 / int(r.facts["triangles"]) for r in large if r.figures]


def _bytes_per_triangle(results: Results) -> list[float | None]:
    meshed = [r for r in results.robots if int(r.facts["triangles"]) > 1000]
    return [float(b) / int(r.facts["triangles"]) for r in meshed if (b := _number(r.figures, "hierarchy_bytes"))]
