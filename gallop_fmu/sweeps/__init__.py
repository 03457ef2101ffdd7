"""Many scenes: cases of a sweep, the workers that compute them, and their results on disk."""
