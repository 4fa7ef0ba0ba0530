"""Tests of pickles, processes, threads and signals."""

import copy
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import clearance as cl
from conftest import ALL_KINDS, SRDF, URDF, WORLD


def check_in_process(arguments):
    checker, q = arguments
    return checker.is_free(q)


@pytest.mark.parametrize("method", ["spawn", "fork"])
def test_processes(checker, states, method):
    """A forked process has none of the threads that this one has."""
    free = checker.is_free(states)
    context = multiprocessing.get_context(method)
    with ProcessPoolExecutor(2, mp_context=context) as pool:
        parts = list(pool.map(check_in_process, [(checker, part) for part in np.array_split(states, 4)]))
    assert np.array_equal(np.concatenate(parts), free)


def test_pickles(robot, checker, arm, home, states):
    for original in (checker, arm.attach("ball", "hand", q=home, touch_links=["finger1"])):
        restored = pickle.loads(pickle.dumps(original))
        q = states[:, : len(original.joint_names)]
        assert restored.pairs == original.pairs and restored.settings == original.settings
        assert np.array_equal(restored.is_free(q), original.is_free(q))
        for one, other in zip(restored.check(q[:50], 0.5), original.check(q[:50], 0.5)):
            assert [d.distance for d in one.distances] == [d.distance for d in other.distances]
    assert pickle.loads(pickle.dumps(cl.World())).names == []
    # bit by bit, as hashes of model and world show
    proof, again = (c.check_motion(home, home + 0.1, certificate=True).certificate for c in (arm, pickle.loads(pickle.dumps(arm))))
    assert proof == again == pickle.loads(pickle.dumps(proof)) == copy.copy(proof)
    restored = pickle.loads(pickle.dumps(robot))
    assert restored.joint_names == robot.joint_names and restored.group_states == robot.group_states
    assert pickle.dumps(restored) == pickle.dumps(robot)
    assert pickle.loads(pickle.dumps(cl.Robot.from_urdf(ALL_KINDS))).joint_names[0] == "t"


def test_pickles_of_unknown_versions_and_damaged_ones_are_rejected(robot, checker):
    world = cl.World()
    world.add_sphere("a", 0.1)
    world.add_mesh("b", np.eye(3), [[0, 1, 2]])
    world.add_plane("c", (0, 0, 1), -1.0)
    for original in (robot, world, checker):
        name = type(original).__name__
        restore, (version, state) = original.__reduce__()
        assert restore(version, state).__reduce__()[1][0] == version == 1
        with pytest.raises(cl.Error, match=f"this pickle of a {name} is of version 2, but this package reads version 1"):
            restore(2, state)
        for other in (state, (), ("1", state), (version,), (version, state, state)):
            with pytest.raises(cl.Error, match=f"this pickle of a {name} is of"):
                restore(*other)
        for position in range(len(state)):
            for bad in (0.5, (1, 2), "text", object(), [("x", [1.0] * 7, [], [])], {1: 2}, b"", -1):
                damaged = (*state[:position], bad, *state[position + 1 :])
                try:
                    assert type(restore(version, damaged)) is type(original)
                except cl.Error as why:
                    assert str(why)
        for bad in (None, 3, state[:-1], (*state, None)):
            with pytest.raises(cl.Error, match=f"this pickle of a {name} is damaged"):
                restore(version, bad)


def test_numbers_of_damaged_pickles_are_rejected():
    world = cl.World()
    world.add_sphere("a", 0.1)
    restore, (version, ((obstacles, *rest),)) = world.__reduce__()
    (name, pose, ((at, (kind, numbers, first, second)),), subframes), = obstacles
    nan = float("nan")
    for pose_, shape in [
        ([nan] * 7, (kind, numbers, first, second)),
        ([0] * 7, (kind, numbers, first, second)),
        (pose, (kind, [-1.0], first, second)),
        (pose, (kind, [nan], first, second)),
        (pose, ("plane", [0.0, 0.0, 0.0, 1.0], first, second)),
        (pose, ("plane", [nan, 0.0, 0.0, 1.0], first, second)),
        (pose, ("box", [1.0, nan, 1.0], first, second)),
        (pose, ("mesh", [], b"123", b"")),
        (pose, ("mesh", [], np.eye(3).tobytes(), np.array([0, 1, 7], np.uint32).tobytes())),
        (pose, ("points", [0.1], np.full(3, nan, np.float32).tobytes(), b"")),
        (pose, ("voxels", [], np.full(4, nan, np.float32).tobytes(), b"")),
        (pose, ("none", [], b"", b"")),
    ]:
        with pytest.raises(cl.Error):
            restore(version, (([(name, pose_, [(at, shape)], subframes)], *rest),))


def test_pickles_need_no_files(tmp_path, robot, world, states):
    script = (
        "import clearance as cl, pickle, sys\n"
        "robot = cl.Robot.from_urdf(sys.argv[1], sys.argv[2])\n"
        "pickle.dump((robot, cl.World.from_file(sys.argv[3], robot)), open('pickle', 'wb'))\n"
    )
    import shutil

    shutil.copytree(URDF.parent, tmp_path / "arm")
    arguments = [tmp_path / "arm" / URDF.name, tmp_path / "arm" / SRDF.name, WORLD]
    subprocess.run([sys.executable, "-c", script, *map(str, arguments)], check=True, cwd=tmp_path)
    shutil.rmtree(tmp_path / "arm")
    restored = cl.Checker(*pickle.loads((tmp_path / "pickle").read_bytes()))
    assert np.array_equal(restored.is_free(states), cl.Checker(robot, world).is_free(states))


def test_results_pickle(checker, arm, home, states):
    for result in (
        checker.distance(states[0]),
        checker.distance(states[:3], gradients=True),
        checker.check(states[0]),
        checker.clearance(states[0], 0.1),
        arm.check_motion(home, home + 0.1, certificate=True),
        arm.check_edges(home, home),
        arm.check_trajectory([0, 1], np.stack([home, home])),
        checker.find_free_state(states[0], max_checks=10),
        cl.Error("text"),
    ):
        assert repr(pickle.loads(pickle.dumps(result))) == repr(result)


def test_threads_share_a_checker(checker, states):
    free = checker.is_free(states)
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(checker.is_free, states)) == free.tolist()
        batches = list(pool.map(lambda _: checker.is_free(states), range(16)))
    assert all(np.array_equal(batch, free) for batch in batches)


def test_other_threads_run_during_a_batch(checker, robot):
    """They count while the batch runs, which can only be if it does not hold the GIL."""
    q, counts, ended = robot.random(1, 60_000), [0], threading.Event()

    def count():
        while not ended.is_set():
            counts[0] += 1

    thread = threading.Thread(target=count)
    thread.start()
    try:
        before = counts[0]
        checker.is_free(q)
        during = counts[0] - before
    finally:
        ended.set()
        thread.join()
    # while it is held, the counter can not get on
    assert during > 1000


INTERRUPTED = """
import os, signal, sys, threading, time
import numpy as np
import clearance as cl
# a shell's background jobs, and what they start, ignore it
signal.signal(signal.SIGINT, signal.default_int_handler)
robot = cl.Robot.from_urdf(sys.argv[1], sys.argv[2])
checker = cl.Checker(robot, cl.World.from_file(sys.argv[3], robot))
q = robot.random(0, 3_000_000)
other = q[::-1]
# a ball that almost touches a box all along its way: one edge takes minutes
rail = cl.Robot.from_urdf('''<robot name="ball"><link name="rail"/>
  <link name="ball"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="x" type="prismatic"><parent link="rail"/><child link="ball"/><axis xyz="1 0 0"/>
    <limit lower="-5" upper="5" velocity="1" effort="1"/></joint></robot>''')
floor = cl.World()
floor.add_box("floor", (20, 20, 2), (0, 0, -1.1 - 1e-8))
ball, endless = cl.Checker(rail, floor), dict(tolerance=1e-13, budget=10**18)
calls = {"one edge": lambda: ball.are_edges_free([-4.0], [4.0], **endless), "one motion": lambda: ball.check_motion([-4.0], [4.0], **endless),
         "states": lambda: checker.is_free(q), "distances": lambda: checker.distance(q),
         "edges": lambda: checker.are_edges_free(q[:20000], other[:20000], tolerance=1e-7),
         "spheres": lambda: robot.sphere_cover(count=100)}
call = calls[sys.argv[4]]
assert ball.check_motion([-4.0], [4.0], timeout=0.2, **endless).reason == cl.Reason.DEADLINE
try:
    print("ready", flush=True)
    while True:
        call()
except KeyboardInterrupt:
    print("interrupted", flush=True)
print(checker.is_free(q[:1000]).shape)
"""


@pytest.mark.parametrize("call", ["states", "distances", "edges", "one edge", "one motion", "spheres"])
def test_ctrl_c_ends_a_long_call(call):
    arguments = [sys.executable, "-c", INTERRUPTED, str(URDF), str(SRDF), str(WORLD), call]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout.readline() == "ready\n"
            process.send_signal(signal.SIGINT)
            # one call takes much longer than this on any machine that passes the other tests
            output, _ = process.communicate(timeout=60)
        finally:
            process.kill()
    assert output == "interrupted\n(1000,)\n" and process.returncode == 0


def test_few_pools_of_threads_are_kept(checker, states):
    """The threads of pools that are no longer used end."""
    sizes = range(2, 14)

    def threads():
        found = 0
        for task in Path("/proc/self/task").iterdir():
            try:
                found += (task / "comm").read_text().startswith("clearance-")
            except OSError:
                pass  # it has ended
        return found

    free = checker.is_free(states)
    for size in sizes:
        assert np.array_equal(checker.is_free(states, num_threads=size), free)
    most, deadline = sum(sorted(sizes)[-8:]), time.monotonic() + 60
    while threads() > most and time.monotonic() < deadline:
        time.sleep(0.01)
    assert 0 < threads() <= most < sum(sizes)


def test_results_without_memory_raise():
    """Robots without joints have states of no size, so that batches of any length can be given."""
    point = cl.Robot.from_urdf("<robot name='r'><link name='a'><collision><geometry><sphere radius='1'/></geometry></collision></link></robot>")
    world = cl.World()
    world.add_sphere("s", 1.0, (5, 0, 0))
    fixed = cl.Checker(point, world)
    states = np.zeros((10**17, 0))
    for call in (
        lambda: fixed.is_free(states),
        lambda: fixed.distance(states),
        lambda: fixed.check(states),
        lambda: fixed.clearance(states, 0.1),
        lambda: fixed.are_edges_free(states, states),
        lambda: fixed.check_edges(states[:1], states),
        lambda: fixed.are_edges_free(np.zeros((10**9, 1, 0)), np.zeros((10**9, 0))),
        lambda: fixed.check_edges(np.zeros((10**12, 1, 0)), np.zeros((10**12, 0))),
        lambda: fixed.check_trajectory(None, states),
        lambda: point.forward_kinematics(states),
        lambda: cl.Robot.from_urdf(URDF).random(size=10**15),
        lambda: cl.Robot.from_urdf(URDF).random(size=10**18),
    ):
        with pytest.raises(MemoryError):
            call()
    assert fixed.is_free(states[0]) and fixed.is_free(states[:20]).all()


def test_memory_of_dropped_checkers_is_limited(robot, world, states):
    """A thread keeps the memory of a few checkers only."""
    first = cl.Checker(robot, world)
    free = first.is_free(states[0])
    for padding in np.linspace(0, 0.01, 20):
        cl.Checker(robot, world, padding=padding).is_free(states[0])
    assert first.is_free(states[0]) == free
