"""Tests of contacts between two joint states: `motion_since_previous` and `passed_through` in `~/state`."""

from clearance_msgs.msg import CollisionState
from rclpy.time import Time

import two_link
from scene import box, obstacle, pose

STEP = 0.5  # [rad] on either side of the wall
PERIOD = 20_000_000  # [ns] from one state to the next


def wall():
    """A wall of 1 mm across the way of the stretched arm's tip, which is a ball of 0.1 m at 2 m."""
    return obstacle("wall", box(0.4, 0.001, 0.4), at=pose(1.0, 0, 0))


def swing(cell, *positions):
    """The states that are evaluated of these positions of joint1, published 20 ms apart by their stamps."""
    cell.driver.pause()
    states = []
    now = cell.peer.now().nanoseconds
    for number, joint1 in enumerate(positions):
        stamp = Time(nanoseconds=now + number * PERIOD, clock_type=cell.peer.now().clock_type)
        states.append(cell.evaluated({"joint1": joint1, "joint2": 0.0}, stamp))
    return states


def test_a_pass_through_a_thin_wall_is_reported_once(cell, scene):
    scene.change(wall())
    start, across, after = swing(cell, -STEP, STEP, STEP + 0.01)
    assert (start.status, across.status, after.status) == (
        CollisionState.FREE,
        CollisionState.COLLIDING,
        CollisionState.FREE,
    )
    assert across.motion_since_previous == CollisionState.PASSED_THROUGH
    assert across.reason_code == "passed_through" and "'wall'" in across.reason
    (passage,) = across.passed_through
    assert passage.proven and 0 < passage.t_lower <= passage.t_upper < 0.5
    assert {passage.pair.body_a, passage.pair.body_b} == {"tip", "wall"}
    assert across.colliding_pairs == []
    assert passage.stamp == across.header.stamp and passage.previous_stamp == start.header.stamp
    # The distances are those of the state.
    assert across.world_distance > 0 and across.distance_known
    assert after.motion_since_previous == CollisionState.PROVEN_FREE and after.passed_through == []


def test_without_the_check_each_state_counts_alone(cell, scene):
    cell.parameters.succeed(check_between_states=False)
    scene.change(wall())
    start, across = swing(cell, -STEP, STEP)
    assert (start.status, across.status) == (CollisionState.FREE, CollisionState.FREE)
    assert across.motion_since_previous == CollisionState.NOT_CHECKED
    assert "check_between_states" in across.motion_since_previous_reason


def test_a_possible_contact_within_the_noise_is_a_warning(cell, scene):
    cell.parameters.succeed(joint_noise=0.05, between_states_acceleration=0.0)
    scene.change(obstacle("side", box(3, 0.1, 1), at=pose(2, 0.2, 0)))
    states = swing(cell, 0.0, 0.001)
    assert [state.status for state in states] == [CollisionState.FREE] * 2
    assert states[1].motion_since_previous == CollisionState.NOT_PROVEN
    (gap,) = states[1].passed_through
    assert not gap.proven and gap.pair.body_b == "side"
    assert any(warning.startswith("gap_not_proven: ") for warning in states[1].warnings)
