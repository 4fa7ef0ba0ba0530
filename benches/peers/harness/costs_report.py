"""Report section on the cost model of bounding volume types; it can be written alone."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .markdown import table
from .results import MeshPairResult

START, END = "## Cost model\n", "## Answers\n"

MODEL = "T = N_bv · C_bv + N_p · C_p (Gottschalk, Lin & Manocha 1996), a pose."


@dataclass(frozen=True)
class Cost:
    volume: str
    question: str
    n_bv: float
    c_bv: float
    n_p: float
    c_p: float

    @classmethod
    def read(cls, line: str) -> Cost:
        volume, question, *numbers = line.split()
        return cls(volume, question, *map(float, numbers))

    @property
    def microseconds(self) -> float:
        return (self.n_bv * self.c_bv + self.n_p * self.c_p) / 1e3


def costs(pairs: list[MeshPairResult], conditions: list[str]) -> list[str]:
    parts = [START.strip(), "", MODEL, "", *conditions]
    found = {pair.name: [Cost.read(line) for line in pair.costs] for pair in pairs}
    head = ["pair", "volume", "question", "N_bv", "C_bv (ns)", "N_p", "C_p (ns)", "T (µs)"]
    rows = [_row(pair, cost) for pair, each in found.items() for cost in each]
    if not rows:
        return [*parts, "The library does not tell it yet.", ""]
    means = table(["volume", "free", "distance"], _relative(found))
    return [*parts, "T relative to that of OBB, geometric mean of the pairs:", "", *means, *table(head, rows)]


def put(text: str, section: list[str]) -> str:
    """The report with the section in the place of the one it had, else at the end."""
    before, _, rest = text.partition(START)
    _, head, after = rest.partition(END)
    return f"{before.rstrip()}\n\n{chr(10).join(section).strip()}\n" + (f"\n{head}{after}" if head else "")


def _row(pair: str, cost: Cost) -> list[str]:
    numbers = [f"{cost.n_bv:.1f}", f"{cost.c_bv:.2f}", f"{cost.n_p:.1f}", f"{cost.c_p:.2f}"]
    return [pair, cost.volume, cost.question, *numbers, f"{cost.microseconds:.2f}"]


def _relative(found: dict[str, list[Cost]]) -> list[list[str]]:
    times = {(pair, c.volume, c.question): c.microseconds for pair, each in found.items() for c in each}
    volumes = dict.fromkeys(volume for _, volume, _ in times)

    def mean(volume: str, question: str) -> str:
        logarithms = [math.log(times[pair, volume, question] / times[pair, "OBB", question]) for pair in found]
        return f"{math.exp(sum(logarithms) / len(logarithms)):.2f}"

    return [[volume, mean(volume, "free"), mean(volume, "distance")] for volume in volumes]
