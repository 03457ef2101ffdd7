"""Errors that a user can correct."""


class SceneError(ValueError):
    """A scene, or a file that belongs to it, cannot be used.

    The message has one line per problem: field, given value, allowed values, meaning of the field.
    """
