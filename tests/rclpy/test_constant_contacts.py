"""Tests of pairs of links that touch in every joint state: reported with the SRDF entry that would allow them."""

from math import pi

from clearance_msgs.msg import CollisionState

ENTRY = '<disable_collisions link1="base" link2="tip" reason='


def remarks(state):
    return [text for text in state.warnings if ENTRY in text]


def test_a_pair_that_always_touches_is_named_in_the_state_and_logged_once(cell):
    angle = pi
    state = cell.evaluate(joint1=0, joint2=angle)
    assert state.status == CollisionState.COLLIDING
    cell.states.ever(remarks, "a remark about the pair")
    # it moves, and touches all the same
    for step in range(5):
        state = cell.evaluate(joint1=0.1 * step, joint2=angle)
    state = cell.states.ever(
        lambda state: any("hardly moved" not in text for text in remarks(state)), "a remark about a robot that moved"
    )
    assert "hides true collisions" in remarks(state)[0]
    assert cell.node.output().count(ENTRY) == 1


def test_a_pair_that_was_apart_once_is_never_named(cell):
    assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE
    first = cell.evaluate(joint1=0, joint2=pi)
    assert first.status == CollisionState.COLLIDING
    for step in range(30):
        assert not remarks(cell.evaluate(joint1=0.01 * step, joint2=pi))
    assert ENTRY not in cell.node.output()


def test_an_ignored_pair_is_not_checked(start):
    cell = start("--ignore", "base,tip")
    assert cell.evaluate(joint1=0, joint2=pi).status == CollisionState.FREE
    state = cell.evaluate(joint1=0, joint2=0)
    assert state.status == CollisionState.FREE and ENTRY not in cell.node.output()
