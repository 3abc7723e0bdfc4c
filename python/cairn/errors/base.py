"""The class that all errors share."""

from typing import Any


class CairnError(ValueError):
    """Something given to Cairn was wrong; the message says what, where, and what would be right."""

    def __init__(self, message: str, **fields: Any) -> None:
        super().__init__(message)
        for name, value in fields.items():
            setattr(self, name, value)
