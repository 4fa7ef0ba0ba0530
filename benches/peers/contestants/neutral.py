"""Reader of the neutral file format, and the command loop of all Python contestants. README.md describes both."""

from __future__ import annotations

import gc
import math
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import edges
import numpy as np


@dataclass
class Link:
    id: str
    name: str
    joint: str
    parent: str
    kind: str
    position: int
    factor: float
    offset: float
    axis: np.ndarray
    origin: np.ndarray
    vertices: list[np.ndarray] = field(default_factory=list)
    triangles: list[np.ndarray] = field(default_factory=list)

    def value(self, q: np.ndarray) -> float:
        """The position of the link's joint in a state: a joint that mimics another follows it."""
        return self.factor * q[self.position] + self.offset


@dataclass
class Primitive:
    shape: str
    link: str
    sizes: list[float]
    pose: np.ndarray


@dataclass
class Robot:
    """Links with parents first; poses are 4x4 matrices."""

    links: dict[str, Link] = field(default_factory=dict)
    primitives: list[Primitive] = field(default_factory=list)
    # points of worlds, whose links are where the root is
    clouds: list[np.ndarray] = field(default_factory=list)
    pairs: list[tuple[str, str]] = field(default_factory=list)
    states: dict[str, np.ndarray] = field(default_factory=dict)

    def chosen(self, name: str) -> np.ndarray:
        """The states of `name`, or of `name:count` the first few."""
        return first_few(self.states, name)

    def link_poses(self, q: np.ndarray) -> dict[str, np.ndarray]:
        poses: dict[str, np.ndarray] = {}
        for link in self.links.values():
            motion = np.eye(4)
            if link.kind == "turns":
                x, y, z = link.axis
                cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
                angle = link.value(q)
                motion[:3, :3] += math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
            elif link.kind == "slides":
                motion[:3, 3] = link.axis * link.value(q)
            parent = poses.get(link.parent, np.eye(4))
            poses[link.id] = parent @ link.origin @ motion
        return poses


def _pose(words: list[str]) -> np.ndarray:
    return np.vstack([np.array(words, float).reshape(3, 4), [0, 0, 0, 1]])


def read(path: str) -> Robot:
    with open(path, encoding="utf-8") as file:
        lines = file.read().split("\n")
    if not lines[0].startswith("neutral\t1\t"):
        raise ValueError(f"{path} is not in the neutral form")
    robot, at = Robot(), 1

    def rows(count: int, kind: type) -> np.ndarray:
        nonlocal at
        at += count
        return np.array([line.split("\t") for line in lines[at - count : at]], dtype=object).astype(kind)

    while lines[at]:
        what, *words = lines[at].split("\t")
        at += 1
        if what == "link":
            identity, name, joint, parent, kind, position, factor, offset, *rest = words
            axis, origin = np.array(rest[:3], float), _pose(rest[3:])
            robot.links[identity] = Link(
                identity, name, joint, parent, kind, int(position), float(factor), float(offset), axis, origin
            )
        elif what == "mesh":
            link = robot.links[words[0]]
            first = sum(len(v) for v in link.vertices)
            link.vertices.append(rows(int(words[1]), float))
            link.triangles.append(rows(int(words[2]), int) + first)
        elif what == "cloud":
            robot.clouds.append(rows(int(words[1]), float))
        elif what == "pair":
            robot.pairs.append((words[0], words[1]))
        elif what == "states":
            robot.states[words[0]] = rows(int(words[1]), float)
        elif what != "limits":  # those are for who draws edges
            sizes, pose = [float(w) for w in words[1:-12]], _pose(words[-12:])
            robot.primitives.append(Primitive(what, words[0], sizes, pose))
    return robot


def first_few(sets: Mapping[str, Any], name: str) -> Any:
    """What `name` names or, written `name:count`, the first few."""
    name, _, count = name.partition(":")
    return sets[name][: int(count)] if count else sets[name]


class Contestant(Protocol):
    """What a Python contestant must have: calls that take nothing but the state or edge, and answers in words."""

    def load(self, words: list[str]) -> None: ...

    def take_edges(self, sets: dict[str, np.ndarray]) -> None:
        """These edges take the place of those it had. What is prepared here is not timed."""

    def calls(self, question: str, states: str) -> tuple[Callable[[object], object], list[object]] | None:
        """What is timed: a function, and what it is called with; None for a question it does not know."""

    def responses(self, question: str, states: str) -> Iterable[str]: ...


@runtime_checkable
class AmongObstacles(Protocol):
    """What a Python contestant must have besides to be asked about worlds."""

    def take_world(self, world: Robot) -> None:
        """These obstacles take the place of those it had."""


def serve(contestant: Contestant) -> None:
    """Answers lines until they end. The collector of garbage rests while time is taken, as `timeit` does it."""
    for line in sys.stdin:
        words = line.rstrip("\n").split("\t")
        try:
            reply = _reply(contestant, words)
        except Exception as error:  # whatever a peer throws is told, and the comparison goes on without it
            reply = "error\t" + f"{type(error).__name__}: {error}".replace("\n", " ").replace("\t", " ")
        print(reply, flush=True)


def _reply(contestant: Contestant, words: list[str]) -> str:
    if words[0] == "load":
        contestant.load(words[1:])
        return "ok\t"
    if words[0] == "edges":
        contestant.take_edges(edges.read(words[1]))
        return "ok\t"
    if words[0] == "world":
        if not isinstance(contestant, AmongObstacles):
            return "unsupported"
        contestant.take_world(read(words[1]))
        return "ok\t"
    calls = contestant.calls(words[1], words[2])
    if calls is None:
        return "unsupported"
    if words[0] == "answers":
        return "ok\t" + "\t".join(contestant.responses(words[1], words[2]))
    call, arguments = calls
    gc.collect()
    gc.disable()
    start = time.process_time_ns()
    for _ in range(int(words[3])):
        for argument in arguments:
            call(argument)
    spent = time.process_time_ns() - start
    gc.enable()
    return f"ok\t{spent}"
