"""Clearance with gradients against Pinocchio's distances with Jacobians, from Python, on one core in one run.

python3 benches/peers/gradients.py [--robots panda,ur5e,pr2] [--states 40] [--rounds 3]

Needs the package `clearance` and `requirements.txt`; robots come from `../shared/robots`, or from `urdf` where that folder is not there.
Both take the same free states and the same pairs, and report pairs within 0.1 m with their derivatives by all joints. Pairs that collide
in more than a fifth of random states are left out for both. CPU time of the process (µs a state), the least of the rounds.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import clearance as cl
import numpy as np
import pinocchio as pin

ROOT = Path(__file__).resolve().parents[2]
INFLUENCE = 0.1
SAMPLES = 40


def description(name: str) -> tuple[Path, Path, Path]:
    """URDF, SRDF and package folder of a robot."""
    folder = ROOT.parent / "shared" / "robots"
    listing = folder / "robots.json"
    for robot in json.loads(listing.read_text()) if listing.exists() else []:
        if robot["name"] == name:
            return folder / robot["urdf"], folder / robot["srdf"], folder / robot["package_root"]
    own = ROOT / "urdf" / name
    return own / f"{name}.urdf", own / f"{name}.srdf", own


def random_state(robot: cl.Robot, rng: np.random.Generator) -> np.ndarray:
    lower = np.where(np.isfinite(robot.lower), robot.lower, -np.pi)
    return rng.uniform(lower, np.where(np.isfinite(robot.upper), robot.upper, np.pi))


def checker_of(name: str, rng: np.random.Generator) -> cl.Checker:
    urdf, srdf, packages = description(name)
    robot = cl.Robot.from_urdf(urdf, srdf, [packages])
    checker = cl.Checker(robot)
    hits = Counter(pair for _ in range(SAMPLES) for pair in checker.check(random_state(robot, rng)).pairs)
    usual = [pair for pair, count in hits.items() if count > SAMPLES / 5]
    entries = "".join(f'<disable_collisions link1="{a}" link2="{b}" reason="Default"/>' for a, b in usual)
    text = srdf.read_text().replace("</robot>", entries + "</robot>")
    return cl.Checker(cl.Robot.from_urdf(urdf, text, [packages]))


class Pinocchio:
    """Distances of all pairs, and for near ones the derivative nᵀ (J_b(q) − J_a(p)) at the nearest points."""

    def __init__(self, name: str, checker: cl.Checker) -> None:
        urdf, _, packages = (str(path) for path in description(name))
        self.robot = checker.robot
        self.model = pin.buildModelFromUrdf(urdf)
        self.geometry = pin.buildGeomFromUrdf(self.model, urdf, pin.GeometryType.COLLISION, package_dirs=[packages])
        of_link: dict[str, list[int]] = {}
        for index, solid in enumerate(self.geometry.geometryObjects):
            of_link.setdefault(self.model.frames[solid.parentFrame].name, []).append(index)
        self.geometry.removeAllCollisionPairs()
        for a, b in checker.pairs:
            for i in of_link[a]:
                for j in of_link[b]:
                    self.geometry.addCollisionPair(pin.CollisionPair(i, j))
        self.data, self.geometry_data = self.model.createData(), self.geometry.createData()

    def state(self, q: np.ndarray) -> np.ndarray:
        values = dict(zip(self.robot.joint_names, q))
        for joint, (leader, multiplier, offset) in self.robot.mimics.items():
            values[joint] = multiplier * values[leader] + offset
        state = pin.neutral(self.model)
        for joint, value in values.items():
            place = self.model.joints[self.model.getJointId(joint)]
            state[place.idx_q : place.idx_q + place.nq] = (
                [value] if place.nq == 1 else [np.cos(value), np.sin(value)]
            )
        return state

    def gradients(self, state: np.ndarray) -> list[np.ndarray]:
        pin.computeDistances(self.model, self.data, self.geometry, self.geometry_data, state)
        pin.computeJointJacobians(self.model, self.data)
        results = zip(self.geometry.collisionPairs, self.geometry_data.distanceResults)
        return [self.row(pair, found) for pair, found in results if found.min_distance <= INFLUENCE]

    def row(self, pair: pin.CollisionPair, found: object) -> np.ndarray:
        p, q = found.getNearestPoint1(), found.getNearestPoint2()
        normal = (q - p) / np.linalg.norm(q - p)
        return self.derivative(pair.second, q, normal) - self.derivative(pair.first, p, normal)

    def derivative(self, solid: int, point: np.ndarray, normal: np.ndarray) -> np.ndarray:
        joint = self.geometry.geometryObjects[solid].parentJoint
        jacobian = pin.getJointJacobian(self.model, self.data, joint, pin.LOCAL_WORLD_ALIGNED)
        arm = point - self.data.oMi[joint].translation
        return normal @ jacobian[:3] + np.cross(arm, normal) @ jacobian[3:]


def race(contestants: list[tuple[Callable[[np.ndarray], object], list[np.ndarray]]], rounds: int) -> list[float]:
    """Microseconds a state of each contestant; all take their turn in each round."""
    least = [np.inf] * len(contestants)
    for _ in range(rounds):
        for k, (call, states) in enumerate(contestants):
            start = time.process_time()
            for state in states:
                call(state)
            least[k] = min(least[k], (time.process_time() - start) / len(states) * 1e6)
    return least


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", default="panda,ur5e,pr2")
    parser.add_argument("--states", type=int, default=40)
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    for name in arguments.robots.split(","):
        rng = np.random.default_rng(1)
        checker = checker_of(name, rng)
        other = Pinocchio(name, checker)
        states: list[np.ndarray] = []
        while len(states) < arguments.states:
            q = random_state(checker.robot, rng)
            if checker.is_free(q):
                states.append(q)
        ours, theirs = race(
            [
                (lambda q: checker.clearance(q, INFLUENCE), states),
                (other.gradients, [other.state(q) for q in states]),
            ],
            arguments.rounds,
        )
        pairs = len(checker.pairs)
        print(f"{name:10} {pairs:5} pairs: clearance {ours:9.1f} µs, Pinocchio {theirs:9.1f} µs, {theirs / ours:.1f}x")


if __name__ == "__main__":
    main()
