"""Logs of a drive to a fuel model: filters, steady map and correction, or a plain polynomial."""

from __future__ import annotations

from bitepoint.identification.fuel.identify import FuelErrors, FuelIdentified, Tried, identify_fuel
from bitepoint.identification.fuel.logs import LogOptions

__all__ = ["FuelErrors", "FuelIdentified", "LogOptions", "Tried", "identify_fuel"]
