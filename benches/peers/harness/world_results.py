"""Data types of the results for robots among obstacles."""

from __future__ import annotations

from dataclasses import dataclass, field

from .agreement import Agreement
from .race import Timing
from .results import Measured

# Numbers of obstacles as a world grows.
GROWTH = (10, 100, 1000, 10_000)

# They put cubes in the place of points, which is another question.
CUBES = ("clearance_cubes", "coal_cpp_octree", "fcl_cpp_octree", "pinocchio_coal_octree")

# Coal as nobody but a careful C++ programmer drives it; the others are what people run.
CAREFUL = "coal_cpp"


@dataclass
class WorldResult:
    kind: str
    name: str
    facts: dict[str, str]
    # share of the random states
    free: float = 0.0
    # by question
    measures: dict[str, Measured] = field(default_factory=dict)
    truth: dict[str, Agreement] = field(default_factory=dict)
    # those who put cubes in the place of points, compared with `clearance_cubes`
    cubes: list[Agreement] = field(default_factory=list)
    # milliseconds from decoded points to a first answer
    latencies: list[float] = field(default_factory=list)

    def fastest(self, question: str, careful: bool, own: str = "clearance") -> tuple[str, float] | None:
        """Of careful contestants or of all others, among those that answer the same question, who takes the least time, and
        how many times that of this library, asked in one of its manners."""
        measured = self.measures.get(question)
        if measured is None:
            return None
        peers = [v for v in measured.timings if not v.startswith("clearance") and v not in CUBES]
        peers = [peer for peer in peers if peer.startswith(CAREFUL) == careful]
        ratios = [(ratio, peer) for peer in peers if (ratio := measured.ratio(peer, own)) is not None]
        return min(ratios)[::-1] if ratios else None


@dataclass
class WorldsResult:
    robot: str
    worlds: list[WorldResult] = field(default_factory=list)
    # by number of obstacles
    growth: dict[str, Timing] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)

    def growth_ratio(self) -> float | None:
        """What a state costs among the most obstacles, of what it costs among the fewest."""
        first, last = (self.growth.get(str(count)) for count in (GROWTH[0], GROWTH[-1]))
        return last.best / first.best if first and last else None
