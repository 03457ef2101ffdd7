"""Random scenes far from comfort, what is checked of each run, and the long runs behind docs/stability.md."""
