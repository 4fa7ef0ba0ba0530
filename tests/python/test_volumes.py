"""Tests of bounding volumes: results do not depend on the selected kind."""

import pickle

import numpy as np
import pytest

import clearance as cl

KINDS = ["obb", "rss", "lss", "pss", "aabb", "kdop18", "kios"]


def results(checker, states):
    """Everything that a checker reports about these states, to the bit."""
    distances = checker.distance(states, 0.5)
    fields = ("self_distance", "world_distance", "self_pair", "world_pair", "self_points", "world_points")
    reports = checker.check(states, 0.1, max_contacts=0)
    return (
        checker.is_free(states).tolist(),
        [np.asarray(getattr(distances, field)).tolist() for field in fields],
        [(sorted(report.pairs), [(d.pair, d.distance) for d in report.distances]) for report in reports],
    )


@pytest.fixture(scope="module")
def few(states):
    return states[:60]


@pytest.fixture(scope="module")
def with_boxes(robot, world, few):
    found = results(cl.Checker(robot, world), few)
    assert 5 < sum(found[0]) < 55
    return repr(found)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_gives_the_same_results(robot, world, few, with_boxes, kind):
    checker = cl.Checker(robot, world, volumes=kind)
    assert checker.settings["volumes"] == kind
    assert repr(results(checker, few)) == with_boxes


def test_links_have_kinds_of_their_own(robot, world, few, with_boxes):
    checker = cl.Checker(robot, world, volumes="rss, hand=kios,link5=obb")
    assert checker.settings["volumes"] == "rss,hand=kios,link5=obb"
    assert repr(results(checker, few)) == with_boxes
    # obstacles have boxes, the link has not
    assert repr(results(cl.Checker(robot, world, volumes="hand=pss"), few)) == with_boxes
    restored = pickle.loads(pickle.dumps(checker))
    assert restored.settings["volumes"] == checker.settings["volumes"]
    assert repr(results(restored, few)) == with_boxes


@pytest.mark.parametrize(
    "volumes, kind, words",
    [
        ("box", ValueError, "volumes: 'box' is no kind of bounding volume; there are " + ", ".join(KINDS)),
        ("RSS", ValueError, "volumes: 'RSS' is no kind of bounding volume"),
        ("rss,hand=ball", ValueError, "volumes: link 'hand': 'ball' is no kind of bounding volume"),
        ("rss,pss", ValueError, "volumes: 'pss' is empty or given twice; write KIND or LINK=KIND"),
        ("", ValueError, "volumes: '' is empty"),
        ("rss,nose=pss", cl.Error, "volumes: the robot has no link 'nose'; its links with collision geometry are .*hand"),
        (3, TypeError, "volumes is 3, but must be a text such as 'rss'"),
        (None, TypeError, "volumes is None, but must be a text"),
    ],
)
def test_what_does_not_exist_is_rejected(robot, world, volumes, kind, words):
    with pytest.raises(kind, match=words):
        cl.Checker(robot, world, volumes=volumes)
