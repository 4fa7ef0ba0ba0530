"""Runs the edge benchmarks of one robot on all contestants: times and agreement of results."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from .contestant_process import Child, Failed
from .edge_measures import LEAST, EdgeAgreement, EdgeMeasure, EdgeMeasured, EdgePeer, EdgesMeasured, asked
from .edge_sets import JUDGED_EVERY, draw_edges, name_of
from .race import Voice, race

# More pairs than this are too many for FCL's advancement and for Tesseract's casts.
MOST_FCL_PAIRS = 60
MOST_CAST_PAIRS = 400


@dataclass(frozen=True)
class Extent:
    edges: int
    few_edges: int
    rounds: int
    patience: float
    seed: int


class EdgeComparison:
    """The contestants of one robot. Those that may break are started for it alone; `close` ends them."""

    def __init__(self, clearance: Child, loaded: dict[str, Child], extent: Extent, neutral: Path, file: Path) -> None:
        self.clearance, self.extent = clearance, extent
        self.problems: list[str] = []
        self._file, self._neutral, self._own = file, neutral, list[Child]()
        judge = loaded["coal_cpp"]
        self.counts = draw_edges(neutral, judge, file, extent.seed, extent.edges, extent.patience)
        self._children = {"clearance": clearance, **loaded}
        for child in self._children.values():
            child.ask("edges", file)

    def start(self, child: Child) -> None:
        """With another contestant, which ends with this comparison; where it cannot load the robot, without it."""
        try:
            child.ask("load", self._neutral)
            child.ask("edges", self._file)
        except Failed as failure:
            self.problems.append(str(failure))
            child.close()
            return
        self._own.append(child)
        self._children[child.name] = child

    def measure(self) -> EdgesMeasured:
        found: EdgesMeasured = {}
        for key, measure, length in asked():
            name = name_of(measure.kind, length)
            anyone = any(peer.contestant in self._children for peer in measure.peers)
            if anyone and name in self.counts:
                found[key, length] = self._measured(measure, name, self.counts[name])
        return found

    def close(self) -> None:
        for child in self._own:
            child.close()

    def _measured(self, measure: EdgeMeasure, name: str, count: int) -> EdgeMeasured:
        if measure.few:
            count = min(count, self.extent.few_edges)
        some = f"{name}:{count}"
        ours = self.clearance.ask("answers", measure.question, some)
        if ours is None:
            self.problems.append("clearance cannot be asked about edges")
            return EdgeMeasured(count)
        measured = EdgeMeasured(count, undecided=ours.count("undecided"))
        of_distances = measure.question == LEAST
        judge = f"coal_cpp every {JUDGED_EVERY} rad"
        if not of_distances:
            measured.agreements.append(_agreement(judge, True, ours, [_expected(measure.kind)] * count))
        voices = [Voice("clearance", self.clearance)]
        for peer in measure.peers:
            if peer.contestant in self._children and (theirs := self._responses(peer, measure.question, some)):
                if of_distances and peer.contestant != "clearance":
                    measured.agreements.append(_agreement_of_distances(peer.name, ours, theirs))
                elif not of_distances:
                    measured.agreements.append(_agreement(peer.name, peer.samples, ours, theirs))
                voices.append(Voice(peer.name, self._children[peer.contestant], peer.manner))
        measured.timings = race(voices, measure.question, some, count, self.extent.rounds, self.extent.patience)
        return measured

    def _responses(self, peer: EdgePeer, question: str, some: str) -> list[str] | None:
        try:
            return self._children[peer.contestant].ask("answers", question + peer.manner, some)
        except Failed as failure:
            self.problems.append(str(failure))
            del self._children[peer.contestant]
            return None


def _expected(kind: str) -> str:
    return "1" if kind == "free" else "0"


def _agreement(voice: str, samples: bool, ours: list[str], theirs: list[str]) -> EdgeAgreement:
    pairs = list(zip(ours, theirs, strict=True))
    hits = [i for i, pair in enumerate(pairs) if pair == ("1", "0")]
    missed = [i for i, pair in enumerate(pairs) if pair == ("0", "1")]
    example = f"edge {(hits + missed)[0]}" if hits or missed else ""
    return EdgeAgreement(
        voice, len(pairs), len(hits) if samples else 0, len(missed), 0 if samples else len(hits), example
    )


def _agreement_of_distances(voice: str, ours: list[str], theirs: list[str]) -> EdgeAgreement:
    """The least distance of samples is never below the proven bound, and the measured one not above it by more than the tolerance."""
    bounds = [[float(word) for word in words.split()] for words in ours]
    pairs = [(lower, upper, float(found)) for (lower, upper), found in zip(bounds, theirs, strict=True)]
    nearer = [i for i, (lower, _, found) in enumerate(pairs) if found < lower - 1e-6]
    farther = [i for i, (_, upper, found) in enumerate(pairs) if upper > found + max(1e-3, 0.01 * found) + 1e-6]
    wrong = nearer + farther
    return EdgeAgreement(voice, len(pairs), len(wrong), 0, 0, f"edge {wrong[0]}" if wrong else "")
