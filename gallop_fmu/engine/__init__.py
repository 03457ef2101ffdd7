"""The binding to the compiled kernel."""
