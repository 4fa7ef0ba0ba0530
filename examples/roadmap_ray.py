#!/usr/bin/env python3
"""Builds a roadmap whose edges are all proven free, on the workers of a Ray cluster.

    pip install . ray
    python examples/roadmap_ray.py --states 2000                    # on this machine
    python examples/roadmap_ray.py --states 50000 --address auto    # on the cluster that this machine belongs to

A roadmap (Kavraki et al. 1996) has free states as nodes, and edges between near ones. Each task proves some of the edges. A task
whose worker is lost runs again on another one. The roadmap does not depend on the workers: the same seed gives the same one.
"""

import argparse
import time
from pathlib import Path

import numpy as np
import ray

import clearance as cl

ROOT = Path(__file__).resolve().parents[1]
STATES_OF_A_TASK = 2000
EDGES_OF_A_TASK = 500
RETRIES = 20  # of a task whose worker was lost


checkers = {}  # of this process, by the reference that it was read from


def checker_of(reference):
    """The checker of a reference, which each process reads once."""
    if reference.hex() not in checkers:
        checkers.clear()
        checkers[reference.hex()] = ray.get(reference)
    return checkers[reference.hex()]


@ray.remote(num_cpus=1, max_retries=RETRIES)
def nearest(states, first, last, neighbours):
    """Pairs of the states from `first` to `last` with their nearest ones: indices, shape (N, 2)."""
    pairs = []
    norms = (states**2).sum(axis=1)
    for begin in range(first, last, 100):
        own = np.arange(begin, min(begin + 100, last))
        squares = norms[own, None] + norms[None, :] - 2 * states[own] @ states.T
        squares[np.arange(len(own)), own] = np.inf
        near = np.argpartition(squares, neighbours - 1, axis=1)[:, :neighbours]
        pairs.append(np.stack([np.repeat(own, neighbours), near.ravel()], axis=1))
    return np.concatenate(pairs)


@ray.remote(num_cpus=1, max_retries=RETRIES)
def prove(references, q0, q1):
    """Whether each edge is proven free: q0 and q1 of shape (N, n), result of shape (N,)."""
    return checker_of(references[0]).are_edges_free(q0, q1, num_threads=1)


def free_states(checker, count, seed):
    """Random free states within the joint limits, shape (count, n)."""
    generator = np.random.default_rng(seed)
    lower, upper = (np.where(np.isfinite(bound), bound, default)
                    for bound, default in ((checker.lower, -np.pi), (checker.upper, np.pi)))
    states = np.empty((0, len(lower)))
    for _ in range(1000):
        if len(states) >= count:
            return states[:count]
        sample = generator.uniform(lower, upper, (count, len(lower)))
        states = np.concatenate([states, sample[checker.is_free(sample)]])
    raise ValueError(f"only {len(states)} of {count} states were found: the robot is hardly ever free")


def candidate_edges(states, neighbours):
    """Pairs of each state with its nearest ones, each pair once: indices, shape (N, 2)."""
    neighbours = min(neighbours, len(states) - 1)
    if neighbours < 1:
        return np.empty((0, 2), dtype=int)
    shared, step = ray.put(states), STATES_OF_A_TASK
    parts = [(first, min(first + step, len(states))) for first in range(0, len(states), step)]
    pairs = ray.get([nearest.remote(shared, first, last, neighbours) for first, last in parts])
    return np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0)


def proven_edges(checker, states, pairs, on_progress=lambda done, all: None):
    """Those of the pairs whose straight line in joint space is proven free, from the workers of the cluster."""
    if len(pairs) == 0:
        return pairs
    shared = [ray.put(checker)]  # in a list, so that Ray passes the reference and not the object
    parts = [pairs[first : first + EDGES_OF_A_TASK] for first in range(0, len(pairs), EDGES_OF_A_TASK)]
    tasks = [prove.remote(shared, states[part[:, 0]], states[part[:, 1]]) for part in parts]
    waiting = tasks
    while waiting:
        _, waiting = ray.wait(waiting, num_returns=1)
        on_progress(len(tasks) - len(waiting), len(tasks))
    return pairs[np.concatenate(ray.get(tasks))]


def components(count, edges):
    """Number of the connected component of each state, shape (count,)."""
    label = np.arange(count)
    while True:
        least = label.copy()
        np.minimum.at(least, edges[:, 0], label[edges[:, 1]])
        np.minimum.at(least, edges[:, 1], label[edges[:, 0]])
        least = least[least]
        if np.array_equal(least, label):
            return label
        label = least


def build(checker, count, neighbours, seed, on_progress=lambda done, all: None):
    """States of shape (count, n), and edges of shape (N, 2)."""
    states = free_states(checker, count, seed)
    return states, proven_edges(checker, states, candidate_edges(states, neighbours), on_progress)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--urdf", default=ROOT / "urdf/demo_arm/demo_arm.urdf", type=Path)
    parser.add_argument("--srdf", default=ROOT / "urdf/demo_arm/demo_arm.srdf", type=Path)
    parser.add_argument("--world", default=ROOT / "config/demo_world.yaml", type=Path)
    parser.add_argument("--group", default="arm", help="group of the SRDF whose joints move")
    parser.add_argument("--states", default=2000, type=int, help="number of free states")
    parser.add_argument("--neighbours", default=10, type=int, help="number of nearest states that each state is joined with")
    parser.add_argument("--seed", default=1, type=int)
    parser.add_argument("--address", help="address of a Ray cluster, or 'auto' [default: workers on this machine]")
    parser.add_argument("--workers", type=int, help="number of workers on this machine [default: one per core]")
    parser.add_argument("--out", type=Path, help="file for the roadmap (.npz: states, edges, joint_names)")
    arguments = parser.parse_args()

    robot = cl.Robot.from_urdf(arguments.urdf, srdf=arguments.srdf)
    checker = cl.Checker(robot, cl.World.from_file(arguments.world, robot), group=arguments.group)
    ray.init(arguments.address, num_cpus=None if arguments.address else arguments.workers, log_to_driver=False)
    begin = time.perf_counter()
    states, edges = build(checker, arguments.states, arguments.neighbours, arguments.seed)
    seconds = time.perf_counter() - begin
    sizes = np.unique(components(len(states), edges), return_counts=True)[1]
    print(f"{len(states)} states, {len(edges)} edges proven free, the largest of {len(sizes)} components has {sizes.max()} states; "
          f"{seconds:.2f} s on {int(ray.cluster_resources()['CPU'])} workers")
    if arguments.out:
        np.savez_compressed(arguments.out, states=states, edges=edges, joint_names=checker.joint_names)


if __name__ == "__main__":
    main()
