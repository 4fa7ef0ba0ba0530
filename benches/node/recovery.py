"""Benchmark of the node: time to recover after repeated restarts of each peer."""

from peer import DEADLINE, Peer
from restarts import Restarts
from rows import Row


ALL = Restarts.ALL


def measure(restart, times, domain_ids):
    seconds, fault = [], ""
    try:
        with Peer(next(domain_ids)) as peer, Restarts(peer) as restarts:
            for _ in range(times):
                seconds.append(restart(restarts))
    except AssertionError as error:
        fault = str(error).splitlines()[0]
    longest = f"; the longest took {max(seconds):.2f} s" if seconds else ""
    return Row(
        f"restart of the {restart.__name__.replace('_', ' ')}",
        f"recovered {times} times of {times}, each within {DEADLINE:g} s",
        f"{len(seconds)} times{longest}",
        len(seconds) == times,
        fault,
        works=len(seconds) == times,
    )
