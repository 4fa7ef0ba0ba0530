"""Reader of edge files (straight motions in joint space), and the order in which samples of an edge are checked."""

from __future__ import annotations

import math
from collections import deque

import numpy as np


def read(path: str) -> dict[str, np.ndarray]:
    """Sets of edges: of each edge the state where it begins and that where it ends."""
    with open(path, encoding="utf-8") as file:
        lines = file.read().split("\n")
    sets, at = {}, 0
    while lines[at]:
        what, name, count = lines[at].split("\t")
        if what != "edges":
            raise ValueError(f"{path}: no edges in '{lines[at]}'")
        ends = lines[at + 1 : at + 1 + 2 * int(count)]
        sets[name] = np.array([line.split("\t") for line in ends], float).reshape(int(count), 2, -1)
        at += 1 + 2 * int(count)
    return sets


def steps(edge: np.ndarray, step: float) -> int:
    """Into how many equal steps an edge is cut so that none is longer than `step`."""
    return max(1, math.ceil(float(np.linalg.norm(edge[1] - edge[0])) / step - 1e-9))


def in_turn(count: int) -> np.ndarray:
    """Fractions of the edge, one after the other."""
    return np.arange(count + 1) / count


def van_der_corput(count: int) -> np.ndarray:
    """The ends, then the middles of ever shorter pieces: it finds a hit somewhere soonest.

    The end first, for it is the start of which planners know that it is free.
    """
    order, pieces = [count, 0], deque([(0, count)])
    while pieces:
        low, high = pieces.popleft()
        middle = (low + high) // 2
        if middle > low:
            order.append(middle)
            pieces += [(low, middle), (middle, high)]
    return np.array(order) / count
