"""Tests of covers by capsules and boxes: arrays, proofs against samples of the surface, time limits, errors."""

import numpy as np
import pytest

import clearance as cl

# a box with a cylinder on it, and a sphere
ROBOT = """<robot name="two">
  <link name="base">
    <collision><geometry><box size="0.2 0.3 0.1"/></geometry></collision>
    <collision><origin xyz="0 0 0.15"/><geometry><cylinder radius="0.05" length="0.2"/></geometry></collision>
  </link>
  <link name="ball"><collision><origin xyz="0.1 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="j" type="continuous"><parent link="base"/><child link="ball"/><axis xyz="0 0 1"/></joint>
</robot>"""


@pytest.fixture(scope="module")
def two():
    return cl.Robot.from_urdf(ROBOT)


@pytest.fixture(scope="module", params=["capsules", "boxes"])
def cover(two, request):
    return two.shape_cover(request.param, count=2, num_threads=2)


def on_box(rng, count, size):
    points = rng.random((count, 3)) - 0.5
    axis = rng.integers(0, 3, count)
    points[np.arange(count), axis] = rng.choice([-0.5, 0.5], count)
    return points * size


def on_cylinder(rng, count, radius, length, centre):
    angle, z = 2 * np.pi * rng.random(count), rng.random(count) - 0.5
    distance = np.full(count, radius)
    is_cap = rng.random(count) < 0.3
    distance[is_cap] *= np.sqrt(rng.random(is_cap.sum()))
    z[is_cap] = np.sign(z[is_cap]) * 0.5
    return np.stack([distance * np.cos(angle), distance * np.sin(angle), length * z + centre], axis=1)


def surface(link):
    rng = np.random.default_rng(5)
    if link == "base":
        return np.concatenate([on_box(rng, 20_000, (0.2, 0.3, 0.1)), on_cylinder(rng, 20_000, 0.05, 0.2, 0.15)])
    directions = rng.normal(size=(20_000, 3))
    return (0.1, 0, 0) + 0.1 * directions / np.linalg.norm(directions, axis=1)[:, None]


def distances(kind, link, points):
    """Distances of points from each shape, shape (shapes, points)."""
    found = []
    for pose, size in zip(link.poses, link.sizes):
        local = (points - pose[:3, 3]) @ pose[:3, :3]
        if kind == "capsules":
            radius, length = size
            beyond = np.maximum(np.abs(local[:, 2]) - length / 2, 0)
            off = np.linalg.norm(np.column_stack([local[:, :2], beyond]), axis=1)
            found.append(np.maximum(off - radius, 0))
        else:
            found.append(np.linalg.norm(np.maximum(np.abs(local) - size / 2, 0), axis=1))
    return np.array(found)


def test_every_point_of_the_surface_is_covered(cover):
    for link in cover.links:
        points = surface(link.link)
        assert distances(cover.shape, link, points).min(axis=0).max() <= 1e-12
        # the test would find a shape that is smaller
        fewer = link.sizes - 0.02
        smaller = cl.LinkShapes(link.link, link.poses, fewer, link.excesses, link.excess, link.ended_by_time)
        assert distances(cover.shape, smaller, points).min(axis=0).max() > 1e-3


def test_arrays(cover):
    assert [link.link for link in cover.links] == ["base", "ball"]
    columns = {"capsules": 2, "boxes": 3}[cover.shape]
    for link in cover.links:
        count = len(link.excesses)
        assert 1 <= count <= 2 and link.poses.shape == (count, 4, 4) and link.sizes.shape == (count, columns)
        assert link.poses.dtype == link.sizes.dtype == np.float64
        for pose in link.poses:
            assert np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-12)
            assert np.linalg.det(pose[:3, :3]) > 0 and np.array_equal(pose[3], [0, 0, 0, 1])
        assert 0 <= link.excess[0] <= link.excess[1] == link.excesses.max() <= cover.largest_excess
        assert not link.ended_by_time
    assert len(cover) == sum(len(link.sizes) for link in cover.links) and not cover.ended_by_time
    assert f"{len(cover)} {cover.shape} around 2 links" in repr(cover)


def test_the_same_for_any_number_of_threads(two, cover):
    again = two.shape_cover(cover.shape, count=2, num_threads=1)
    assert again.to_urdf() == cover.to_urdf()
    links = cl.Robot.from_urdf(cover.to_urdf()).link_names
    assert links == two.link_names


def test_a_timeout_keeps_the_proof(two):
    short = two.shape_cover("boxes", count=2, timeout=0)
    assert short.ended_by_time
    base = short.links[0]
    assert distances("boxes", base, surface("base")).min(axis=0).max() <= 1e-12


@pytest.mark.parametrize(
    "arguments, kind, text",
    [
        (("cones",), ValueError, "'capsules' or 'boxes', not 'cones'"),
        (("spheres",), ValueError, "sphere_cover"),
        ((1,), TypeError, "shape"),
    ],
)
def test_errors(two, arguments, kind, text):
    with pytest.raises(kind, match=text):
        two.shape_cover(*arguments, count=1)


@pytest.mark.parametrize("count, kind", [(0, ValueError), (-1, ValueError), (1.5, TypeError), (None, TypeError)])
def test_a_count_is_needed(two, count, kind):
    with pytest.raises(kind, match=f"count is {count}, but must be a whole number, 1 or more"):
        two.shape_cover("boxes", count=count)
