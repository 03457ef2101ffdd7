"""Code that several tests share: random spans, checks of a run, isolated worker processes."""
