"""Compares the results of contestants: counts and sizes of disagreements per query."""

from __future__ import annotations

from dataclasses import dataclass

from .race import Voice

# How far (m) two exact distances may differ. Coal's and FCL's GJK stop at a relative 1e-6.
DISTANCE_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Agreement:
    """How one voice's answers compare with this library's."""

    voice: str
    compared: int
    different: int
    worst: float
    example: str


def differs(question: str, reference: str, other: str) -> float:
    """0 for the same answer, else how far off it is (m); infinite where there is no measure."""
    if reference == other:
        return 0.0
    if question == "pairs":
        return 0.0 if set(reference.split(",")) == set(other.split(",")) else float("inf")
    if question == "free" or "far" in (reference, other):
        return float("inf")
    return abs(float(reference) - float(other))


def compare(voices: list[Voice], question: str, states: str) -> list[Agreement]:
    """Compares every voice with the first one that answers."""
    found: list[Agreement] = []
    reference: list[str] | None = None
    for voice in voices:
        responses = voice.child.ask("answers", question + voice.manner, states)
        if responses is None:
            continue
        if reference is None:
            reference = responses
            continue
        if len(responses) != len(reference):
            other = "another number of answers"
            found.append(Agreement(voice.name, len(reference), len(reference), float("inf"), other))
            continue
        off = [differs(question, r, a) for r, a in zip(reference, responses)]
        wrong = [i for i, d in enumerate(off) if d > DISTANCE_TOLERANCE]
        example = f"state {wrong[0]}: {reference[wrong[0]]} here, {responses[wrong[0]]} there" if wrong else ""
        found.append(Agreement(voice.name, len(off), len(wrong), max(off, default=0.0), example))
    return found
