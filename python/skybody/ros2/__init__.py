"""A scenario as a node of ROS 2: states, sensors and images as topics, commands as topics."""
