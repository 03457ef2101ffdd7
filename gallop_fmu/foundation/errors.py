"""Errors that a user of the package can meet and cure."""


class SceneError(ValueError):
    """A scene, or a file that belongs to it, cannot be used.

    The message has one line per problem: the field, the value given, what is allowed and what the
    field means.
    """
