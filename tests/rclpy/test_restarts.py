"""Tests that results return after each restart of node, driver, client or description publisher."""

import pytest

from restarts import Restarts

TIMES = 3


@pytest.mark.parametrize("restart", Restarts.ALL, ids=lambda restart: restart.__name__)
def test_everything_is_as_before_after_each_restart(restart, peer):
    with Restarts(peer) as restarts:
        for _ in range(TIMES):
            restart(restarts)
