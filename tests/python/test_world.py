"""Worlds: shapes, poses, files."""

import pickle

import numpy as np
import pytest

import clearance as cl
from conftest import ROOT

# a ball of radius 0.1 m that slides along x
BALL = """<robot name="ball"><link name="rail"/><link name="ball"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="x" type="prismatic"><parent link="rail"/><child link="ball"/><axis xyz="1 0 0"/>
    <limit lower="-5" upper="5" velocity="1" effort="1"/></joint></robot>"""
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 0.5
FACES = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
AHEAD = (2.0, 0.0, 0.0)
STEP = (np.array([2.0, 0, 0]), (0, 0, 0, 1))


@pytest.fixture(scope="module")
def ball():
    return cl.Robot.from_urdf(BALL)


@pytest.mark.parametrize(
    "add, begin",
    [
        (lambda w: w.add_box("o", (1, 1, 1), AHEAD), 1.5),
        (lambda w: w.add_sphere("o", 0.5, AHEAD), 1.5),
        (lambda w: w.add_cylinder("o", 0.25, 1.0, AHEAD), 1.75),
        (lambda w: w.add_capsule("o", 0.25, 1.0, pose=STEP), 1.75),
        # its tip points to the ball
        (lambda w: w.add_cone("o", 0.25, 1.0, ([2, 0, 0], [0, -np.sqrt(0.5), 0, np.sqrt(0.5)])), 1.5),
        (lambda w: w.add_plane("o", (2, 0, 0), 1.5), 1.5),
        (lambda w: w.add_plane("o", (0, 0, 1), -0.5, np.array([[0, 0, -1, 1], [0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1.0]])), 1.5),
        (lambda w: w.add_mesh("o", CUBE, FACES, AHEAD), 1.5),
        (lambda w: w.add_mesh("o", CUBE.astype(np.float32), np.array(FACES, dtype=np.uint8), AHEAD), 1.5),
        (lambda w: w.add_points("o", [[0.0, 0, 0], [1, 0, 0]], 0.25, AHEAD), 1.75),
        (lambda w: w.add_voxels("o", CUBE, 0.5, AHEAD), 1.25),
    ],
)
def test_shapes_are_where_they_are_put(ball, add, begin):
    world = cl.World()
    add(world)
    assert world.names == ["o"] and len(world) == 1 and "o" in world
    y = 0.5 if begin == 1.25 else 0.0
    if y:
        world.move("o", (2.0, 0.5, 0.5))
    distance = cl.Checker(ball, world).distance([0.3], 10.0)
    assert distance.world_distance == pytest.approx(begin - 0.4, abs=1e-6)
    assert distance.world_pair == ("ball", "o") and distance.self_pair is None
    world.remove("o")
    with pytest.warns(cl.InputWarning, match="no pair"):
        assert cl.Checker(ball, world).distance([0.3], 10.0).world_distance == np.inf


def test_a_solid_includes_its_inside(ball):
    world = cl.World()
    world.add_mesh("o", CUBE, FACES)
    assert cl.Checker(ball, world).is_free([0.0])
    assert not cl.Checker(ball, world, mesh_model="solid").is_free([0.0])


def test_poses_and_copies():
    world = cl.World()
    world.add_sphere("a", 0.1, (1, 2, 3))
    copy = world.copy()
    copy.move("a", ((0, 0, 0), (0, 0, np.sin(0.2), np.cos(0.2))))
    assert np.array_equal(world.pose("a")[:3, 3], [1, 2, 3])
    turned = copy.pose("a")
    assert np.allclose(turned[:2, :2], [[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]])
    copy.move("a", turned)
    assert np.allclose(copy.pose("a"), turned)


def test_files(ball, robot, world, tmp_path):
    assert world.names == ["table", "ball", "pillar", "shelf", "ramp"]
    with pytest.raises(cl.Error, match="robot=..."):
        cl.World.from_file(ROOT / "config/demo_world.yaml")
    scene = tmp_path / "scene.yaml"
    scene.write_text((ROOT / "config/demo_world.yaml").read_text().replace("frame_id: base", "frame_id: world"))
    with pytest.warns(cl.InputWarning, match="the scene is of 'demo_arm', the robot is 'not given'"):
        assert cl.World.from_file(str(scene)).names == world.names
    cloud = tmp_path / "cloud.ply"
    cloud.write_text(
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n2 0 0\n"
    )
    with pytest.raises(cl.Error, match="point_radius"):
        cl.World.from_file(cloud)
    points = cl.World.from_file(cloud, point_radius=0.5)
    assert cl.Checker(ball, points).distance([0.0], 5).world_distance == pytest.approx(1.4)
    mesh = tmp_path / "50% off.obj"
    mesh.write_text("v 0 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n")
    world = cl.World()
    world.add_mesh_file("m", mesh, (3, 0, 0), scale=2.0)
    assert cl.Checker(ball, world).distance([0.0], 5).world_distance == pytest.approx(2.9)


def test_attached_objects_move_with_the_link(ball):
    world = cl.World()
    world.add_box("part", (0.1, 0.1, 0.1), (0.5, 0, 0))
    world.add_box("wall", (0.1, 1, 1), (3, 0, 0))
    checker = cl.Checker(ball, world)
    held = checker.attach("part", "ball", q=[0.3])
    assert held.world.attached == {"part": "ball"} and held.world.names == ["wall"]
    assert checker.world.names == ["part", "wall"]
    # the part is 0.2 m before the ball's centre
    assert held.distance([1.0], 5).world_distance == pytest.approx(2.95 - 1.0 - 0.25)
    placed = checker.attach("part", "ball", pose=(0.2, 0, 0))
    assert placed.distance([1.0], 5).world_distance == pytest.approx(2.95 - 1.0 - 0.25)
    put = held.detach("part", [1.0])
    assert np.allclose(put.world.pose("part")[:3, 3], [1.2, 0, 0])
    with pytest.warns(cl.InputWarning, match="no pair"):
        moved = checker.with_world(cl.World())
    assert moved.world.names == [] and moved.is_free([0.5]) and not checker.is_free([0.5])


def test_an_object_with_the_name_of_a_link_is_rejected(ball):
    world = cl.World()
    checker = cl.Checker(ball, world_with(world, "other"))
    with pytest.raises(cl.Error, match="object 'ball': the robot has a link of this name"):
        cl.Checker(ball, world_with(cl.World(), "ball"))
    with pytest.raises(cl.Error, match="object 'rail'"):
        checker.with_world(world_with(cl.World(), "rail"))
    certificate = checker.check_motion([0.0], [0.1], certificate=True).certificate
    with pytest.raises(cl.Error, match="object 'ball'"):
        cl.verify(certificate, ball, world_with(cl.World(), "ball"))


def world_with(world, name):
    world.add_sphere(name, 0.1, (3.0, 0, 0))
    return world


def turned(yaw, dtype):
    pose = np.eye(4, dtype=dtype)
    pose[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    pose[0, 3] = -20.0
    return pose


@pytest.mark.parametrize("make", [lambda pose: pose.astype(np.float32), lambda pose: pose.round(4), lambda pose: pose * [[0.9996], [0.9996], [1], [1]]])
def test_a_pose_is_the_nearest_rotation(ball, make):
    rng = np.random.default_rng(3)
    for yaw in rng.uniform(-3, 3, 20):
        given = make(turned(yaw, np.float64))
        world = cl.World()
        world.add_points("o", [[21.0, 0, 0]], 0.01, given)
        pose = world.pose("o")
        assert np.abs(pose[:3, :3] @ pose[:3, :3].T - np.eye(3)).max() < 1e-15 * 8
        assert np.abs(pose - given).max() < 1e-2 and np.array_equal(pose[:3, 3], given[:3, 3])
        again = pickle.loads(pickle.dumps(world))
        assert np.array_equal(again.pose("o"), pose)
        checker = cl.Checker(ball, world)
        point = (pose @ [21.0, 0, 0, 1])[:3]
        # the ball slides along x
        at = np.clip(point[0], -5, 5)
        distance = np.linalg.norm(point - (at, 0, 0)) - 0.11
        report = checker.check([at], max_distance=100)
        assert checker.is_free([at]) == report.free == (distance > 1e-6)
        found = checker.distance([at], 100.0).world_distance
        assert found == pytest.approx(max(distance, 0), abs=1e-9)


def test_options_without_effect_are_rejected(tmp_path):
    scene, cloud = tmp_path / "s.yaml", tmp_path / "c.pcd"
    scene.write_text("world: {collision_objects: []}\n")
    cloud.write_text("VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3\n")
    with pytest.raises(cl.Error, match="s.yaml: point_radius has no effect: the file is no cloud"):
        cl.World.from_file(scene, point_radius=0.5)
    with pytest.raises(cl.Error, match="unknown_is_occupied has no effect"):
        cl.World.from_file(cloud, point_radius=0.5, unknown_is_occupied=True)
    assert cl.World.from_file(cloud, point_radius=0.5).names
