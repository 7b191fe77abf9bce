"""What is best, computed ahead: the physical optimum of a launch."""
