"""Tests of the test helper `peer`: parts come and go while callbacks run, and no caller waits for dead callbacks."""

import threading

import pytest
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.exceptions import InvalidTopicNameException
from rclpy.waitable import NumberOfEntities, Waitable
from std_msgs.msg import Bool
from std_srvs.srv import SetBool

from peer import CallbacksEnded, Peer

PARTS = {
    "publisher": (Bool, "/part", 10),
    "subscription": (Bool, "/part", lambda _: None, 10),
    "client": (SetBool, "/part"),
    "service": (SetBool, "/part", lambda _, response: response),
    "timer": (0.001, lambda: None),
}


class Meanwhile(Waitable):
    """Has the executor do something in the midst of gathering what it waits for, once."""

    def __init__(self, act):
        super().__init__(ReentrantCallbackGroup())
        self._act = act

    def __enter__(self):
        pass

    def __exit__(self, *_):
        pass

    def get_num_entities(self):
        act, self._act = self._act, lambda: None
        act()
        return NumberOfEntities()

    def add_to_wait_set(self, wait_set):
        pass

    def is_ready(self, wait_set):
        return False


@pytest.mark.parametrize("part", PARTS)
def test_what_another_thread_destroys_while_the_executor_gathers_parts_ends_no_callbacks(peer, part):
    made = getattr(peer.node, f"create_{part}")(*PARTS[part])
    goes_on = threading.Event()
    ask = peer.between_callbacks

    def asks(make):
        goes_on.set()
        return ask(make)

    def destroy():
        peer.node.between_callbacks = asks
        getattr(peer.node, f"destroy_{part}")(made)
        goes_on.set()

    destroyer = threading.Thread(target=destroy)

    def meanwhile():
        destroyer.start()
        goes_on.wait()

    peer.node.add_waitable(Meanwhile(meanwhile))
    peer.wait_for(lambda: destroyer.ident and not destroyer.is_alive(), "the end of the destroying thread")
    assert peer.between_callbacks(lambda: 7) == 7


@pytest.mark.parametrize("part", PARTS)
def test_parts_come_and_go_while_callbacks_run(peer, part):
    ticks = []
    peer.node.create_timer(0.0005, lambda: ticks.append(None))
    for _ in range(100):
        getattr(peer.node, f"destroy_{part}")(getattr(peer.node, f"create_{part}")(*PARTS[part]))
    seen = len(ticks)
    peer.wait_for(lambda: len(ticks) > seen, "a callback")


def test_what_a_callback_makes_is_made_at_once(peer):
    made = []
    peer.between_callbacks(lambda: made.append(peer.node.create_publisher(Bool, "/part", 10)))
    assert made
    peer.node.destroy_publisher(made[0])


def test_what_can_not_be_made_fails_where_it_was_asked_for(peer):
    with pytest.raises(InvalidTopicNameException):
        peer.node.create_publisher(Bool, "no name", 10)
    assert peer.between_callbacks(lambda: 7) == 7


def fails():
    raise ZeroDivisionError("a fault in a callback")


def test_waiting_callers_get_the_reason_why_no_callback_follows(domain_id):
    with pytest.raises(CallbacksEnded) as reported, Peer(domain_id) as peer:
        peer.node.create_timer(0.001, fails)
        # far beyond the time that a test may take
        peer.wait_for(lambda: False, "what never comes", deadline=1e6)
    assert isinstance(reported.value.__cause__, ZeroDivisionError)


def test_callbacks_that_ended_unseen_fail_the_test_in_the_end(domain_id):
    with pytest.raises(CallbacksEnded) as reported, Peer(domain_id) as peer:
        peer.node.create_timer(0.001, fails)
        peer._thread.join()
    assert isinstance(reported.value.__cause__, ZeroDivisionError)
