"""Cairn plans, tracks, avoids and arrives: navigation for mobile robots that explains itself."""

from cairn import errors
from cairn._brain import __version__

__all__ = ["__version__", "errors"]
