import os
from math import pi
from clearance_msgs.msg import CollisionState
from std_msgs.msg import String, Float64
from std_srvs.srv import SetBool
import scene as scenes
import two_link
from scene_client import SceneClient
from recordings import outcome

def test_seed(start, peer):
    file = "/tmp/seed.mcap"
    if os.path.exists(file): os.remove(file)
    topic = "/seed/robot_description"
    publisher = peer.latch(String(data=two_link.description()), topic)
    p = {"influence_distance": 0.5, "distance_limit": 2.0, "record_file": file,
         "slowdown_distance_self": 0.8, "slowdown_distance_world": 0.8, "slowdown_release_count": 2}
    cell = start(urdf=None, name="clearance", namespace="/seed", parameters=p)
    cell.has_model(1)
    scales = peer.record(Float64, cell.node.private("speed_scale"))
    cell.judged(joint1=0, joint2=5 * pi / 6)
    scene = SceneClient(cell)
    scene.change(scenes.ball("ball", x=1.5, y=0.5), scenes.move("ball", scenes.pose(1.5, 0.4, 0.1, angle=0.3)))
    cell.judged(joint1=0, joint2=0)
    scene.change(scenes.attached("tip", scenes.ball("part", x=1.2, radius=0.05, frame="tip"), ["tip"]))
    cell.judged(joint1=0, joint2=5 * pi / 6)
    cell.parameters.succeed(padding=0.01, look_ahead_horizon=0.5)
    cell.moving({"joint1": 0, "joint2": pi}, [0.1, -0.2])
    publisher.publish(String(data=two_link.description_with_cube(0.8)))
    cell.has_model(2)
    enable = peer.node.create_client(SetBool, cell.node.private("enable"))
    peer.wait_for(enable.service_is_ready, "enable")
    peer.result(enable.call_async(SetBool.Request(data=False)))
    cell.unknown("disabled")
    peer.result(enable.call_async(SetBool.Request(data=True)))
    elbow = two_link.Driver(peer, cell.node.relative("joint_states"))
    elbow.report(joint2=0.0)
    cell.judged(joint1=0.2)
    cell.states.wait_for(lambda s: s.status == CollisionState.FREE, "FREE", after=len(cell.states.messages))
    assert cell.node.stop() == 0
    r = outcome(file)
    print(r)
    assert r["difference"] is None, r
