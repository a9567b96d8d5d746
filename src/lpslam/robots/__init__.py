"""What robots are told and what they tell: messages of ROS 2, and the node that speaks them."""
