"""Test of the example that builds a roadmap on a Ray cluster, of which one worker is lost."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

import clearance as cl

ray = pytest.importorskip("ray", reason="there is no wheel of Ray for this Python")
from ray.cluster_utils import Cluster  # noqa: E402

EXAMPLE = Path(__file__).resolve().parents[2] / "examples/roadmap_ray.py"


@pytest.fixture
def example():
    spec = importlib.util.spec_from_file_location("roadmap_ray", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def cluster(monkeypatch, tmp_path):
    """A head without processors, and two workers."""
    monkeypatch.setenv("HOME", str(tmp_path))  # Ray keeps a token there
    monkeypatch.setenv("RAY_USAGE_STATS_ENABLED", "0")
    options = {"object_store_memory": 80 * 2**20, "include_dashboard": False}
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 0, **options})
    cluster.workers = [cluster.add_node(num_cpus=1, object_store_memory=80 * 2**20) for _ in range(2)]
    ray.init(address=cluster.address, log_to_driver=False)
    yield cluster
    ray.shutdown()
    cluster.shutdown()


def test_a_roadmap_survives_the_loss_of_a_worker(example, cluster, arm):
    lost = []

    def lose_a_worker(done, count):
        if not lost and done >= 2:
            assert count - done > 2, "tasks are left"
            cluster.remove_node(cluster.workers[0], allow_graceful=False)
            lost.append(done)

    example.EDGES_OF_A_TASK = 50
    states, edges = example.build(arm, count=400, neighbours=8, seed=3, on_progress=lose_a_worker)
    assert lost and states.shape == (400, 7)
    assert arm.is_free(states).all()

    pairs = example.candidate_edges(states, 8)
    expected = pairs[arm.are_edges_free(states[pairs[:, 0]], states[pairs[:, 1]])]
    assert np.array_equal(edges, expected) and 100 < len(edges) < len(pairs)

    label = example.components(len(states), edges)
    assert (label[edges[:, 0]] == label[edges[:, 1]]).all() and 1 <= len(np.unique(label)) < 400

    for count, neighbours in [(1, 8), (5, 0)]:
        few, none = example.build(arm, count, neighbours, seed=3)
        assert len(few) == count and none.shape == (0, 2)

    first, second = states[edges[0]]
    certificate = arm.check_motion(first, second, certificate=True).certificate
    assert cl.verify(certificate, arm.robot, arm.world, edge=(arm.expand(first), arm.expand(second)))
