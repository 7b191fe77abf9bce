"""Bitepoint: an open bench for vehicle launch and driveline torque control."""
