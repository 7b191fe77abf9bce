"""Measurements of bitepoint's speed, each against something that runs beside it; run by `python -m benchmarks`."""
