"""What a shell completes where a name is asked for: `cairn --install-completion` switches it on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from cairn import maps, shipped


def names_of(
    kind: Literal["controllers", "maps", "profiles", "scenarios"],
) -> Callable[[str], list[str]]:
    """What completes the names that come with Cairn; files of that kind complete by the shell."""

    def complete(incomplete: str) -> list[str]:
        names = maps.shipped() if kind == "maps" else shipped.names(kind)
        return [name for name in names if name.startswith(incomplete)]

    return complete
