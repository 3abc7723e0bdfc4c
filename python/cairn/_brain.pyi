"""Types of the compiled brain; the public names are re-exported by `cairn`."""

from typing import Any

__version__: str

class Profile:
    """A robot profile, checked: outline, limits, wheels and sensors."""

    @staticmethod
    def from_toml(text: str) -> Profile:
        """Read a profile from TOML text."""

    def to_dict(self) -> dict[str, Any]:
        """Return the profile as plain dicts and lists, keyed as in the file."""
