"""From measured or generated data to models: what controllers are designed from."""
