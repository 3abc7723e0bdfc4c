"""Every way that input can be wrong: one class per cause, the offending values as attributes.

Errors of the brain arrive as the class of the same name. All are `ValueError`s, so code that does
not care which one it was can catch that.
"""

from typing import Any


class CairnError(ValueError):
    """Something given to Cairn was wrong; the message says what, where, and what would be right."""

    def __init__(self, message: str, **fields: Any) -> None:
        super().__init__(message)
        for name, value in fields.items():
            setattr(self, name, value)


# ---- profiles ------------------------------------------------------------------------------------


class ProfileValueOutOfRange(CairnError):
    """A number in a robot profile is not what physics allows."""

    profile: str
    key: str
    value: float
    least: float
