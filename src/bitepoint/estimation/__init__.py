"""Estimation: observers, step functions that tell what no sensor shows; controllers use them."""
