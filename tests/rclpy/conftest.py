"""Test fixtures: a ROS domain, a peer and nodes for every test; the output of nodes in reports of failures."""

import itertools
import os
import tempfile
from collections import Counter
from contextlib import ExitStack

import pytest

from cell import Cell
from point_cloud_node import PointCloudNode
from node_process import NodeProcess
from peer import Peer
from scene_client import SceneClient

_logs_of_peers = tempfile.TemporaryDirectory(prefix="clearance-rclpy-")
os.environ["ROS_LOG_DIR"] = _logs_of_peers.name

# Above domain 232 the ports of DDS run out.
_domain_ids = itertools.cycle(range(1, 233))


@pytest.fixture
def domain_id():
    return next(_domain_ids)


@pytest.fixture
def peer(domain_id):
    with Peer(domain_id) as peer:
        yield peer


@pytest.fixture(scope="module")
def module_peer():
    with Peer(next(_domain_ids)) as peer:
        yield peer


@pytest.fixture
def start(peer):
    """Starts cells that end with the test: `start(parameters={...}, ros_arguments=[...])`."""
    with ExitStack() as cells:
        yield lambda *arguments, **options: cells.enter_context(Cell(peer, *arguments, **options))


@pytest.fixture
def cell(start):
    """A node that checks the two-link robot."""
    return start()


@pytest.fixture
def scene(cell):
    """Changes the world of `cell`."""
    return SceneClient(cell)


def pytest_addoption(parser):
    parser.addoption("--part", metavar="K/N", default="1/1", help="of N parts with whole files, only the K-th")


def pytest_collection_modifyitems(config, items):
    part, parts = map(int, config.getoption("--part").split("/"))
    tests = Counter(item.path for item in items)
    sizes = [0] * parts
    kept = set()
    # large files first, each to the part that has least
    for path in sorted(tests, key=lambda path: (-tests[path], path)):
        least = sizes.index(min(sizes))
        sizes[least] += tests[path]
        if least == part - 1:
            kept.add(path)
    config.hook.pytest_deselected(items=[item for item in items if item.path not in kept])
    items[:] = [item for item in items if item.path in kept]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport():
    report = yield
    if report.failed:
        for node in NodeProcess.running:
            report.sections.append((f"output of {node.path}", node.output()))
    return report


@pytest.fixture
def start_cloud(peer, request):
    def start(**options):
        cell = PointCloudNode(peer, **options)
        cell.__enter__()
        request.addfinalizer(lambda: cell.__exit__(None, None, None))
        return cell

    return start
