"""Planning problems of the Panda, from a folder of scenes with boxes and cylinders, for clearance."""

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import clearance as cl

GROUP = "panda_arm"


@dataclass
class Problem:
    name: str
    scene: str
    urdf: Path
    srdf: Path
    packages: Path
    obstacles: list
    allowed_pairs: list
    other_joints: dict
    start: np.ndarray
    goal: np.ndarray
    checker: cl.Checker

    def with_fingers_at(self, position):
        """The same with open fingers (m); None if start or goal then collide. The position may be beyond the limits of the joints."""
        fixed = dict.fromkeys(self.other_joints, position)
        options = dict(group=GROUP, fixed=fixed, allowed_collisions=self.allowed_pairs)
        checker = cl.Checker(self.checker.robot, world_of(self.obstacles), **options)
        is_free = checker.is_free([self.start, self.goal]).all()
        return replace(self, other_joints=fixed, checker=checker) if is_free else None


def problems(shared, per_scene):
    """Those of every Panda scene of boxes and cylinders whose start and goal are free."""
    robots = shared / "robots"
    loaded = {}
    for file in sorted((shared / "scenes").glob("panda-*.json")):
        scene, count = json.loads(file.read_text()), 0
        urdf, srdf = robots / scene["robot_urdf"], robots / scene["robot_srdf"]
        if urdf not in loaded:
            loaded[urdf] = cl.Robot.from_urdf(urdf, srdf, [robots])
        for given in scene["problems"]:
            obstacles = [*scene.get("shared_obstacles", []), *given.get("obstacles", [])]
            if any(obstacle["shape"]["type"] == "mesh" for obstacle in obstacles):
                continue
            allowed = [tuple(pair) for pair in given.get("allowed_pairs") or []]
            options = dict(group=GROUP, fixed=given["other_joints"], allowed_collisions=allowed)
            checker = cl.Checker(loaded[urdf], world_of(obstacles), **options)
            ends = [np.array([given[end][name] for name in checker.joint_names]) for end in ("start", "goal")]
            inside = all(((checker.lower <= q) & (q <= checker.upper)).all() for q in ends)
            if inside and checker.is_free(ends).all() and count < per_scene:
                count += 1
                title = file.stem.removeprefix("panda-")
                yield Problem(f"{title} {given['id']}", title, urdf, srdf, robots, obstacles, allowed, given["other_joints"], *ends, checker)


def world_of(obstacles):
    world = cl.World()
    for obstacle in obstacles:
        shape, pose = obstacle["shape"], (obstacle["pose"]["xyz"], obstacle["pose"]["quat_xyzw"])
        if shape["type"] == "box":
            world.add_box(obstacle["name"], shape["size"], pose)
        else:
            world.add_cylinder(obstacle["name"], shape["radius"], shape["length"], pose)
    return world


def matrix(obstacle):
    """Pose of an obstacle as a homogeneous matrix."""
    world = world_of([obstacle])
    return world.pose(obstacle["name"])
