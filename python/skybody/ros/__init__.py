"""A scenario as a node of ROS: the parts that ROS 1 and ROS 2 share."""
