"""A trained policy as a node of ROS 2, in a process of its own.

In one terminal, with the topics of examples/ros2_policy.yaml:

    skybody ros2 trajectory_ctbr --map examples/ros2_policy.yaml

In another one:

    python examples/ros2_policy.py --scenario trajectory_ctbr --steps 2000

Each action makes one step of the simulation, and the next observation comes back: the flight has
the same bits as in one process. On a vehicle the same node reads observations that another node
makes, and an inner loop takes the actions.
"""

import argparse
import time

import numpy as np
import rclpy
from skybody.program import run_program
from skybody.train.policy_file import read_policy, shipped_policy
from std_msgs.msg import Float32MultiArray
from std_srvs.srv import Trigger


def main() -> None:
    """Flies, and prints the rate."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenario", default="trajectory_ctbr", help="whose policy is shipped")
    parser.add_argument("--steps", type=int, default=2000)
    options = parser.parse_args()
    policy = read_policy(shipped_policy(options.scenario))
    states, steps = policy.states(1), 0

    rclpy.init()
    node = rclpy.create_node("policy")
    actions = node.create_publisher(Float32MultiArray, "/quad/action", 10)

    def act(message: Float32MultiArray) -> None:
        nonlocal steps
        action = policy(np.array([message.data], np.float32), states)[0]
        actions.publish(Float32MultiArray(data=action.astype(np.float32).tolist()))
        steps += 1

    node.create_subscription(Float32MultiArray, "/quad/observation", act, 10)
    ask = node.create_client(Trigger, "/skybody/states")  # the first observation
    while not ask.wait_for_service(1.0) or node.count_subscribers("/quad/action") == 0:
        print("waiting for `skybody ros2`", flush=True)
    ask.call_async(Trigger.Request())
    begin = time.perf_counter()
    while steps < options.steps:
        rclpy.spin_once(node, timeout_sec=5.0)
    print(f"{steps} steps, {steps / (time.perf_counter() - begin):.0f} steps/s")
    rclpy.try_shutdown()


if __name__ == "__main__":
    run_program(main)
