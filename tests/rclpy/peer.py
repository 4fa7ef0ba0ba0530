"""The other side of the wire: an rclpy node whose callbacks run in a thread of their own."""

import threading
import time
from contextlib import suppress

import rclpy
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

DEADLINE = 20.0  # [s] discovery between two middlewares on a loaded machine may take several seconds
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Peer:
    """Publishes, records and calls; whoever waits here waits for a condition."""

    def __init__(self, domain_id):
        self.domain_id = domain_id
        self.changed = threading.Condition()
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain_id)
        self.node = Node("peer", context=self._context, enable_rosout=False)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._leaving = threading.Event()
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self._thread.start()

    def _spin(self):
        with suppress(ExternalShutdownException):
            while not self._leaving.is_set():
                self._executor.spin_once(timeout_sec=0.1)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        # an executor that is shut down while it spins trips over its own destroyed handles
        self._leaving.set()
        self._thread.join()
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown(context=self._context)

    def now(self):
        return self.node.get_clock().now()

    def record(self, kind, topic, qos=10):
        return Recorder(self, kind, topic, qos)

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
                remaining = end - time.monotonic()
                assert remaining > 0, f"waited {deadline} s in vain for {what}"
                self.changed.wait(min(remaining, 0.05))
            return value

    def between_callbacks(self, make):
        """The value of `make()`, called where callbacks are, for what the executor must not meet half made."""
        return self.result(self._executor.create_task(make), "a callback")

    def result(self, future, what="an answer"):
        """The answer to an asynchronous call."""
        self.wait_for(future.done, what)
        return future.result()


class Recorder:
    """Every message of a topic, in the order of arrival."""

    def __init__(self, peer, kind, topic, qos):
        self._peer = peer
        self._topic = topic
        self.messages = []
        peer.node.create_subscription(kind, topic, self._receive, qos)

    def _receive(self, message):
        with self._peer.changed:
            self.messages.append(message)
            self._peer.changed.notify_all()

    def wait_for(self, accept, what, after=0, deadline=DEADLINE):
        """The first message that is accepted, of those that arrived after the first `after` ones."""

        def search():
            return next((message for message in self.messages[after:] if accept(message)), None)

        try:
            return self._peer.wait_for(search, f"{what} on {self._topic}", deadline)
        except AssertionError as error:
            last = self.messages[-1] if self.messages else "nothing"
            raise AssertionError(f"{error}; {len(self.messages)} messages came, the last: {last}") from None

    def next(self, what="a new message"):
        """A message that arrives from now on."""
        return self.wait_for(lambda _: True, what, after=len(self.messages))
