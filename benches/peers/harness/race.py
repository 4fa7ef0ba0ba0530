"""CPU time measurement: the contestants run in turn, round after round, so that disturbances affect all alike."""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass

from .contestant_process import Child

# A pass longer than this (ns) needs no other to warm up before it.
LONG_PASS = 1e9

# A pass shorter than this (ns) is repeated until it lasts: clocks and caches need that.
SHORTEST_PASS = 30e6


@dataclass(frozen=True)
class Voice:
    """A contestant: one process, asked in one manner. This library's process has several manners."""

    name: str
    child: Child
    manner: str = ""


@dataclass(frozen=True)
class Timing:
    """Microseconds of CPU time a state."""

    best: float
    median: float
    passes: int


def race(
    voices: list[Voice], question: str, states: str, count: int, rounds: int, patience: float
) -> dict[str, Timing]:
    """Times `question` about `count` states; voices that do not know it are left out.

    A voice whose passes together would take longer than `patience` (s) rests early, but never before its second pass.
    """
    repeats: dict[Voice, int] = {}
    passes: dict[Voice, list[float]] = {}
    for voice in voices:
        # the first pass warms caches and branch predictors, and tells how long passes are
        first = _pass(voice, question, states, 1)
        if first is not None:
            repeats[voice] = max(1, math.ceil(SHORTEST_PASS / first))
            passes[voice] = [first] if first > LONG_PASS else []
    for _ in range(rounds):
        for voice, times in passes.items():
            if len(times) < 2 or (len(times) < rounds and sum(times) * repeats[voice] < patience * 1e9):
                spent = _pass(voice, question, states, repeats[voice])
                assert spent is not None
                times.append(spent / repeats[voice])
    per_state = {voice: [time / count / 1e3 for time in times] for voice, times in passes.items()}
    return {v.name: Timing(min(times), statistics.median(times), len(times)) for v, times in per_state.items()}


def _pass(voice: Voice, question: str, states: str, repeats: int) -> float | None:
    """Nanoseconds of CPU time of the voice's process; None for a question it does not know."""
    words = voice.child.ask("pass", question + voice.manner, states, repeats)
    return None if words is None else max(float(words[0]), 1.0)
