"""Tests of sphere covers: arrays, proofs against samples, texts, time limits, errors."""

import re
from types import MappingProxyType

import numpy as np
import pytest

import clearance as cl

# a box with a cylinder on it, a sphere, and a link without geometry
ROBOT = """<robot name="two">
  <link name="base">
    <collision><geometry><box size="0.2 0.3 0.1"/></geometry></collision>
    <collision><origin xyz="0 0 0.15"/><geometry><cylinder radius="0.05" length="0.2"/></geometry></collision>
  </link>
  <link name="ball"><collision><origin xyz="0.1 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="tip"/>
  <joint name="j" type="continuous"><parent link="base"/><child link="ball"/><axis xyz="0 0 1"/></joint>
  <joint name="f" type="fixed"><parent link="ball"/><child link="tip"/></joint>
</robot>"""


@pytest.fixture(scope="module")
def two():
    return cl.Robot.from_urdf(ROBOT)


@pytest.fixture(scope="module")
def cover(two):
    return two.sphere_cover(count=3, num_threads=2)


def points_of_base(rng, count):
    box = (rng.random((count, 3)) - 0.5) * (0.2, 0.3, 0.1)
    angle, radius = 2 * np.pi * rng.random(count), 0.05 * np.sqrt(rng.random(count))
    height = 0.05 + 0.2 * rng.random(count)
    return np.concatenate([box, np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)])


def is_in(points, spheres, tolerance=0.0):
    distances = np.linalg.norm(points[:, None, :] - spheres[None, :, :3], axis=2)
    return (distances <= spheres[:, 3] + tolerance).any(axis=1)


def distance_from_base(points):
    box = np.linalg.norm(np.maximum(np.abs(points) - (0.1, 0.15, 0.05), 0), axis=1)
    off = np.maximum(np.linalg.norm(points[:, :2], axis=1) - 0.05, 0)
    return np.minimum(box, np.hypot(off, np.maximum(np.abs(points[:, 2] - 0.15) - 0.1, 0)))


def assert_covers_base(link):
    rng = np.random.default_rng(3)
    assert is_in(points_of_base(rng, 20_000), link.spheres).all()
    directions = rng.normal(size=(4000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    for (*centre, radius), excess in zip(link.spheres, link.excesses):
        assert distance_from_base(centre + radius * directions).max() <= excess <= link.excess[1]


def test_arrays(cover):
    base, ball = cover.links
    assert (base.link, ball.link) == ("base", "ball") and list(cover.spheres) == ["base", "ball"]
    for link in cover.links:
        assert link.spheres.dtype == np.float64 and link.spheres.shape == (len(link.excesses), 4)
        assert np.array_equal(cover.spheres[link.link], link.spheres)
        assert 1 <= len(link.spheres) <= 3 and not link.ended_by_time
        assert 0 <= link.excess[0] <= link.excess[1] <= cover.largest_error and link.uncovered_depth == (0, 0)
    assert len(cover) == sum(len(spheres) for spheres in cover.spheres.values())
    assert not cover.inner and not cover.ended_by_time and "spheres around 2 links" in repr(cover)


def test_the_spheres_contain_the_link(cover):
    assert_covers_base(cover.links[0])


def test_the_same_for_any_number_of_threads(two, cover):
    assert two.sphere_cover(count=3, num_threads=1).to_urdf() == cover.to_urdf()


def test_texts(two, cover):
    spheres = cl.Robot.from_urdf(cover.to_urdf())
    measured = two.measure_spheres(spheres)
    assert [link.link for link in measured] == ["base", "ball"]
    for link, own in zip(measured, cover.links):
        assert link.count == len(own.spheres) and link.uncovered_area[0] == 0
        assert link.excess[0] <= own.excess[1] and own.excess[0] <= link.excess[1]
    assert measured[1].surface_area == pytest.approx(4 * np.pi * 0.01, rel=0.01)
    rows = re.findall(r"center: \[(.*), (.*), (.*)\]\n +radius: (.*)", cover.to_curobo())
    assert np.array_equal(np.array(rows, dtype=float), np.concatenate(list(cover.spheres.values())))
    assert cover.to_curobo().startswith("collision_spheres:\n") and cover.to_xrdf().startswith("format: xrdf\n")


def test_sizes(two):
    assert len(two.sphere_cover(total=3)) <= 3
    by_link = two.sphere_cover(counts=MappingProxyType({"base": 2, "ball": 1})).spheres
    assert len(by_link["base"]) <= 2 and len(by_link["ball"]) == 1
    assert two.sphere_cover(excess=0.05).largest_error <= 0.05


def test_inner(two):
    cover = two.sphere_cover(count=2, inner=True)
    base = cover.links[0]
    assert cover.inner and base.excess == (0, 0) and (base.excesses == 0).all()
    assert 0 < base.uncovered_depth[0] <= base.uncovered_depth[1] <= cover.largest_error
    directions = np.random.default_rng(1).normal(size=(2000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    for *centre, radius in base.spheres:
        assert distance_from_base(centre + radius * directions).max() <= 1e-9


def test_a_depth_that_is_not_reached_is_an_error():
    cube = '<collision><geometry><box size="0.001 0.001 0.001"/></geometry></collision>'
    robot = cl.Robot.from_urdf(f'<robot name="r"><link name="cube">{cube}</link></robot>')
    assert robot.sphere_cover(excess=3e-4, inner=True).largest_error <= 3e-4
    with pytest.raises(cl.Error, match="link 'cube': no cover with an excess"):
        robot.sphere_cover(excess=1e-6, inner=True)


def test_a_timeout_keeps_the_proof(two, cover):
    short = two.sphere_cover(count=3, timeout=0)
    assert short.ended_by_time and all(link.ended_by_time for link in short.links)
    assert_covers_base(short.links[0])
    assert short.largest_error > cover.largest_error
    assert two.sphere_cover(count=3, timeout=float("inf")).to_urdf() == cover.to_urdf()
    measured = two.measure_spheres(cl.Robot.from_urdf(cover.to_urdf()), timeout=0)
    assert all(link.uncovered_area[0] == 0 for link in measured)


@pytest.mark.parametrize(
    "arguments, kind, text",
    [
        ({}, TypeError, "one of count"),
        ({"count": 1, "total": 2}, TypeError, "one of count"),
        ({"count": 0}, ValueError, "count is 0, but must be a whole number, 1 or more"),
        ({"count": -1}, ValueError, "count is -1, but must be a whole number, 1 or more"),
        ({"total": 0}, ValueError, "total is 0, but must be a whole number, 1 or more"),
        ({"count": 1.5}, TypeError, "count"),
        ({"total": 1}, ValueError, "too few"),
        ({"total": 4, "inner": True}, ValueError, "not by total"),
        ({"excess": 0}, ValueError, "excess"),
        ({"excess": float("nan")}, ValueError, "excess"),
        ({"counts": {"base": 1}}, ValueError, "'ball'"),
        ({"counts": {"base": 1, "ball": 1, "nobody": 1}}, ValueError, "'nobody'"),
        ({"count": 1, "inner": 1}, TypeError, "inner"),
        ({"count": 1, "timeout": -1}, ValueError, "timeout"),
        ({"count": 1, "num_threads": 0}, ValueError, "num_threads"),
    ],
)
def test_errors(two, arguments, kind, text):
    with pytest.raises(kind, match=text):
        two.sphere_cover(**arguments)


def test_only_spheres_are_measured(two):
    with pytest.raises(cl.Error, match="must be spheres"):
        two.measure_spheres(two)
