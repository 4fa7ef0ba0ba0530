"""A robot whose root drives through the room: what stands in the room stays there."""

import pytest
from clearance_msgs.msg import CollisionState

from localization import Localization
from scene import attached, ball, detachment, removal
from scene_client import SceneClient, distance

STRETCHED = {"joint1": 0, "joint2": 0}  # the tip's ball of 0.1 is at (2, 0)
FAR = {"influence_distance": 10.0, "distance_limit": 10.0}
ACCURACY = 1e-4  # [m] less is no motion of the root


def test_obstacles_stay_in_the_room_while_the_robot_drives(start):
    cell = start(parameters=FAR)
    scene = SceneClient(cell)
    localization = Localization(cell)
    cell.evaluate(**STRETCHED)

    def placed():
        scene.publish(ball("pillar", 5.0, frame="odom"))
        expected = pytest.approx(2.8, abs=ACCURACY)
        return any(distance(state, "tip", "pillar") == expected for state in cell.states.all())

    cell.peer.wait_for(placed, "an obstacle in the frame of the room")
    localization.x = 3.0
    state = cell.becomes(CollisionState.COLLIDING, "the robot drove into the pillar")
    assert (state.colliding_pairs[0].body_a, state.colliding_pairs[0].body_b) == ("tip", "pillar")
    localization.x = 1.0
    state = cell.becomes(CollisionState.FREE, "the robot drove back")
    assert distance(state, "tip", "pillar") == pytest.approx(1.8, abs=ACCURACY)

    # given in the frame of a link, and put down by one, it stands in the room as well
    scene.change(removal("pillar"))
    scene.change(attached("tip", ball("part", 1.3, frame="tip")))
    scene.change(detachment("part"))
    before = distance(cell.state_now(), "tip", "part")
    localization.x = 0.5
    cell.states.wait_for(
        lambda state: distance(state, "tip", "part") == pytest.approx(before + 0.5, abs=ACCURACY),
        "the part stayed behind",
        after=cell.peer.now(),
    )


def test_a_rotation_that_nobody_set_places_nothing(start):
    cell = start(parameters=FAR)
    scene = SceneClient(cell)
    localization = Localization(cell)
    localization.turn = 0.0
    cell.evaluate(**STRETCHED)
    scene.rejected(ball("pillar", 5.0, frame="odom"), "unknown frame 'odom'")
    cell.peer.wait_for(lambda: "the transform of 'base' is no pose" in cell.node.output(), "a word about it")
