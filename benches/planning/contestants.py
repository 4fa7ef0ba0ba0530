"""Contestants of the planning benchmark: collision checkers with the calls that their Python users make.

Each is made from a problem, and checks states: rows of an array (k, 7).
"""

import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from problems import matrix
from vamp_planner import problem_of_vamp


class Clearance:
    def __init__(self, problem):
        self.checker = problem.checker

    def check(self, states):
        return self.checker.is_free(states, num_threads=2)


class ClearanceOneByOne(Clearance):
    def check(self, states):
        is_free = self.checker.is_free
        return [is_free(q) for q in states]


class PinocchioCoal:
    def __init__(self, problem):
        from oracle import Oracle

        self._oracle = Oracle(problem)

    def check(self, states):
        return ~self._oracle.collide(states)


class Roboplan:
    def __init__(self, problem):
        from planners import Roboplan as Planner

        self._scene = Planner("roboplan", problem).scene
        self._indices = self._scene.getJointPositionIndices(problem.checker.joint_names)

    def check(self, states):
        q, has_collisions = self._scene.getCurrentJointPositions(), self._scene.hasCollisions
        free = []
        for state in states:
            q[self._indices] = state
            free.append(not has_collisions(q))
        return free


class Vamp:
    """Spheres, in single precision; the fingers are where VAMP's Panda has them."""

    def __init__(self, problem):
        import vamp
        from vamp_planner import environment

        self._environment, self._validate = environment(problem_of_vamp(problem)), vamp.panda.validate

    def check(self, states):
        validate, environment = self._validate, self._environment
        return [validate(q, environment) for q in states.astype(np.float32)]


class Drake:
    """SceneGraphCollisionChecker. Drake takes the convex hulls of meshes."""

    def __init__(self, problem):
        from pydrake.planning import RobotDiagramBuilder, SceneGraphCollisionChecker

        builder = RobotDiagramBuilder(time_step=0.0)
        with tempfile.TemporaryDirectory() as folder:
            [robot] = builder.parser().AddModels(str(_urdf_with_obj_meshes(problem, Path(folder))))
            plant = builder.plant()
            plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("panda_link0"))
            self._add_obstacles(plant, problem)
            plant.Finalize()
            model = builder.Build()
        self._checker = SceneGraphCollisionChecker(
            model=model,
            robot_model_instances=[robot],
            configuration_distance_function=lambda a, b: np.linalg.norm(a - b),
            edge_step_size=0.05,
        )
        self._filter_pairs(problem)
        plant = self._checker.plant()
        names = [*problem.checker.joint_names, *problem.other_joints]
        starts = {name: plant.GetJointByName(name).position_start() for name in names}
        self._q = np.zeros(plant.num_positions())
        for name, value in problem.other_joints.items():
            self._q[starts[name]] = value
        self._columns = [starts[name] for name in problem.checker.joint_names]

    @staticmethod
    def _add_obstacles(plant, problem):
        from pydrake.geometry import Box, Cylinder
        from pydrake.math import RigidTransform
        from pydrake.multibody.plant import CoulombFriction

        for obstacle in problem.obstacles:
            shape, pose = obstacle["shape"], RigidTransform(matrix(obstacle))
            made = Box(*shape["size"]) if shape["type"] == "box" else Cylinder(shape["radius"], shape["length"])
            plant.RegisterCollisionGeometry(plant.world_body(), pose, made, obstacle["name"], CoulombFriction())

    def _filter_pairs(self, problem):
        """Only the pairs of links that clearance checks."""
        plant = self._checker.plant()
        checked = {frozenset(pair) for pair in problem.checker.pairs}
        names = problem.checker.robot.link_names
        bodies = [plant.GetBodyByName(name) for name in names if plant.HasBodyNamed(name)]
        for i, a in enumerate(bodies):
            for b in bodies[:i]:
                if frozenset((a.name(), b.name())) not in checked and not self._checker.IsCollisionFilteredBetween(a, b):
                    self._checker.SetCollisionFilteredBetween(a, b, True)

    def check(self, states):
        q, is_free = self._q, self._checker.CheckConfigCollisionFree
        free = []
        for state in states:
            q[self._columns] = state
            free.append(is_free(q))
        return free


def _urdf_with_obj_meshes(problem, folder):
    """The URDF without visuals and with OBJ files: Drake reads no STL files."""
    import pinocchio as pin

    model = pin.buildModelFromUrdf(str(problem.urdf))
    geometry = pin.buildGeomFromUrdf(model, str(problem.urdf), pin.COLLISION, package_dirs=[str(problem.packages)])
    meshes = {}
    for thing in geometry.geometryObjects:
        mesh, file = thing.geometry, folder / f"{thing.name}.obj"
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(mesh.vertices()).tolist()]
        for i in range(mesh.num_tris):
            triangle = mesh.tri_indices(i)
            lines.append("f " + " ".join(str(triangle[k] + 1) for k in range(3)))
        file.write_text("\n".join(lines) + "\n")
        meshes[model.frames[thing.parentFrame].name] = file
    root = ET.parse(problem.urdf).getroot()
    for link in root.iter("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
        for mesh in link.iter("mesh"):
            mesh.attrib = {"filename": str(meshes[link.get("name")])}
    urdf = folder / "panda.urdf"
    ET.ElementTree(root).write(urdf)
    return urdf


CONTESTANTS = {
    "clearance": Clearance,
    "clearance, one call a state": ClearanceOneByOne,
    "Pinocchio + Coal": PinocchioCoal,
    "Drake": Drake,
    "roboplan": Roboplan,
    "VAMP (spheres)": Vamp,
}
