"""Tests of a robot whose root drives: obstacles stay fixed in the world, and time to contact."""

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


class Drive(Localization):
    """The root drives along x at a constant speed from now on."""

    def __init__(self, cell, speed):
        self._speed = speed  # [m/s]
        self._start = cell.peer.now()
        super().__init__(cell)

    def _tick(self):
        self.x = self._speed * (self._peer.now() - self._start).nanoseconds * 1e-9
        super()._tick()


def test_the_time_to_contact_of_a_root_that_drives_needs_its_accelerations(start):
    cell = start(parameters={**FAR, "look_ahead_horizon": 10.0, "look_ahead_acceleration": 0.0})
    scene = SceneClient(cell)
    Drive(cell, 0.1)

    def look():
        return cell.moving(STRETCHED, (0, 0))

    look()

    def placed():
        scene.publish(ball("pillar", 5.0, frame="odom"))
        return look().world_distance < 10.0

    cell.peer.wait_for(placed, "an obstacle in the frame of the room")
    why = "the robot's root moves in 'odom': set look_ahead_root_acceleration and look_ahead_root_angular_acceleration"
    cell.peer.wait_for(lambda: any(why in warning for warning in look().warnings), "the reason in a warning")
    assert not look().time_to_contact_known

    cell.parameters.succeed(look_ahead_root_acceleration=0.5, look_ahead_root_angular_acceleration=0.01)
    cell.peer.wait_for(lambda: look().time_to_contact_known, "a time to contact")
    state = look()
    gap = state.world_distance
    # the fastest motion within the limits; the pose of the root may be older than the joint state, so that it is nearer
    truth = ((0.1**2 + 2 * 0.5 * gap) ** 0.5 - 0.1) / 0.5
    assert 0.5 * truth < state.time_to_contact <= truth
    assert {state.first_contact_pair.body_a, state.first_contact_pair.body_b} == {"tip", "pillar"}


def test_a_rotation_that_nobody_set_places_nothing(start):
    cell = start(parameters=FAR)
    scene = SceneClient(cell)
    localization = Localization(cell)
    localization.turn = 0.0
    cell.evaluate(**STRETCHED)
    scene.rejected(ball("pillar", 5.0, frame="odom"), "unknown frame 'odom'")
    cell.peer.wait_for(lambda: "the transform of 'base' is no pose" in cell.node.output(), "a word about it")
