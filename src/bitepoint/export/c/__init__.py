"""A controller or a plant as a folder of C99: sources, calibration, builds, self-test, bare-metal image, report."""

from bitepoint.export.c.package import export_c

__all__ = ["export_c"]
