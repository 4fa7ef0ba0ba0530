"""What must be reached among obstacles."""

from __future__ import annotations

import statistics

from .required import Requirement, verdict
from .results import geometric_mean
from .world_results import WorldResult, WorldsResult

OCTREE = "coal_cpp_octree"


def requirements(found: list[WorldsResult]) -> list[Requirement]:
    return [
        _ratios("State boolean, 10, 100, 1000 primitives", _fastest(found, "primitives", "free"), 10, 30),
        _ratios("State boolean, mesh of 21 248 triangles", _fastest(found, "mesh", "free"), 10, 20),
        _ratios("Least distance, mesh of 21 248 triangles", _fastest(found, "mesh", "distance"), 20, 100),
        _ratios("State boolean, cloud of 100 000 points, against Coal's octree at 2 cm", _octree(found), 10, 50),
        _ratios("The same against balls in Coal's tree", _fastest(found, "cloud", "free"), 10, 50),
        _at_most("Cloud of 100 000 points, decoded points to first answer", _latencies(found), 50, 10, "ms"),
        _at_most("A state among 10 000 obstacles, of one among 10", _growth(found), 3, 1.5, "x"),
    ]


def _each(found: list[WorldsResult], kind: str) -> list[tuple[str, WorldResult]]:
    return [(f"{r.robot}, {w.name}", w) for r in found for w in r.worlds if w.kind == kind]


def _fastest(found: list[WorldsResult], kind: str, question: str) -> dict[str, float]:
    """Ratios of the fastest peer, by robot and world."""
    each = _each(found, kind)
    return {f"{where}, `{best[0]}`": best[1] for where, world in each if (best := world.fastest(question))}


def _octree(found: list[WorldsResult]) -> dict[str, float]:
    each = [(where, w.measures["free"].ratio(OCTREE)) for where, w in _each(found, "cloud") if "free" in w.measures]
    return {where: ratio for where, ratio in each if ratio is not None}


def _latencies(found: list[WorldsResult]) -> dict[str, float]:
    return {where: statistics.median(w.latencies) for where, w in _each(found, "cloud") if w.latencies}


def _growth(found: list[WorldsResult]) -> dict[str, float]:
    return {r.robot: ratio for r in found if (ratio := r.growth_ratio()) is not None}


def _ratios(name: str, ratios: dict[str, float], least: float, aim: float) -> Requirement:
    """Every robot and world must reach what is required."""
    if not ratios:
        return Requirement(name, f"{least}x", f"{aim}x", "not measured", "–")
    worst = min(ratios, key=lambda where: ratios[where])
    mean = geometric_mean(list(ratios.values()))
    measured = f"{ratios[worst]:.2f}x at worst ({worst}), {mean:.2f}x in the mean of {len(ratios)}"
    return Requirement(name, f"{least}x", f"{aim}x", measured, verdict(ratios[worst] >= least, ratios[worst] >= aim))


def _at_most(name: str, values: dict[str, float], least: float, aim: float, unit: str) -> Requirement:
    if not values:
        return Requirement(name, f"{least} {unit}", f"{aim} {unit}", "not measured", "–")
    worst = max(values, key=lambda where: values[where])
    measured = f"{values[worst]:.3g} {unit} at worst ({worst})"
    return Requirement(
        name, f"{least} {unit}", f"{aim} {unit}", measured, verdict(values[worst] <= least, values[worst] <= aim)
    )
