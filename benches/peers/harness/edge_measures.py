"""Definitions of the edge benchmarks and their result types."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from .edge_sets import COLLIDING_LENGTHS
from .race import Timing


@dataclass(frozen=True)
class EdgePeer:
    """A contestant and the manner in which it is asked about edges."""

    name: str
    contestant: str
    manner: str
    # It takes samples: what it calls a hit is one. Others may give false alarms.
    samples: bool = True


@dataclass(frozen=True)
class EdgeMeasure:
    title: str
    # free or colliding
    kind: str
    lengths: tuple[float, ...]
    question: str
    peers: tuple[EdgePeer, ...]
    # Contestants that take milliseconds an edge are asked about few.
    few: bool = False


PINOCCHIO = EdgePeer("pinocchio_coal_0.02", "pinocchio_coal", "-0.02")
COAL = EdgePeer("coal_cpp_0.01", "coal_cpp", "-0.01")
FCL = EdgePeer("python_fcl_ca", "python_fcl", "-pairs", samples=False)
FCL_SPHERES = EdgePeer("python_fcl_ca_spheres", "python_fcl", "-spheres", samples=False)
CAST = EdgePeer("tesseract_cast", "tesseract_cast", "-whole", samples=False)
CASTS = EdgePeer("tesseract_cast_0.05", "tesseract_cast", "-0.05", samples=False)
COAL_LEAST = EdgePeer("coal_cpp_least_0.01", "coal_cpp", "-0.01")
PROOF = EdgePeer("clearance_proof", "clearance", "-proof")

# Its answers are bounds on a distance, and those of samples are distances.
LEAST = "edge-least"

EDGE_MEASURES = {
    "every 0.02": EdgeMeasure(
        "Free edges, against samples every 0.02 rad", "free", (0.2, 0.5, 1.0, 2.0), "edge", (PINOCCHIO,)
    ),
    "every 0.01": EdgeMeasure("Free edges, against samples every 0.01 rad", "free", (0.1, 0.5, 2.0), "edge", (COAL,)),
    "continuous": EdgeMeasure(
        "Free edges, against continuous checks",
        "free",
        (0.1, 0.5),
        "edge",
        (FCL, FCL_SPHERES, CAST, CASTS),
        few=True,
    ),
    "colliding": EdgeMeasure(
        "Colliding edges, any contact, against samples every 0.02 rad",
        "colliding",
        COLLIDING_LENGTHS,
        "edge-any",
        (PINOCCHIO,),
    ),
    "least": EdgeMeasure(
        "Least distance along free edges, against distances every 0.01 rad, and against the proof that the edge is free",
        "free",
        (0.1, 0.5, 2.0),
        LEAST,
        (COAL_LEAST, PROOF),
    ),
}

EDGE_VOICES = {
    PINOCCHIO.name: "`pinocchio_coal`, along edges sampled every 0.02 rad, stopping at the first hit",
    COAL.name: "`coal_cpp`, along edges sampled every 0.01 rad, stopping at the first hit",
    FCL.name: "FCL's conservative advancement through python-fcl for every pair; transforms are given",
    FCL_SPHERES.name: "the same, only for pairs whose spheres can meet on the way",
    COAL_LEAST.name: "`coal_cpp`, distances along edges sampled every 0.01 rad, each up to the least so far",
    PROOF.name: "this library's proof that the edge is free, without a distance",
    CAST.name: "Tesseract's Bullet cast, one for a whole edge; transforms are given",
    CASTS.name: "the same, a cast every 0.05 rad",
}


@dataclass(frozen=True)
class EdgeAgreement:
    """How a voice's answers compare with this library's."""

    voice: str
    compared: int
    # Here free, there a hit that is a sample's: one of the two is wrong.
    disagreements: int
    # Here a contact, there none.
    missed: int
    # Here free, there a hit that is no sample's.
    false_alarms: int
    example: str


@dataclass
class EdgeMeasured:
    count: int
    timings: dict[str, Timing] = field(default_factory=dict)
    agreements: list[EdgeAgreement] = field(default_factory=list)
    # Neither free nor in contact, says this library.
    undecided: int = 0

    def ratio(self, peer: str) -> float | None:
        """How many times longer the peer takes in the median of the rounds."""
        if peer not in self.timings or "clearance" not in self.timings:
            return None
        return self.timings[peer].median / self.timings["clearance"].median


# By key of the measure and length.
EdgesMeasured = dict[tuple[str, float], EdgeMeasured]


def asked() -> Iterator[tuple[str, EdgeMeasure, float]]:
    """Every measure at every length."""
    for key, measure in EDGE_MEASURES.items():
        for length in measure.lengths:
            yield key, measure, length
