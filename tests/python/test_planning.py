"""Tests of the planner: proven paths within limits, the same path for the same seed, named failures."""

import numpy as np
import pytest

import clearance as cl


@pytest.fixture(scope="module")
def between_posts(robot):
    world = cl.World()
    for i, (x, y) in enumerate([(0.45, 0.25), (0.45, -0.25), (0.1, 0.5), (0.1, -0.5)]):
        world.add_box(f"post{i}", (0.06, 0.06, 1.6), (x, y, 0.5))
    return cl.Checker(robot, world, group="arm")


def ends(checker, robot, count):
    states = robot.random(3, 400)[:, : len(checker.joint_names)]
    free = states[checker.is_free(states)]
    return list(zip(free[:count], free[count : 2 * count]))


def test_paths_are_proven(between_posts, robot):
    bent = 0
    for start, goal in ends(between_posts, robot, 20):
        plan = between_posts.plan(start, goal, certificate=True)
        assert plan.found and plan.reason == "found" and plan.nodes >= 2
        assert np.array_equal(plan.path[0], start) and np.array_equal(plan.path[-1], goal)
        assert (between_posts.lower <= plan.path).all() and (plan.path <= between_posts.upper).all()
        assert between_posts.are_edges_free(plan.path[:-1], plan.path[1:]).all()
        t = np.linspace(0, 1, 60)[:, None, None]
        assert between_posts.is_free(plan.path[:-1] + t * (plan.path[1:] - plan.path[:-1])).all()
        assert np.isclose(plan.length, np.linalg.norm(np.diff(plan.path, axis=0), axis=1).sum())
        assert cl.verify(plan.certificate, robot, between_posts.world)
        bent += len(plan.path) > 2
    assert bent > 3


def test_a_path_has_its_certificate_or_says_why_not(between_posts, robot):
    """However much of the time the search takes."""
    (start, goal), *_ = ends(between_posts, robot, 1)
    for timeout in (1e-6, 1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.1, np.inf):
        plan = between_posts.plan(start, goal, timeout=timeout, certificate=True)
        reasons = {(True, True): "found", (True, False): "found_without_certificate", (False, False): "deadline"}
        assert plan.reason == reasons[plan.found, plan.certificate is not None]
    assert plan.certificate is not None


def test_the_same_seed_gives_the_same_path(between_posts, robot):
    others = 0
    for start, goal in ends(between_posts, robot, 8):
        paths = [between_posts.plan(start, goal, seed=seed).path for seed in (1, 1, 2)]
        assert np.array_equal(paths[0], paths[1])
        others += not np.array_equal(paths[0], paths[2])
    assert others


def test_failures_have_names(between_posts, robot):
    (start, goal), *_ = ends(between_posts, robot, 1)
    states = robot.random(4, 400)[:, : len(start)]
    colliding = states[~between_posts.is_free(states)][0]
    assert between_posts.plan(colliding, goal).reason == "start_not_free"
    assert between_posts.plan(start, colliding).reason == "goal_not_free"
    assert between_posts.plan(start, goal, max_edges=0).reason == "most_edges"
    late = between_posts.plan(start, goal, timeout=0)
    assert (late.found, late.path, late.certificate, late.reason) == (False, None, None, "deadline")


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"range": 0}, "range must be a finite number above 0: 0"),
        ({"range": np.nan}, "range must be a finite number above 0: NaN"),
        ({"timeout": -1}, "timeout is -1, but must be zero or more seconds"),
    ],
)
def test_options_are_validated(between_posts, robot, arguments, text):
    (start, goal), *_ = ends(between_posts, robot, 1)
    with pytest.raises(cl.Error, match=text):
        between_posts.plan(start, goal, **arguments)


def test_states_beyond_limits_are_rejected(between_posts, robot):
    (start, goal), *_ = ends(between_posts, robot, 1)
    with pytest.raises(cl.Error, match="goal: joint2 is at 40, beyond its limits"):
        between_posts.plan(start, np.where(np.arange(len(goal)) == 1, 40.0, goal))
    with pytest.raises(ValueError, match="start"):
        between_posts.plan(start[:-1], goal)
