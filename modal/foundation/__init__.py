"""What every layer uses: shape functions, root finding, change of state."""
