"""Generates random edges for all contestants: straight motions in joint space, free or colliding according to Coal."""

from __future__ import annotations

import math
import random
import time
from dataclasses import dataclass
from pathlib import Path

from .contestant_process import Child, Failed

# Euclidean norms of the change of all positions (rad, m alike).
LENGTHS = (0.1, 0.2, 0.5, 1.0, 2.0)

# Lengths of which colliding edges are wanted, too: on shorter ones contact is rare.
COLLIDING_LENGTHS = (0.5, 1.0, 2.0)

# How far apart (rad) the samples of the judge are; it is Coal.
JUDGED_EVERY = 0.005

# Edges are drawn and judged until there are enough of both kinds, or so many times as many.
MOST_TRIES = 10

# So many directions in a row that leave the limits: then joints that leave them stand still.
MOST_DIRECTIONS = 1000

State = list[float]


@dataclass(frozen=True)
class Space:
    """Where edges may begin, and between which limits they stay."""

    limits: list[tuple[float, float]]
    starts: list[State]

    def goal(self, draw: random.Random, start: State, length: float) -> State | None:
        moving = [k for k, (lower, upper) in enumerate(self.limits) if upper > lower]
        for _ in range(MOST_DIRECTIONS):
            direction = _unit(draw, moving)
            goal = _moved(start, direction, length)
            leaving = self._leaving(goal)
            if not leaving:
                return goal
        while leaving:
            direction = {k: d for k, d in direction.items() if k not in leaving}
            norm = math.hypot(*direction.values())
            if norm == 0:
                return None
            direction = {k: d / norm for k, d in direction.items()}
            goal = _moved(start, direction, length)
            leaving = self._leaving(goal)
        return goal

    def _leaving(self, q: State) -> set[int]:
        return {k for k, (x, (lower, upper)) in enumerate(zip(q, self.limits)) if not lower <= x <= upper}


def _unit(draw: random.Random, moving: list[int]) -> dict[int, float]:
    """Uniform on the unit sphere."""
    direction = {k: draw.gauss(0, 1) for k in moving}
    norm = math.hypot(*direction.values())
    return {k: d / norm for k, d in direction.items()}


def _moved(start: State, direction: dict[int, float], length: float) -> State:
    return [x + length * direction.get(k, 0.0) for k, x in enumerate(start)]


@dataclass(frozen=True)
class Edge:
    start: State
    goal: State


def draw_edges(
    neutral: Path, coal: Child, out: Path, seed: int, wanted: int, patience: float
) -> dict[str, int]:
    """Writes sets `free-LENGTH` and `colliding-LENGTH` into `out`; how many edges each has.

    `coal` has loaded the neutral file; it tells the free edges from those that collide, so that this library has no
    say in what is asked. Where colliding edges are rare, the search for more of them ends after `patience` (s) for each
    length; those that are found are the same in every run.
    """
    space = _space(neutral, coal)
    sets: dict[str, list[Edge]] = {}
    for length in LENGTHS:
        draw = random.Random(f"{seed} {length}")
        sets |= _of_length(draw, space, coal, out, length, wanted, time.monotonic() + patience)
    _write(out, sets)
    return {name: len(edges) for name, edges in sets.items()}


def name_of(kind: str, length: float) -> str:
    return f"{kind}-{length:g}"


def _of_length(
    draw: random.Random, space: Space, coal: Child, scratch: Path, length: float, wanted: int, end: float
) -> dict[str, list[Edge]]:
    found: dict[str, list[Edge]] = {"1": [], "0": []}
    enough = {"1": wanted, "0": wanted if length in COLLIDING_LENGTHS else 0}
    for _ in range(MOST_TRIES):
        colliding_enough = len(found["0"]) >= enough["0"] or time.monotonic() > end
        if not space.starts or (len(found["1"]) >= enough["1"] and colliding_enough):
            break
        starts = [draw.choice(space.starts) for _ in range(wanted)]
        edges = [Edge(s, goal) for s in starts if (goal := space.goal(draw, s, length)) is not None]
        _write(scratch, {"drawn": edges})
        coal.ask("edges", scratch)
        for edge, word in zip(edges, coal.ask("answers", f"edge-any-{JUDGED_EVERY}", "drawn") or []):
            if len(found[word]) < enough[word]:
                found[word].append(edge)
    return {name_of(kind, length): found[word] for kind, word in (("free", "1"), ("colliding", "0")) if found[word]}


def _space(neutral: Path, coal: Child) -> Space:
    limits, states = [], []
    with open(neutral, encoding="utf-8") as lines:
        for line in lines:
            what, *words = line.rstrip("\n").split("\t")
            if what == "limits":
                limits.append((float(words[0]), float(words[1])))
            elif what == "states" and words[0] == "free":
                states = [[float(x) for x in next(lines).split("\t")] for _ in range(int(words[1]))]
    free = coal.ask("answers", "free", "free") if states else []
    if free is None or len(free) != len(states):
        raise Failed(f"{coal.name}: another number of answers than states")
    return Space(limits, [q for q, word in zip(states, free) if word == "1"])


def _write(out: Path, sets: dict[str, list[Edge]]) -> None:
    with open(out, "w", encoding="utf-8") as file:
        for name, edges in sets.items():
            print("edges", name, len(edges), sep="\t", file=file)
            for edge in edges:
                print(*edge.start, sep="\t", file=file)
                print(*edge.goal, sep="\t", file=file)
