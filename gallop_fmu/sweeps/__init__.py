"""Many scenes: the cases of a sweep, the workers that compute them, and their rows on disk."""
