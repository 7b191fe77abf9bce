"""The closed loop: rates, lags, delays and noise between a plant and its controllers."""
