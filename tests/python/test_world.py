"""Tests of worlds: shapes, poses, files, attached objects."""

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
        (lambda w: w.add_plane("o", (2, 0, 0), 3.0), 1.5),
        (lambda w: w.add_plane("o", (-1e-200, 0, 0), -1.5e-200), 1.5),
        (lambda w: w.add_plane("o", (1e200, 0, 0), 1.5e200), 1.5),
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


def test_planes_are_those_of_their_equation(ball, tmp_path):
    rng = np.random.default_rng(11)
    file = tmp_path / "plane.yaml"
    for length in (1e-200, 0.1, 1.0, 59.0, 1e200):
        for _ in range(10):
            direction, offset, x = rng.normal(size=3), rng.uniform(-3, 3), rng.uniform(-3, 3)
            world = cl.World()
            world.add_plane("p", length * direction, length * offset)
            coefficients = [float(c) for c in (*(length * direction), -length * offset)]
            planes = f"[{{id: p, header: {{frame_id: rail}}, planes: [{{coef: {coefficients}}}]}}]"
            file.write_text(f"world: {{collision_objects: {planes}}}\n")
            expected = max(abs(direction[0] * x - offset) / np.linalg.norm(direction) - 0.1, 0.0)
            for given in (world, cl.World.from_file(file, ball)):
                found = cl.Checker(ball, given).distance([x], 1000.0).world_distance
                assert found == pytest.approx(expected, abs=1e-9)


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
    for use in (lambda w: w.remove("part"), lambda w: w.pose("part"), lambda w: w.move("part", (0, 0, 0))):
        with pytest.raises(cl.Error, match="object 'part' is attached to link 'ball', and is no obstacle: detach it first"):
            use(held.world)
    # the part is 0.2 m before the ball's centre
    assert held.distance([1.0], 5).world_distance == pytest.approx(2.95 - 1.0 - 0.25)
    placed = checker.attach("part", "ball", pose=(0.2, 0, 0))
    assert placed.distance([1.0], 5).world_distance == pytest.approx(2.95 - 1.0 - 0.25)
    put = held.detach("part", [1.0])
    assert np.allclose(put.world.pose("part")[:3, 3], [1.2, 0, 0])
    with pytest.warns(cl.InputWarning, match="no pair"):
        moved = checker.with_world(cl.World())
    assert moved.world.names == [] and moved.is_free([0.5]) and not checker.is_free([0.5])


# two balls of radius 0.1 m, one of which slides along x
TWO = """<robot name="two"><link name="base"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="tip"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="x" type="prismatic"><parent link="base"/><child link="tip"/><origin xyz="1 0 0"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"""


@pytest.fixture(scope="module")
def two():
    return cl.Robot.from_urdf(TWO)


def balls(**places):
    world = cl.World()
    for name, y in places.items():
        world.add_sphere(name, 0.1, (0, y, 0))
    return world


def held_balls(robot):
    """`o` and `p` are held by the tip, `o` may touch the base; `q` is an obstacle."""
    checker = cl.Checker(robot, balls(o=1, p=2, q=3))
    held = checker.attach("o", "tip", pose=(0, 0.3, 0), touch_links=["base"])
    return held.attach("p", "tip", pose=(0, 0.6, 0)).world


@pytest.mark.parametrize(
    "pair, why",
    [
        (("tip", "o"), "the link holds the object"),
        (("p", "tip"), "the link holds the object"),
        (("base", "o"), "the link is a touch link of the object"),
        (("o", "p"), "one link holds both objects"),
    ],
)
def test_pairs_of_held_objects_that_cannot_be_checked_are_named(two, pair, why):
    words = f"checked_collisions: '{pair[0]}' and '{pair[1]}' cannot be checked: {why}"
    held = held_balls(two)
    with pytest.raises(cl.Error, match=words):
        cl.Checker(two, held, checked_collisions=[pair])
    certificate = cl.Checker(two, held).check_motion([0.0], [0.1], certificate=True).certificate
    with pytest.raises(cl.Error, match=words):
        cl.verify(certificate, two, held, checked_collisions=[pair])
    if pair != ("o", "p"):
        with pytest.raises(cl.Error, match=words):
            cl.Checker(two, balls(o=1, p=2), checked_collisions=[pair]).with_world(held)


def test_pairs_of_held_objects_are_checked(two):
    pairs = [("base", "p"), ("tip", "q"), ("o", "q")]
    checker = cl.Checker(two, held_balls(two), checked_collisions=pairs)
    assert set(pairs) <= set(checker.pairs)
    with pytest.raises(cl.Error, match="'o' and 'q' cannot be checked: both are obstacles"):
        checker.detach("o", [0.0])
    checker = cl.Checker(two, balls(o=1), checked_collisions=[("tip", "o"), ("base", "o")])
    with pytest.raises(cl.Error, match="'tip' and 'o' cannot be checked: the link holds the object"):
        checker.attach("o", "tip", pose=(0, 0.3, 0))
    checker = cl.Checker(two, balls(o=1), checked_collisions=[("base", "o")])
    assert ("base", "o") in checker.attach("o", "tip", pose=(0, 0.3, 0)).pairs
    with pytest.raises(cl.Error, match="'base' and 'o' cannot be checked: the link is a touch link of the object"):
        checker.attach("o", "tip", pose=(0, 0.3, 0), touch_links=["base"])


@pytest.mark.parametrize(
    "settings, left",
    [
        ({"object_padding": {"o": 0.05, "p": 0.01}}, {"object_padding": {"p": 0.01}}),
        ({"object_scale": {"o": 2.0}}, {}),
        ({"allowed_collisions": [("base", "o"), ("base", "p")]}, {"allowed_collisions": [("base", "p")]}),
        ({"allowed_collisions": [("base", "o")]}, {}),
        ({"checked_collisions": [("base", "o"), ("p", "tip")]}, {"checked_collisions": [("p", "tip")]}),
    ],
)
def test_settings_of_an_object_end_with_the_object(two, settings, left):
    world, rest = balls(o=1, p=2), balls(p=2)
    checker = cl.Checker(two, world, **settings)
    fewer = checker.with_world(rest)
    kept = cl.Checker(two, rest, **left)
    assert fewer.settings == kept.settings and fewer.pairs == kept.pairs
    certificate = fewer.check_motion([0.0], [0.1], certificate=True).certificate
    assert cl.verify(certificate, two, fewer.world, **fewer.settings)
    assert cl.verify(certificate, two, rest, **left)
    assert cl.Checker(two, fewer.world, **fewer.settings).settings == fewer.settings
    # also where the object comes back
    back, new = fewer.with_world(world), cl.Checker(two, world, **left)
    assert back.settings == new.settings and back.pairs == new.pairs
    near = [checker.distance([0.0], 9.0).world_distance for checker in (back, new)]
    assert near[0] == pytest.approx(near[1], abs=1e-12)
    # a held object is still there
    held = checker.attach("o", "tip", pose=(0, 0.3, 0))
    assert held.settings == checker.settings == held.detach("o", [0.0]).settings


def test_an_object_on_a_link_that_the_robot_lacks_is_named(ball, two):
    held = held_balls(two)
    certificate = cl.Checker(two, held).check_motion([0.0], [0.1], certificate=True).certificate
    words = "object 'o' is attached to link 'tip', which the robot has not"
    assert cl.verify(certificate, ball, held).reason == words
    with pytest.raises(cl.Error, match=words):
        cl.Checker(ball, held)


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


def test_a_world_without_a_held_object_releases_it_with_a_warning(ball):
    world = cl.World()
    world.add_box("can", (0.1, 0.1, 0.1), AHEAD)
    world.add_box("wall", (0.1, 0.1, 0.1), (0, -3, 0))
    held = cl.Checker(ball, world).attach("can", "ball", pose=(0, 0, 0.3))
    with pytest.warns(cl.InputWarning, match="'can' is not attached in the new world: link 'ball'"):
        assert held.with_world(world).world.attached == {}
    kept = held.world.copy()
    kept.add_box("shelf", (0.1, 0.1, 0.1), (0, 3, 0))
    assert held.with_world(kept).world.attached == {"can": "ball"}
