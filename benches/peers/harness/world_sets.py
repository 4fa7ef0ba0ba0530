"""The benchmark worlds of each robot (shared files, or random primitives), and comparison with the true results."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from .agreement import Agreement
from .subjects import RobotSource

# How many primitives.
PRIMITIVES = (10, 100, 1000)

# How far (m) the truth's distances may be from those found: they are printed with ten digits, and certified to 1e-9 m.
TRUTH_TOLERANCE = 5e-9


@dataclass(frozen=True)
class WorldSource:
    """A file of the truth, or so many primitives to scatter."""

    kind: str  # primitives, mesh, cloud
    name: str
    count: int = 0
    file: Path | None = None
    truth: Path | None = None


def worlds_of(robot: RobotSource) -> list[WorldSource]:
    """The truth has worlds for its robots; around others primitives are scattered."""
    folder = robot.package_root
    if not (folder / "env_mesh.json").is_file():
        return [WorldSource("primitives", f"{count} primitives", count) for count in PRIMITIVES]

    def source(kind: str, name: str, file: str) -> WorldSource:
        return WorldSource(kind, name, 0, folder / f"env_{file}.json", folder / f"truth_env_{file}.json")

    return [
        *(source("primitives", f"{count} primitives", f"prim_{count}") for count in PRIMITIVES),
        source("mesh", "mesh", "mesh"),
        source("cloud", "cloud", "cloud"),
    ]


def against_truth(responses: list[str], question: str, truth: Path) -> Agreement:
    """How this library's answers about the truth's states compare with the truth."""
    reported = json.loads(truth.read_text())
    if question == "free":
        off = [float("inf") if int(a) == hit else 0.0 for a, hit in zip(responses, reported["hit"])]
    else:
        off = [abs(float(a) - least) for a, least in zip(responses, reported["min_distance"])]
    wrong = [i for i, d in enumerate(off) if d > TRUTH_TOLERANCE]
    example = f"state {wrong[0]}: {responses[wrong[0]]} here" if wrong else ""
    return Agreement("truth", len(off), len(wrong), max(off, default=0.0), example)
