"""Every peer restarted again and again: each time all has to be as before."""

from peer import DEADLINE, Peer
from restarts import Restarts
from rows import Row


def measure(times, domain_ids):
    return [measure_one(restart, times, next(domain_ids)) for restart in Restarts.ALL]


def measure_one(restart, times, domain_id):
    seconds, fault = [], ""
    try:
        with Peer(domain_id) as peer, Restarts(peer) as restarts:
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
    )
