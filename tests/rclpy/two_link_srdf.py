"""Test fixture: a node with the two-link robot and an SRDF, for tests of the services of `move_group`.

With both joints at zero the ball of the tip, of radius 0.1, is around (2, 0, 0).
"""

from math import pi

import pytest

from scene import attached, ball

ACCURACY = 1e-6  # [m]
NEARBY = {"influence_distance": 0.5, "distance_limit": 3.0}
STRETCHED = {"joint1": 0, "joint2": 0}
FOLDED = {"joint1": 0, "joint2": 5 * pi / 6}
ON_BASE = {"joint1": 0, "joint2": pi}
HELD = attached("tip", ball("part", 1, 0.4, radius=0.05, frame="tip"), ["tip"])

# The group "wrist" moves the tip alone.
SRDF = """
<robot name="two_link">
  <group name="arm"><chain base_link="base" tip_link="tip"/></group>
  <group name="wrist"><joint name="joint2"/></group>
  <disable_collisions link1="base" link2="upper" reason="Adjacent"/>
  <disable_collisions link1="upper" link2="tip" reason="Adjacent"/>
</robot>
"""


@pytest.fixture
def cell(start, tmp_path):
    path = tmp_path / "two_link.srdf"
    path.write_text(SRDF)
    cell = start("--srdf", path, parameters=NEARBY)
    cell.evaluate(**STRETCHED)
    return cell
