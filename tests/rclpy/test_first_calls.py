"""Test that the first service call of a new client gets its response without delay."""

import rclpy
from clearance_msgs.srv import GetDistances
from moveit_msgs.srv import GetPlanningScene
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor

CALLS = 200
DEADLINE = 2.0  # [s] a request that is lost comes again after a heartbeat period of Fast DDS, 3 s


def test_no_first_call_of_a_new_client_waits_for_a_heartbeat(cell, domain_id):
    cell.has_model()
    node = cell.node
    services = [
        (ListParameters, node.private("list_parameters")),
        (GetParameters, node.private("get_parameters")),
        (GetDistances, node.private("get_distances")),
        (GetPlanningScene, node.relative("get_planning_scene")),
    ]
    context = Context()
    rclpy.init(context=context, domain_id=domain_id)
    # no thread of its own: the request leaves right after the discovery of the service, which is what loses it
    caller = rclpy.create_node("caller", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(caller)
    late = []
    try:
        for number in range(CALLS):
            kind, name = services[number % len(services)]
            client = caller.create_client(kind, name)
            assert client.wait_for_service(20.0), f"{name} is not discovered"
            response = client.call_async(kind.Request())
            executor.spin_until_future_complete(response, timeout_sec=DEADLINE)
            if not response.done():
                late.append((number, name))
            caller.destroy_client(client)
    finally:
        executor.shutdown()
        caller.destroy_node()
        rclpy.shutdown(context=context)
    assert late == []
