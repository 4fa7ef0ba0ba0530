"""Required and aimed-at speed ratios and figures among obstacles, and whether the results reach them."""

from __future__ import annotations

import statistics

from .requirements import Requirement, verdict
from .results import geometric_mean
from .world_results import WorldResult, WorldsResult

PRIMITIVES = "State boolean, 10, 100, 1000 primitives"
MESH = "State boolean, mesh of 21 248 triangles"
DISTANCE = "Least distance, mesh of 21 248 triangles"
IN_BATCHES = "… all states in one call, which the others have not"
OCTREE = "State boolean, cloud of 100 000 points, against Coal's octree at 2 cm"


def requirements(found: list[WorldsResult]) -> list[Requirement]:
    return [
        *_against(found, PRIMITIVES, "primitives", "free", 10, 30),
        _ratios(IN_BATCHES, _fastest(found, "primitives", "free", False, "clearance_batch"), 10, 30),
        *_against(found, MESH, "mesh", "free", 10, 20),
        _ratios(IN_BATCHES, _fastest(found, "mesh", "free", False, "clearance_batch"), 10, 20),
        *_against(found, DISTANCE, "mesh", "distance", 20, 100),
        _ratios(OCTREE, _octree(found, "pinocchio_coal_octree"), 10, 50),
        _informative(_octree(found, "coal_cpp_octree")),
        _ratios("The same against balls in trees", _fastest(found, "cloud", "free", False), 10, 50),
        _informative(_fastest(found, "cloud", "free", True)),
        _at_most("Cloud of 100 000 points, decoded points to first answer", _latencies(found), 50, 10, "ms"),
        _at_most("A state among 10 000 obstacles, of one among 10", _growth(found), 3, 1.5, "x"),
    ]


def _against(
    found: list[WorldsResult], name: str, kind: str, question: str, least: float, aim: float
) -> list[Requirement]:
    """What is required against what people run, and what is told of careful contestants."""
    people, careful = (_fastest(found, kind, question, careful) for careful in (False, True))
    return [_ratios(name, people, least, aim), _informative(careful)]


def _informative(ratios: dict[str, float]) -> Requirement:
    return Requirement("… and against careful Coal in C++", "–", "–", _summary(ratios), "–")


def _each(found: list[WorldsResult], kind: str) -> list[tuple[str, WorldResult]]:
    return [(f"{r.robot}, {w.name}", w) for r in found for w in r.worlds if w.kind == kind]


def _fastest(
    found: list[WorldsResult], kind: str, question: str, careful: bool, own: str = "clearance"
) -> dict[str, float]:
    """Ratios of the fastest contestant, by robot and world."""
    reported = [(where, world.fastest(question, careful, own)) for where, world in _each(found, kind)]
    return {f"{where}, `{best[0]}`": best[1] for where, best in reported if best}


def _octree(found: list[WorldsResult], voice: str) -> dict[str, float]:
    each = [(where, w.measures["free"].ratio(voice)) for where, w in _each(found, "cloud") if "free" in w.measures]
    return {where: ratio for where, ratio in each if ratio is not None}


def _latencies(found: list[WorldsResult]) -> dict[str, float]:
    return {where: statistics.median(w.latencies) for where, w in _each(found, "cloud") if w.latencies}


def _growth(found: list[WorldsResult]) -> dict[str, float]:
    return {r.robot: ratio for r in found if (ratio := r.growth_ratio()) is not None}


def _ratios(name: str, ratios: dict[str, float], least: float, aim: float) -> Requirement:
    """Every robot and world must reach what is required."""
    worst = min(ratios.values(), default=None)
    reached = "–" if worst is None else verdict(worst >= least, worst >= aim)
    return Requirement(name, f"{least}x", f"{aim}x", _summary(ratios), reached)


def _summary(ratios: dict[str, float]) -> str:
    if not ratios:
        return "not measured"
    worst = min(ratios, key=lambda where: ratios[where])
    mean = geometric_mean(list(ratios.values()))
    return f"{ratios[worst]:.2f}x at worst ({worst}), {mean:.2f}x in the mean of {len(ratios)}"


def _at_most(name: str, values: dict[str, float], least: float, aim: float, unit: str) -> Requirement:
    if not values:
        return Requirement(name, f"{least} {unit}", f"{aim} {unit}", "not measured", "–")
    worst = max(values, key=lambda where: values[where])
    measured = f"{values[worst]:.3g} {unit} at worst ({worst})"
    return Requirement(
        name, f"{least} {unit}", f"{aim} {unit}", measured, verdict(values[worst] <= least, values[worst] <= aim)
    )
