"""Reproduction of the paper on the cheapest launch of an intelligent car."""

from bitepoint.studies.eco_launch.study import NAME, SOURCE, reproduce

__all__ = ["NAME", "SOURCE", "reproduce"]
