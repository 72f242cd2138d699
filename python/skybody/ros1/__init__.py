"""A scenario as a node of ROS 1: states, sensors and images as topics, commands as topics."""
