"""Export: a part of the bench as what an ECU, a calibration tool or another simulator takes."""
