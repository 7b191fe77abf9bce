"""Models that one room hands to another: what is identified or derived, and what controllers are designed on."""
