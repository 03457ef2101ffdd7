"""The checksum of resource files and saved states."""


def fnv1a(content: bytes) -> int:
    """FNV-1a, 64 bit."""
    value = 1469598103934665603
    for byte in content:
        value = ((value ^ byte) * 1099511628211) & 0xFFFFFFFFFFFFFFFF
    return value
