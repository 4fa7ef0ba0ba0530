"""Converts states to Pinocchio's joint order: continuous joints as cosine and sine, mimic joints as own values."""

from __future__ import annotations

import neutral
import numpy as np
import pinocchio as pin


class Joints:
    def __init__(self, model: pin.Model, robot: neutral.Robot) -> None:
        self._width, self._rest = model.nq, pin.neutral(model)
        moving = [link for link in robot.links.values() if link.kind in ("turns", "slides")]
        joints = [model.joints[model.getJointId(link.joint)] for link in moving]
        plain = [(link, joint.idx_q) for link, joint in zip(moving, joints) if joint.nq == 1]
        circles = [(link, joint.idx_q) for link, joint in zip(moving, joints) if joint.nq == 2]
        self._plain, self._plain_at = _values(plain), [at for _, at in plain]
        self._circles, self._circles_at = _values(circles), np.array([at for _, at in circles], int)

    def states(self, states: np.ndarray) -> np.ndarray:
        """Many states at once, a row each."""
        out = np.empty((len(states), self._width))
        out[:] = self._rest
        out[:, self._plain_at] = _of(states, self._plain)
        if len(self._circles_at):
            angles = _of(states, self._circles)
            out[:, self._circles_at] = np.cos(angles)
            out[:, self._circles_at + 1] = np.sin(angles)
        return out


# Which position of a state, its factor, its offset: one of each for every joint.
Values = tuple[list[int], np.ndarray, np.ndarray]


def _values(joints: list[tuple[neutral.Link, int]]) -> Values:
    links = [link for link, _ in joints]
    factors, offsets = np.array([link.factor for link in links]), np.array([link.offset for link in links])
    return [link.position for link in links], factors, offsets


def _of(states: np.ndarray, values: Values) -> np.ndarray:
    positions, factors, offsets = values
    return states[:, positions] * factors + offsets
