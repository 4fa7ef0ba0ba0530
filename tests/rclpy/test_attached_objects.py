"""Tests of `attached_collision_object`: held objects move with their link, and are checked against everything else.

The part is a ball of radius 0.05 at (1, 0.4, 0) of the tip's frame, beside the ball at the tip's end.
"""

from math import atan2, hypot, pi, sqrt

import pytest
from clearance_msgs.msg import CollisionState
from clearance_msgs.srv import CheckMotion

from motions import Motions
from scene import attached, ball, detachment, move, pose, removal, xyz
from scene_client import colliding, distance

ACCURACY = 1e-6  # [m]
# Folded, the tip is free and the part is in the cube of the base.
FOLDED = {"joint1": 0, "joint2": 5 * pi / 6}
STRETCHED = {"joint1": 0, "joint2": 0}
UP = {"joint1": pi / 2, "joint2": 0}

HELD = attached("tip", ball("part", 1, 0.4, radius=0.05, frame="tip"), ["tip"])


@pytest.fixture
def cell(start):
    cell = start(parameters={"influence_distance": 0.5, "distance_limit": 3.0})
    cell.evaluate(**STRETCHED)
    return cell


def test_an_attached_object_moves_with_its_link(cell, scene):
    assert cell.evaluate(**FOLDED).status == CollisionState.FREE
    state = scene.change(HELD)

    assert state.status == CollisionState.COLLIDING
    assert colliding(state) == [{("link", "base"), ("attached", "part")}]
    state = cell.evaluate(**STRETCHED)
    assert state.status == CollisionState.FREE
    # base - tip, base - part and upper - part; the part may touch the tip.
    assert state.pairs_checked == 3


def test_messages_of_two_topics_are_applied_in_the_order_of_their_reception(cell, scene):
    """At once: other objects, the part on one topic, its attachment on another."""
    scene.change(ball("wall", 2, 0.8, radius=0.38), ball("part", 9))
    for turn in range(10):
        name = f"part_{turn}"
        others = [ball(f"other_{number}", 9 + number, turn) for number in range(4)]
        after = cell.peer.now()
        for message in [*others, ball(name, 2, 0.4, radius=0.05), attached("tip", name, ["tip"])]:
            scene.publish(message)

        def is_held(state, name=name):
            return {("obstacle", "wall"), ("attached", name)} in colliding(state)

        cell.states.wait_for(is_held, "the part in the tip, which is in the wall", after=after)
        scene.publish(detachment(name))
        scene.publish(removal(name))
        cell.becomes(CollisionState.FREE, "a robot that holds nothing")
        assert name not in scene.obstacles()


def test_attach_move_detach(cell, scene):
    scene.change(ball("part", 2, 0.4, radius=0.05))
    state = cell.evaluate(**STRETCHED)
    assert distance(state, "tip", "part") == pytest.approx(0.25, abs=ACCURACY)

    # By name: its shape is that of the world's object, which leaves the world.
    state = scene.change(attached("tip", "part", ["tip"]))
    assert distance(state, "tip", "part") is None
    assert colliding(cell.evaluate(**FOLDED)) == [{("link", "base"), ("attached", "part")}]

    cell.evaluate(**UP)
    scene.change(detachment("part"))
    state = cell.evaluate(**UP)
    assert distance(state, "tip", "part") == pytest.approx(0.25, abs=ACCURACY)
    assert xyz(scene.obstacles()["part"].pose.position) == pytest.approx((-0.4, 2, 0), abs=ACCURACY)
    # It stays there, an obstacle like any other.
    assert distance(cell.evaluate(**STRETCHED), "tip", "part") is None
    assert cell.evaluate(**FOLDED).status == CollisionState.FREE
    scene.change(removal("part"))


def test_an_object_given_in_the_world_s_frame_is_held_where_it_is_at_that_moment(cell, scene):
    cell.evaluate(**UP)
    scene.change(attached("tip", ball("part", -0.4, 2, radius=0.05), ["tip"]))
    assert colliding(cell.evaluate(**FOLDED)) == [{("link", "base"), ("attached", "part")}]


def test_an_attached_object_against_the_world(cell, scene):
    scene.change(HELD, ball("wall", 2, 0.6, radius=0.05))
    state = cell.evaluate(**STRETCHED)
    assert distance(state, "part", "wall") == pytest.approx(0.1, abs=ACCURACY)

    state = scene.change(move("wall", pose(2, 0.45)))
    assert colliding(state) == [{("attached", "part"), ("obstacle", "wall")}]


def test_attached_objects_against_each_other(cell, scene):
    # Where the part comes by when joint2 turns it to 120 degrees.
    reach = hypot(1, 0.4)
    other = ball("other", 1 - reach / 2, reach * sqrt(3) / 2, radius=0.05, frame="upper")
    scene.change(HELD, attached("upper", other, ["upper"]))
    assert cell.evaluate(**STRETCHED).status == CollisionState.FREE

    state = cell.evaluate(joint1=0, joint2=2 * pi / 3 - atan2(0.4, 1))
    assert colliding(state) == [{("attached", "part"), ("attached", "other")}]


def test_touch_links_may_be_touched(scene):
    # In the bar of the upper link, 0.2 before the elbow.
    inside = ball("part", -0.2, radius=0.03, frame="tip")
    state = scene.change(attached("tip", inside, ["tip"]))
    assert colliding(state) == [{("link", "upper"), ("attached", "part")}]

    state = scene.change(attached("tip", inside, ["tip", "upper"]))
    assert state.status == CollisionState.FREE


def test_all_that_a_link_holds_is_let_go(cell, scene):
    scene.change(HELD, attached("upper", ball("other", 0.5, 0.4, frame="upper"), ["upper"]))
    scene.change(detachment("", "tip"))
    assert list(scene.obstacles()) == ["part"]
    scene.change(detachment(""))
    assert set(scene.obstacles()) == {"part", "other"}


def test_a_robot_that_may_hold_more_than_is_known_is_unknown(cell, scene):
    """Taken out of the world, it is in no place that is known."""
    scene.change(ball("a", 5))
    seen = cell.peer.now()
    scene.rejected(attached("hand", "a"), "a", "hand")
    cell.unknown("rejected_obstacle", after=seen)
    scene.change(removal("a"))
    assert cell.evaluate(joint1=0, joint2=0.1).reason_code == "rejected_obstacle"
    scene.change(attached("tip", ball("a", 1, 0.4, radius=0.05, frame="tip"), ["tip"]))
    cell.states.wait_for(lambda state: state.status == CollisionState.FREE, "FREE", after=cell.peer.now())

    seen = cell.peer.now()
    scene.rejected(detachment("a", "upper"), "a", "upper")
    cell.unknown("rejected_obstacle", after=seen)
    scene.change(detachment("a"))
    cell.states.wait_for(lambda state: state.status == CollisionState.FREE, "FREE", after=cell.peer.now())


def test_what_cannot_be_attached_is_rejected_by_name(cell, scene):
    cell.parameters.succeed(rejected_obstacle="warn")
    scene.rejected(attached("hand", ball("a", 1)), "a", "hand")
    scene.rejected(attached("tip", "not_there"), "not_there")
    scene.rejected(attached("tip", ball("c", 1, frame="nowhere")), "c", "nowhere")
    scene.rejected(detachment("not_held"), "not_held")
    scene.change(HELD)
    scene.rejected(detachment("part", "upper"), "part", "upper")
    assert colliding(cell.evaluate(**FOLDED)) == [{("link", "base"), ("attached", "part")}]


def test_an_unknown_touch_link_is_complained_about(scene):
    scene.publish(attached("tip", ball("part", 1, 0.4, frame="tip"), ["tip", "finger"]))
    scene.complaints.wait_for("part", "finger")


def test_a_motion_is_checked_with_what_is_held(cell, scene):
    motions = Motions(cell.peer, cell.node)
    ends = (0, 0), (0, 5 * pi / 6)
    assert motions.check(*ends).verdict == CheckMotion.Response.FREE

    scene.change(HELD)
    response = motions.check(*ends)
    assert response.verdict == CheckMotion.Response.CONTACT
    assert {response.pair.body_a, response.pair.body_b} == {"base", "part"}
