"""What a robot's camera can see of the surface around it."""
