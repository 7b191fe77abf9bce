"""Whole plants: records and a step kernel each."""
