"""Launch intention: generated drivers, the windows of their launches, training and figures of the network."""
