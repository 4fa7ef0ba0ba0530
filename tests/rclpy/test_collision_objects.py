"""Tests of `collision_object`: obstacles are added, extended, moved, removed and rejected.

With both joints at zero the ball of the tip, of radius 0.1, is around (2, 0, 0): an obstacle that begins at x = 2.2 is 0.1 away.
"""

from math import inf, nan, pi

import pytest
from clearance_msgs.msg import CollisionState
from clearance_msgs.srv import CheckMotion
from geometry_msgs.msg import Quaternion, TransformStamped
from moveit_msgs.msg import CollisionObject, PlanningSceneWorld
from shape_msgs.msg import SolidPrimitive
from std_msgs.msg import Bool
from tf2_msgs.msg import TFMessage

from cell import Cell
from motions import Motions
from scene import attached, ball, box, cone, cube_mesh, cylinder, full, mesh, move, obstacle, plane, pose, removal, sphere
from scene_client import SceneClient, bodies, colliding, distance

ACCURACY = 1e-6  # [m] curved primitives; boxes and balls do far better
NEARBY = {"influence_distance": 0.5, "distance_limit": 3.0}


@pytest.fixture
def cell(start):
    cell = start(parameters=NEARBY)
    cell.evaluate(joint1=0, joint2=0)
    return cell


@pytest.fixture(scope="module")
def shared(module_peer):
    """One node for obstacles that are taken away again."""
    with Cell(module_peer, parameters=NEARBY) as cell:
        cell.evaluate(joint1=0, joint2=0)
        yield SceneClient(cell)


def near(state, name="thing"):
    return distance(state, "tip", name)


SHAPES = {
    "box": (box(0.2, 0.4, 0.6), pose(2.3)),
    "turned box": (box(0.4, 0.2, 0.6), pose(2.3, axis=(0, 0, 1), angle=pi / 2)),
    "sphere": (sphere(0.1), pose(2.3)),
    "cylinder": (cylinder(0.6, 0.1), pose(2.3)),
    "lying cylinder": (cylinder(0.2, 0.3), pose(2.3, axis=(0, 1, 0), angle=pi / 2)),
    # Its base is turned to the arm, with the rim on the x axis; the apex there would be farther away.
    "lying cone": (cone(0.2, 0.1), pose(2.3, 0, 0.1, axis=(0, 1, 0), angle=pi / 2)),
    "plane": (plane(-1, 0, 0, 2.2), pose()),
    "placed plane": (plane(0, 0, 1, -0.1), pose(2.3, axis=(0, 1, 0), angle=-pi / 2)),
    "mesh": (cube_mesh(0.2), pose(2.3)),
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("placed", ["by the object", "by the shape"])
def test_every_shape_is_where_its_message_places_it(shared, shape, placed):
    geometry, place = SHAPES[shape]
    thing = obstacle("thing", geometry, at=place) if placed == "by the object" else obstacle("thing", (geometry, place))
    state = shared.change(thing)

    assert state.status == CollisionState.FREE
    assert near(state) == pytest.approx(0.1, abs=ACCURACY)
    assert ("obstacle", "thing") in bodies(state.nearest.pair)
    assert near(shared.change(removal("thing"))) is None


def test_solid_meshes_hold_what_is_inside_and_open_ones_are_named(start):
    cell = start("--mesh", "solid", parameters=NEARBY)
    cell.evaluate(joint1=0, joint2=0)
    scene = SceneClient(cell)
    # all of the robot is inside
    state = scene.change(obstacle("closed", cube_mesh(6)))
    assert {("link", "tip"), ("obstacle", "closed")} in colliding(state)
    assert not state.warnings

    scene.change(removal("closed"))
    state = scene.change(obstacle("open", opened(cube_mesh(6))))
    assert state.status == CollisionState.FREE
    (warning,) = state.warnings
    assert "not solid" in warning and "mesh 0 of object 'open'" in warning
    state = scene.change(attached("tip", "open"))
    (warning,) = state.warnings
    assert "mesh 0 of attached object 'open'" in warning


def test_meshes_wound_both_ways_are_solid_and_named_once(start):
    cell = start("--mesh", "solid", parameters=NEARBY)
    cell.evaluate(joint1=0, joint2=0)
    scene = SceneClient(cell)
    double = cube_mesh(6)
    double.triangles = [*double.triangles, *inside_out(cube_mesh(6)).triangles]
    for place in pose(), pose(0.01):
        state = scene.change(obstacle("double", double, at=place))
        assert {("link", "tip"), ("obstacle", "double")} in colliding(state)
        (warning,) = state.warnings
        assert warning.startswith("mesh 0 of object 'double': 12 of 24 faces are there in both windings")
    assert cell.node.output().count("faces are there in both windings") == 1


def inside_out(mesh):
    for triangle in mesh.triangles:
        triangle.vertex_indices = triangle.vertex_indices[::-1]
    return mesh


def opened(mesh):
    mesh.triangles = mesh.triangles[1:]
    return mesh


def test_poses_of_object_and_shape_are_composed(shared):
    # The object's x axis points along the world's y: its shape at (-0.5, 0, 0) is 0.5 m towards the x axis.
    turned = pose(2.3, 0.5, 0, angle=pi / 2)
    state = shared.change(obstacle("thing", (sphere(0.1), pose(-0.5)), (sphere(0.05), pose(3)), at=turned))

    assert near(state) == pytest.approx(0.1, abs=ACCURACY)
    shared.change(removal("thing"))


def test_shapes_without_a_pose_stand_in_the_object_s_frame(shared):
    state = shared.change(obstacle("thing", sphere(0.1), sphere(0.05), at=pose(2.3)))
    assert near(state) == pytest.approx(0.1, abs=ACCURACY)
    shared.change(removal("thing"))


def test_a_pose_without_orientation_is_not_turned(shared):
    thing = ball("thing", 2.3)
    thing.pose.orientation = Quaternion(x=0.0, y=0.0, z=0.0, w=0.0)
    assert near(shared.change(thing)) == pytest.approx(0.1, abs=ACCURACY)
    shared.change(removal("thing"))


def test_an_object_that_touches_is_named_with_what_it_touches(scene):
    state = scene.change(ball("thing", 2.15))

    assert state.status == CollisionState.COLLIDING
    assert colliding(state) == [{("link", "tip"), ("obstacle", "thing")}]


def test_adding_once_more_replaces(scene):
    scene.change(ball("thing", 2.3))
    state = scene.change(ball("thing", 2.4, radius=0.05))
    assert near(state) == pytest.approx(0.25, abs=ACCURACY)


def test_appending_adds_shapes_to_an_object(scene):
    place = pose(2, 1)
    scene.change(obstacle("thing", sphere(0.1), at=place))
    # as in MoveIt, the pose of the message counts for nothing
    more = obstacle("thing", (sphere(0.1), pose(0.3, -1)), (sphere(0.1), pose(0, 3)))
    more.operation = CollisionObject.APPEND
    state = scene.change(more)

    assert near(state) == pytest.approx(0.1, abs=ACCURACY)
    # The first shape is still there: 0.8 above the ball.
    state = scene.change(move("thing", pose(2, 0.5)))
    assert near(state) == pytest.approx(0.3, abs=ACCURACY)


def test_a_move_with_poses_of_shapes_moves_these(scene):
    scene.change(obstacle("thing", (sphere(0.1), pose(0, 1)), (sphere(0.1), pose(0, 2)), at=pose(2.3, 3)))
    elsewhere = move("thing", pose(2.3))
    elsewhere.primitive_poses = [pose(0, 2), pose()]
    assert near(scene.change(elsewhere)) == pytest.approx(0.1, abs=ACCURACY)
    scene.rejected(move_with_one_pose(), "thing", "1 poses of shapes are given, but the object has 2 shapes")


def move_with_one_pose():
    message = move("thing", pose(9))
    message.primitive_poses = [pose()]
    return message


def test_a_world_without_an_obstacle_that_was_rejected_is_unknown(cell, scene):
    """What is right about others makes nobody forget that it is not there."""
    is_free = cell.peer.record(Bool, cell.node.private("is_free"))
    motions = Motions(cell.peer, cell.node)
    assert motions.check((0, 0), (0, 0.1)).verdict == CheckMotion.Response.FREE
    seen = cell.peer.now()
    scene.rejected(ball("thing", 0.3, frame="nowhere"), "thing", "nowhere")
    reason = cell.unknown("rejected_obstacle", after=seen).reason
    assert "'thing'" in reason and "header.frame_id" in reason and "nowhere" in reason
    received = cell.peer.now()
    scene.change(ball("other", 5))
    state = cell.evaluate(joint1=0, joint2=0.1)
    assert (state.status, state.reason_code) == (CollisionState.UNKNOWN, "rejected_obstacle")
    response = motions.check((0, 0), (0, 0.1))
    assert (response.verdict, response.reason_code) == (CheckMotion.Response.ERROR, "rejected_obstacle")
    assert not scene.validity({"joint1": 0, "joint2": 0}).valid
    assert not any(said.data for said in is_free.after(received))

    scene.change(ball("thing", 5))
    cell.states.wait_for(lambda state: state.status == CollisionState.FREE, "FREE", after=cell.peer.now())
    assert motions.check((0, 0), (0, 0.1)).verdict == CheckMotion.Response.FREE
    assert scene.validity({"joint1": 0, "joint2": 0}).valid


SETTLING = {
    "an addition that is right": lambda: ball("thing", 5),
    "a removal": lambda: removal("thing"),
    "the removal of all": removal,
    "a world": lambda: PlanningSceneWorld(),
    "a whole scene": lambda: full(ball("other", 5)),
}


@pytest.mark.parametrize("by", SETTLING)
def test_a_rejected_obstacle_counts_until_it_is_made_up_for(cell, scene, by):
    seen = cell.peer.now()
    scene.rejected(ball("thing", 0.3, frame="nowhere"), "thing", "nowhere")
    cell.unknown("rejected_obstacle", after=seen)
    seen = cell.peer.now()
    scene.publish(SETTLING[by]())
    cell.states.wait_for(lambda state: state.status == CollisionState.FREE, "FREE", after=seen)


def test_a_move_does_not_make_up_for_shapes_that_were_rejected(cell, scene):
    scene.change(ball("thing", 5))
    seen = cell.peer.now()
    more = obstacle("thing", mesh([], []), operation=CollisionObject.APPEND)
    scene.rejected(more, "thing", "mesh[0]")
    cell.unknown("rejected_obstacle", after=seen)
    scene.change(move("thing", pose(6)))
    assert cell.evaluate(joint1=0, joint2=0.1).reason_code == "rejected_obstacle"
    scene.change(ball("thing", 5))
    cell.states.wait_for(lambda state: state.status == CollisionState.FREE, "FREE", after=cell.peer.now())


def test_a_rejected_obstacle_is_a_warning_if_that_is_wanted(start):
    cell = start(parameters=NEARBY | {"rejected_obstacle": "warn"})
    cell.evaluate(joint1=0, joint2=0)
    scene = SceneClient(cell)
    scene.rejected(ball("thing", 0.3, frame="nowhere"), "thing", "nowhere")
    state = scene.change(ball("other", 5))
    assert state.status == CollisionState.FREE
    assert any("'thing'" in warning for warning in state.warnings)


def test_appending_to_nothing_adds(scene):
    state = scene.change(ball("thing", 2.3, operation=CollisionObject.APPEND))
    assert near(state) == pytest.approx(0.1, abs=ACCURACY)


def test_moving_keeps_the_shapes(scene):
    scene.change(obstacle("thing", (sphere(0.1), pose(0.1)), (sphere(0.1), pose(3)), at=pose(2.5)))
    state = scene.change(move("thing", pose(2.2, 0, 0)))
    assert near(state) == pytest.approx(0.1, abs=ACCURACY)


def test_a_single_shape_that_was_placed_itself_is_moved_with_its_object(scene):
    """As in MoveIt: the one pose of an object is the object's, whichever field it was written into."""
    scene.change(obstacle("thing", (sphere(0.1), pose(2.5))))
    state = scene.change(move("thing", pose(2.3)))
    assert near(state) == pytest.approx(0.1, abs=ACCURACY)


def test_one_is_removed_or_all(scene):
    scene.change(ball("a", 2.3), ball("b", 2.3, 0.3), ball("c", 2.3, -0.3))
    state = scene.change(removal("a"))
    assert near(state, "a") is None
    assert near(state, "b") == pytest.approx(near(state, "c"), abs=ACCURACY)

    state = scene.change(removal())
    assert state.pairs_checked == 1


def test_an_object_in_the_frame_of_a_link_stays_where_the_link_was(cell, scene):
    # The tip's origin is the elbow; its x axis points to the ball.
    state = scene.change(ball("thing", 1.3, frame="tip"))
    assert near(state) == pytest.approx(0.1, abs=ACCURACY)

    assert near(cell.evaluate(joint1=0, joint2=pi / 2)) is None
    assert near(cell.evaluate(joint1=0, joint2=0)) == pytest.approx(0.1, abs=ACCURACY)

    cell.evaluate(joint1=pi / 2, joint2=0)
    scene.change(ball("other", 1.3, frame="/tip"))
    assert near(cell.evaluate(joint1=pi / 2, joint2=0), "other") == pytest.approx(0.1, abs=ACCURACY)
    assert near(cell.evaluate(joint1=0, joint2=0), "thing") == pytest.approx(0.1, abs=ACCURACY)


def test_an_object_in_the_frame_of_another_or_of_its_subframe(scene):
    shelf = obstacle("shelf", sphere(0.05), at=pose(2.3, 1, angle=pi / 2), subframes={"hook": pose(-1)})
    scene.change(shelf)
    state = scene.change(ball("thing", 0, 0, 0, frame="shelf/hook"))
    assert near(state) == pytest.approx(0.1, abs=ACCURACY)

    state = scene.change(ball("other", -1, -0.1, 0, frame="shelf"))
    assert near(state, "other") == pytest.approx(0.2, abs=ACCURACY)


def test_an_object_in_a_frame_of_tf(peer, start):
    cell = start(parameters=NEARBY, namespace="")
    cell.evaluate(joint1=0, joint2=0)
    scene = SceneClient(cell)
    transform = TransformStamped(child_frame_id="camera")
    transform.header.frame_id = "base"
    transform.transform.translation.x = 2.0
    publisher = peer.latch(TFMessage(transforms=[transform]), "/tf_static")
    peer.wait_for(publisher.get_subscription_count, "a subscription of tf_static")

    def placed():
        scene.publish(ball("thing", 0.3, frame="camera"))
        return next(filter(None, map(near, cell.states.all())), None)

    assert peer.wait_for(placed, "an obstacle in the frame of the camera") == pytest.approx(0.1, abs=ACCURACY)


def test_an_unknown_frame_is_rejected_and_nothing_is_lost(cell, scene):
    cell.parameters.succeed(rejected_obstacle="warn")
    scene.change(ball("first", 2.3))
    scene.rejected(ball("thing", 0.3, frame="nowhere"), "thing", "nowhere")
    # Nor does it take the place of what was there under its name.
    scene.rejected(ball("first", 0.3, frame="nowhere"), "first", "nowhere")

    state = scene.change(ball("last", 2.3, 0.3))
    assert near(state, "first") == pytest.approx(0.1, abs=ACCURACY)
    assert near(state, "thing") is None


def test_what_is_not_there_cannot_be_moved_or_removed(scene):
    scene.change(ball("first", 2.3))
    scene.rejected(move("thing", pose(2.3)), "thing")
    scene.rejected(removal("other"), "other")


def broken(change, shapes=None):
    thing = obstacle("thing", *([sphere(0.1)] if shapes is None else shapes), at=pose(2.05))
    change(thing)
    return thing


def primitive(*dimensions, kind=SolidPrimitive.BOX):
    return SolidPrimitive(type=kind, dimensions=list(dimensions))


def triangle(*indices):
    return mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [indices])


def unchanged(_):
    pass


BROKEN = {
    "no shape": broken(unchanged, ()),
    "two dimensions of a box": broken(unchanged, [primitive(0.1, 0.1)]),
    "no dimension": broken(unchanged, [primitive(kind=SolidPrimitive.SPHERE)]),
    "a negative dimension": broken(unchanged, [primitive(0.1, -0.1, 0.1)]),
    "a dimension that is no number": broken(unchanged, [primitive(0.1, nan, 0.1)]),
    "an infinite dimension": broken(unchanged, [primitive(inf, kind=SolidPrimitive.SPHERE)]),
    "an unknown kind of primitive": broken(unchanged, [primitive(0.1, kind=77)]),
    "more poses than shapes": broken(lambda thing: thing.primitive_poses.extend([pose(), pose()])),
    "a place that is no number": broken(lambda thing: setattr(thing.pose.position, "x", nan)),
    "an orientation that is no number": broken(lambda thing: setattr(thing.pose.orientation, "x", nan)),
    "a vertex that is not there": broken(unchanged, [triangle(0, 1, 3)]),
    "a mesh of nothing": broken(unchanged, [mesh([], [])]),
    "a plane without a normal": broken(unchanged, [plane(0, 0, 0, 1)]),
    "a subframe without a pose": broken(lambda thing: thing.subframe_names.append("hook")),
    "an unknown operation": broken(lambda thing: setattr(thing, "operation", bytes([9]))),
}


@pytest.mark.parametrize("fault", BROKEN)
def test_a_broken_object_is_rejected_by_name(shared, fault):
    message = BROKEN[fault]
    # a name of its own, since the complaint about the one before may stand for a while
    message.id = fault.replace(" ", "_")
    shared.rejected(message, message.id)


def test_the_octomap_s_name_is_taken(shared):
    shared.rejected(ball("<octomap>", 2.3), "<octomap>")
