"""Settings that every test shares."""

import os

from hypothesis import settings

# In CI the same examples every time; elsewhere fresh ones. No deadline: a slow machine is not a failure.
settings.register_profile("gallop", derandomize="CI" in os.environ, deadline=None, print_blob=True)
settings.load_profile("gallop")
