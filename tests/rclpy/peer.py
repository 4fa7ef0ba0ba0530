"""Test helper: an rclpy node with a thread for its callbacks, and recorders of the messages that it receives."""

import functools
import threading
import time
from concurrent.futures import Future
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass

import rclpy
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.time import Time

DEADLINE = 20.0  # [s] discovery between two middlewares on a loaded machine may take several seconds
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class CallbacksEnded(RuntimeError):
    """The thread of the callbacks has died: nothing that is waited for can come any more."""


def _between_callbacks(method):
    """The method of a node, called between callbacks."""

    @functools.wraps(method)
    def call(self, *args, **kwargs):
        return self.between_callbacks(lambda: method(self, *args, **kwargs))

    return call


class PeerNode(Node):
    """A node of which any thread may make and destroy parts.

    An executor that waits for a part while another thread destroys it dies of `InvalidHandle`, and rclpy guards few of its steps
    against that.
    """

    def __init__(self, *args, **kwargs):
        self.between_callbacks = lambda make: make()  # no executor has it yet
        super().__init__(*args, **kwargs)


PARTS = ("publisher", "subscription", "client", "service", "timer", "guard_condition")
for _name in [f"{act}_{part}" for act in ("create", "destroy") for part in PARTS] + ["add_waitable", "remove_waitable"]:
    setattr(PeerNode, _name, _between_callbacks(getattr(Node, _name)))


class Peer:
    """Publishes, records and calls; whoever waits here waits for a condition."""

    _alive = []  # all peers of this process

    def __init__(self, domain_id):
        self.domain_id = domain_id
        self.changed = threading.Condition()
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain_id)
        self.node = PeerNode("peer", context=self._context, enable_rosout=False)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._leaving = threading.Event()
        self._fault = None  # what the thread died of
        self._is_told = False
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self.node.between_callbacks = self.between_callbacks
        self._thread.start()
        Peer._alive.append(self)

    def _spin(self):
        try:
            with suppress(ExternalShutdownException):
                while not self._leaving.is_set():
                    self._executor.spin_once(timeout_sec=0.1)
        except BaseException as fault:
            self._fault = fault
            self._wake()

    def _wake(self, *_):
        with self.changed:
            self.changed.notify_all()

    def _check(self):
        if self._fault:
            self._is_told = True
            raise CallbacksEnded("the thread of the callbacks has died") from self._fault

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        # an executor that is shut down while it spins trips over its own destroyed handles
        self._leaving.set()
        self._thread.join()
        self.node.between_callbacks = lambda make: make()
        Peer._alive.remove(self)
        with ExitStack() as paused:
            # rclpy crashes now and then when a participant is destroyed while another one of the process waits
            for other in Peer._alive:
                paused.enter_context(other.paused())
            self._executor.shutdown()
            self.node.destroy_node()
            rclpy.shutdown(context=self._context)
        if kind is None and not self._is_told:
            self._check()

    @contextmanager
    def paused(self):
        """The thread of the callbacks stands still meanwhile."""
        stands, goes_on = threading.Event(), threading.Event()

        def stand():
            stands.set()
            goes_on.wait()

        self._executor.create_task(stand)
        while self._thread.is_alive() and not stands.wait(0.05):
            pass
        try:
            yield
        finally:
            goes_on.set()

    def now(self):
        return self.node.get_clock().now()

    def record(self, kind, topic, only=lambda message: True, durability=DurabilityPolicy.VOLATILE):
        return Recorder(self, kind, topic, only, durability)

    def latch(self, message, topic):
        """Publishes once, for those who listen now and for those who come later."""
        publisher = self.node.create_publisher(type(message), topic, LATCHED)
        publisher.publish(message)
        return publisher

    def wait_for(self, condition, what, deadline=DEADLINE):
        """Gives the first true value of `condition()`.

        Messages wake the wait at once. Conditions on the graph or on a process have nothing to wake it, so they
        are asked again from time to time.
        """
        end = time.monotonic() + deadline
        with self.changed:
            while not (value := condition()):
                self._check()
                remaining = end - time.monotonic()
                assert remaining > 0, f"waited {deadline} s in vain for {what}"
                self.changed.wait(min(remaining, 0.05))
            return value

    def between_callbacks(self, make):
        """The value of `make()`, called where callbacks are, for what the executor must not meet half made or half destroyed."""
        if threading.current_thread() is self._thread:
            return make()
        made = Future()

        def call():
            # what is raised here is for the caller: it must not end the executor
            try:
                made.set_result(make())
            except BaseException as fault:
                made.set_exception(fault)

        self._executor.create_task(call)
        return self.result(made, "a callback")

    def result(self, future, what="an answer"):
        """The answer to an asynchronous call."""
        future.add_done_callback(self._wake)
        self.wait_for(future.done, what)
        return future.result()


@dataclass(frozen=True)
class Received:
    message: object
    number: int  # in the sequence of its publisher, counted from 1
    published: int  # [ns] when, by the clock of the publisher's machine


class Recorder:
    """The messages of one publisher on a topic, in their order; of a topic with several publishers, `only` those of one.

    There is no way to wait for "the next message", which may be about an older input. A wait names the message or the
    moment that its result has to follow (`wait_for`, `more`, `event`), or is for something that no older input could
    bring about (`ever`).

    What has arrived is never pushed out by what follows, however late its turn comes. What is lost on its way stays lost if the
    publisher no longer has it when that is noticed.
    """

    def __init__(self, peer, kind, topic, only, durability):
        self._peer = peer
        self._topic = topic
        self._only = only
        self._received = []
        everything = QoSProfile(history=HistoryPolicy.KEEP_ALL, reliability=ReliabilityPolicy.RELIABLE, durability=durability)
        peer.node.create_subscription(kind, topic, self._receive, everything)

    def _receive(self, message, info):
        if not self._only(message):
            return
        received = Received(message, info["publication_sequence_number"], info["source_timestamp"])
        with self._peer.changed:
            self._received.append(received)
            self._peer.changed.notify_all()

    def all(self):
        """Every message so far."""
        return [received.message for received in self._received]

    def after(self, mark):
        """The messages so far that follow `mark`: a message of this recorder, or a moment that `peer.now()` gave.

        The publisher began to make them after the moment: it makes one message at a time, and may have been at work on
        the first one that it published after the moment, so that this one is left out.
        """
        if isinstance(mark, Time):
            return self.published_since(mark)[1:]
        received = self.all()
        return received[next(i for i, message in enumerate(received) if message is mark) + 1 :]

    def published_since(self, moment):
        """The messages so far that were published after a moment, whenever they were made."""
        return [one.message for one in self._received if one.published > moment.nanoseconds]

    def number(self, message):
        """Its place in its publisher's sequence, counted from 1."""
        return next(one.number for one in self._received if one.message is message)

    def numbered(self, number):
        """The message at this place of the publisher's sequence; None if it was lost: those of one publisher arrive in their order."""

        def search():
            return next((one for one in self._received if one.number >= number), None)

        first = self._wait(search, f"message {number}")
        return first.message if first.number == number else None

    def wait_for(self, accept, what, after, deadline=DEADLINE):
        """The first accepted message that follows `after`: see the method of that name."""
        return self._wait(lambda: next(filter(accept, self.after(after)), None), what, deadline)

    def event(self, accept, what, since):
        """The first accepted message published after a moment: for topics with one message for each event."""
        return self._wait(lambda: next(filter(accept, self.published_since(since)), None), what)

    def ever(self, accept, what, deadline=DEADLINE):
        """The first accepted message of all, however long ago it came."""
        return self._wait(lambda: next(filter(accept, self.all()), None), what, deadline)

    def more(self, count, after):
        """At least so many messages that follow `after`."""

        def search():
            found = self.after(after)
            return found if len(found) >= count else None

        return self._wait(search, f"{count} more messages")

    def _wait(self, search, what, deadline=DEADLINE):
        try:
            return self._peer.wait_for(search, f"{what} on {self._topic}", deadline)
        except AssertionError as error:
            received = self.all()
            last = received[-1] if received else "nothing"
            raise AssertionError(f"{error}; {len(received)} messages came, the last: {last}") from None
