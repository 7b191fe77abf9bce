"""Studies: many runs put together to answer one question."""
