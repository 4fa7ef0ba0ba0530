"""Writes a planning problem as a text file for the C++ programs: see problem.hpp."""

import numpy as np
import pinocchio as pin

from problems import GROUP, matrix


def write(problem, path):
    """Writes links, joints and pairs as Pinocchio reads them from the URDF; the pairs are those of the checker."""
    model = pin.buildModelFromUrdf(str(problem.urdf))
    geometry = pin.buildGeomFromUrdf(model, str(problem.urdf), pin.COLLISION, package_dirs=[str(problem.packages)])
    names = [model.frames[thing.parentFrame].name for thing in geometry.geometryObjects]
    if len(set(names)) != len(names):
        raise ValueError("a link has several meshes")
    names += [obstacle["name"] for obstacle in problem.obstacles]
    words = [problem.urdf, problem.srdf, problem.packages, GROUP, len(problem.other_joints)]
    for name, value in problem.other_joints.items():
        words += [name, value]
    words += [len(problem.allowed_pairs), *(name for pair in problem.allowed_pairs for name in pair)]
    words += [len(problem.start), *problem.start, *problem.goal, model.njoints - 1]
    for i in range(1, model.njoints):
        words += _joint(model, i, problem)
    words.append(len(geometry.geometryObjects))
    for name, thing in zip(names, geometry.geometryObjects):
        words += [name, thing.parentJoint - 1, *_pose(thing.placement.homogeneous), *_mesh(thing)]
    words.append(len(problem.obstacles))
    for obstacle in problem.obstacles:
        words += [obstacle["name"], -1, *_pose(matrix(obstacle)), *_shape(obstacle["shape"])]
    pairs = problem.checker.pairs
    words += [len(pairs), *(names.index(name) for pair in pairs for name in pair)]
    path.write_text(" ".join(map(_word, words)) + "\n")


def _word(word):
    return repr(float(word)) if isinstance(word, float) else str(word)


def _joint(model, i, problem):
    joint, name = model.joints[i], model.names[i]
    if joint.nq != 1:
        raise ValueError(f"joint {name} has {joint.nq} positions; problem files have joints of one")
    data = joint.createData()
    joint.calc(data, pin.neutral(model), np.zeros(model.nv))
    motion = np.reshape(data.S, -1)
    is_prismatic = bool(motion[:3].any())
    axis = motion[:3] if is_prismatic else motion[3:]
    names = problem.checker.joint_names
    column = names.index(name) if name in names else -1
    return [model.parents[i] - 1, int(is_prismatic), *map(float, axis), *_pose(model.jointPlacements[i].homogeneous), column,
            float(problem.other_joints.get(name, 0.0))]


def _pose(pose):
    return [float(value) for value in np.asarray(pose)[:3].ravel()]


def _mesh(thing):
    mesh = thing.geometry
    vertices = np.asarray(mesh.vertices())
    triangles = [mesh.tri_indices(i) for i in range(mesh.num_tris)]
    return ["mesh", len(vertices), len(triangles), *map(float, vertices.ravel()), *(triangle[k] for triangle in triangles for k in range(3))]


def _shape(shape):
    if shape["type"] == "box":
        return ["box", *map(float, shape["size"])]
    return ["cylinder", float(shape["radius"]), float(shape["length"])]
