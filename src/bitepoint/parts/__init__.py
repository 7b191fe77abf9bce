"""Parts: torque laws of components and their inverses, shared by plants, planners and controllers."""
