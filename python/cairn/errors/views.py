"""What can be wrong with what is to be shown."""

from cairn.errors.base import CairnError


class NothingToReport(CairnError):
    """A folder or file holds neither a recorded run nor the record of a benchmark."""

    path: str
    reason: str


class AnimationFormatUnknown(CairnError):
    """An animation is asked for by a file name with another ending."""

    path: str
    known: tuple[str, ...]
