"""Time: every contestant in turn, round after round, so that what disturbs the machine disturbs all alike."""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass

from .child import Child

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
    """Microseconds of thread CPU time a state."""

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
    limit: dict[Voice, int] = {}
    for voice in voices:
        # the first pass warms caches and branch predictors, and tells how long passes are
        first = voice.child.ask("pass", question + voice.manner, states, 1)
        if first is None:
            continue
        spent = max(float(first[0]), 1.0)
        repeats[voice] = max(1, math.ceil(SHORTEST_PASS / spent))
        limit[voice] = max(2, min(rounds, int(patience * 1e9 / (spent * repeats[voice]))))
    passes: dict[Voice, list[float]] = {voice: [] for voice in repeats}
    for turn in range(rounds):
        for voice, times in passes.items():
            if turn < limit[voice]:
                words = voice.child.ask("pass", question + voice.manner, states, repeats[voice])
                assert words is not None
                times.append(float(words[0]) / repeats[voice] / count / 1e3)
    return {v.name: Timing(min(times), statistics.median(times), len(times)) for v, times in passes.items()}
