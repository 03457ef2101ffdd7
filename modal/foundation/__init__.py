"""What every layer uses: a scene with one number changed, root finding, change of state."""
