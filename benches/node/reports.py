"""Reader of the node's periodic `/diagnostics` reports, as numbers."""

import time
from dataclasses import dataclass

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.time import Time

PATIENCE = 60.0  # [s] between two reports, of which a second brings one


@dataclass(frozen=True)
class Told:
    at: float  # [s]
    numbers: dict

    def __getitem__(self, key):
        return self.numbers[key]


class Reports:
    def __init__(self, peer, node):
        self._peer = peer
        self._node = node
        self._name = f"{node.path[1:]}: collision monitor"
        self._recorder = peer.record(DiagnosticArray, "/diagnostics")

    def all(self):
        return self._read(self._recorder.all())

    def _read(self, arrays):
        reported = []
        for array in arrays:
            for status in array.status:
                if status.name == self._name:
                    at = Time.from_msg(array.header.stamp).nanoseconds * 1e-9
                    reported.append(Told(at, dict(_numbers(status.values))))
        return reported

    def wait_for(self, accept, what):
        """The first report that is accepted, of those that are published from now on."""
        start = self._peer.now()

        def search():
            assert self._node.exit_code is None, f"the node ended: {self._node.output()}"
            return next(filter(accept, self._read(self._recorder.published_since(start))), None)

        return self._peer.wait_for(search, what, PATIENCE)

    def during(self, seconds):
        """All reports of so many seconds from now on: the first one says what was before."""
        first = self.wait_for(lambda _: True, "a report")
        end = time.monotonic() + seconds
        self._peer.wait_for(lambda: time.monotonic() > end, "the end", seconds + PATIENCE)
        self.wait_for(lambda _: True, "a report")
        return [reported for reported in self.all() if reported.at >= first.at]


def came(first, last):
    """How many joint states a second were sent between two reports: those that were received, and those that got lost."""
    sent = [reported["joint states received"] + reported["joint states lost"] for reported in (first, last)]
    return (sent[1] - sent[0]) / (last.at - first.at)


def _numbers(values):
    for item in values:
        try:
            yield item.key, float(item.value)
        except ValueError:
            pass
