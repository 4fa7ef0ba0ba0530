"""Tests of simplified collision meshes: arrays, errors against samples, files, time limits, rejected arguments."""

import struct

import numpy as np
import pytest

import clearance as cl

RINGS, SEGMENTS = 24, 48


def ball(radius):
    """Vertices and faces of a sphere."""
    polar, around = np.linspace(0, np.pi, RINGS + 1)[1:-1], 2 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    theta, phi = np.meshgrid(polar, around, indexing="ij")
    inner = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    vertices = radius * np.concatenate([[[0, 0, 1]], inner.reshape(-1, 3), [[0, 0, -1]]])
    faces = []
    for j in range(SEGMENTS):
        k, last = (j + 1) % SEGMENTS, 1 + (RINGS - 2) * SEGMENTS
        faces += [(0, 1 + j, 1 + k), (len(vertices) - 1, last + k, last + j)]
        for i in range(RINGS - 2):
            a, b = 1 + i * SEGMENTS, 1 + (i + 1) * SEGMENTS
            faces += [(a + j, b + j, b + k), (a + j, b + k, a + k)]
    return vertices, np.array(faces)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A robot of a ball of 10 cm, written as OBJ in millimetres, and a box."""
    folder = tmp_path_factory.mktemp("ball")
    vertices, faces = ball(100.0)
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
    (folder / "ball.obj").write_text("\n".join(lines))
    (folder / "robot.urdf").write_text(
        """<robot name="ball">
  <link name="base"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <link name="tool">
    <collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>
    <collision>
      <origin xyz="0.3 0 0"/><geometry><mesh filename="ball.obj" scale="0.001 0.001 0.001"/></geometry>
    </collision>
  </link>
  <joint name="j" type="continuous"><parent link="base"/><child link="tool"/><axis xyz="0 0 1"/></joint>
</robot>"""
    )
    return folder


@pytest.fixture(scope="module")
def robot(folder):
    return cl.Robot.from_urdf(folder / "robot.urdf")


@pytest.fixture(scope="module")
def cover(robot):
    return robot.mesh_cover(excess=0.002, num_threads=2)


def points_of(vertices, faces, count=20_000):
    rng = np.random.default_rng(7)
    corners = vertices[faces[rng.integers(0, len(faces), count)]]
    return np.einsum("nc,ncx->nx", rng.dirichlet((1, 1, 1), count), corners)


def test_the_simplified_ball_is_as_near_as_is_proven(cover):
    (link,) = cover.links
    (mesh,) = link.meshes
    assert (link.link, mesh.collision, mesh.original_triangles) == ("tool", 1, len(ball(1)[1]))
    assert np.allclose(mesh.pose, [[1, 0, 0, 0.3], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    lower, upper = mesh.error
    assert 0 < lower <= upper <= 0.002 and link.error == mesh.error and cover.largest_error == upper
    # the ball of the original mesh is within its own error of a round one
    own = 0.1 * (1 - np.cos(np.pi / SEGMENTS) * np.cos(np.pi / RINGS / 2)) + 1e-9
    off = np.abs(np.linalg.norm(points_of(mesh.vertices, mesh.faces), axis=1) - 0.1)
    assert off.max() <= upper + own
    # a bound of half the error would be wrong
    assert off.max() > lower / 2
    assert np.linalg.norm(link.point - (0.3, 0, 0)) == pytest.approx(0.1, abs=upper + own)


def test_arrays(cover):
    mesh = cover.links[0].meshes[0]
    assert mesh.vertices.dtype == np.float64 and mesh.faces.dtype == np.int64
    assert mesh.vertices.shape[1:] == mesh.faces.shape[1:] == mesh.faces[0].shape == (3,)
    assert cover.triangles == len(mesh.faces) < cover.original_triangles == mesh.original_triangles
    assert set(mesh.faces.ravel()) == set(range(len(mesh.vertices)))
    assert len(cover) == 1 and not cover.ended_by_time and not cover.links[0].ended_by_time
    assert f"{cover.triangles} of {cover.original_triangles} triangles" in repr(cover)


def test_files(cover, folder, robot):
    mesh = cover.links[0].meshes[0]
    ((name, content),) = cover.files.items()
    assert name == mesh.file_name == "tool_2.stl"
    (count,) = struct.unpack_from("<I", content, 80)
    triangle = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    triangles = np.frombuffer(content, triangle, offset=84)["corners"]
    assert count == len(triangles) == len(mesh.faces)
    assert np.array_equal(triangles.astype(float), mesh.vertices[mesh.faces])
    (folder / "coarse").mkdir()
    (folder / "coarse" / name).write_bytes(content)
    (folder / "coarse.urdf").write_text(cover.to_urdf("coarse"))
    coarse = cl.Robot.from_urdf(folder / "coarse.urdf")
    assert coarse.link_names == robot.link_names
    world = cl.World()
    world.add_sphere("ball", 0.01, (0.5, 0, 0))
    distances = [cl.Checker(of, world, check_self=False).distance([0.0]).world_distance for of in (robot, coarse)]
    assert abs(distances[0] - distances[1]) <= cover.largest_error and distances[0] == pytest.approx(0.09, abs=1e-3)


def test_the_same_for_any_number_of_threads(robot, cover):
    again = robot.mesh_cover(excess=0.002, num_threads=1)
    assert again.files == cover.files


def test_a_count_bounds_the_triangles(robot):
    cover = robot.mesh_cover(count=100)
    assert cover.triangles <= 100 and 0 < cover.largest_error < 0.1


def test_a_timeout_keeps_the_proof(robot):
    short = robot.mesh_cover(count=10, timeout=0)
    assert short.ended_by_time and short.links[0].ended_by_time
    assert short.links[0].error[1] < 0.1


@pytest.mark.parametrize(
    ("arguments", "kind", "text"),
    [
        ({}, TypeError, "one of count and excess"),
        ({"count": 100, "excess": 0.1}, TypeError, "one of count and excess"),
        ({"count": 3}, ValueError, "count is 3, but must be a whole number, 4 or more"),
        ({"count": -1}, ValueError, "count is -1, but must be a whole number, 4 or more"),
        ({"count": 1.5}, TypeError, "count"),
        ({"excess": 0.0}, ValueError, "excess"),
        ({"excess": float("nan")}, ValueError, "excess"),
    ],
)
def test_errors(robot, arguments, kind, text):
    with pytest.raises(kind, match=text):
        robot.mesh_cover(**arguments)


def test_a_robot_without_meshes():
    robot = cl.Robot.from_urdf('<robot name="r"><link name="a"/></robot>')
    with pytest.raises(cl.Error, match="no link has a collision mesh"):
        robot.mesh_cover(count=100)


@pytest.mark.parametrize("name", ["", "a\nb"])
def test_folders(cover, name):
    with pytest.raises(cl.Error, match="folder"):
        cover.to_urdf(name)
