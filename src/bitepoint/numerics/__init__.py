"""Numerics that run inside kernels: integration, table lookup, filters."""
