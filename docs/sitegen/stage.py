"""Puts the pages of the site together in one folder: those written, those generated, and pictures.

Written pages stay plain Markdown that also reads well on a forge. Links between them, to files of
the repository and to generated pages (`project:/reference/navigator.md`) are turned to where those
are on the site.
"""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path

from sitegen import api, commands, configuration, figures, rust_api

HERE = Path(__file__).parent
# Pages of the repository's root, and where they are on the site.
ROOT_PAGES = {
    "ARCHITECTURE.md": "project/architecture.md",
    "BENCHMARKS.md": "project/benchmarks.md",
    "CHANGELOG.md": "project/changelog.md",
    "CONTRIBUTING.md": "project/contributing.md",
    "REFERENCES.md": "project/references.md",
    "README.md": "index.md",
}
START = ["first-run", "commands"]
CONCEPTS = ["plan", "track", "avoid", "localise", "navigate", "record"]
GUIDES = ["missions", "robot", "behaviour", "map-format", "stack"]
LINK = re.compile(r"(\]\()([^()\s]+)(\))")
FENCE = re.compile(r"^(`{3,})[^\n]*\n.*?^\1`*\s*$|^(?: {4}[^\n]*\n)+", re.M | re.S)
PICTURES = (".png", ".jpg", ".svg", ".gif", ".webp")


class LinkBroken(ValueError):
    """A link of a page leads nowhere."""


class Stage:
    """The folder that Sphinx reads."""

    def __init__(self, root: Path, out: Path) -> None:
        """Pages of the repository at `root`, put together in `out`."""
        self.root, self.out = root, out
        self.broken: list[str] = []
        self.written: set[Path] = set()
        docs = root / "docs"
        pages = [page for page in docs.rglob("*.md") if "sitegen" not in page.parts]
        self.places = {page: page.relative_to(docs).as_posix() for page in sorted(pages)}
        self.places |= {root / name: place for name, place in ROOT_PAGES.items()}

    def make(self) -> None:
        """Write every page; raises `LinkBroken` with all links that lead nowhere."""
        generated = dict(self._generated())
        self.known = {*self.places.values(), *generated, "index.md"}
        for page, place in self.places.items():
            if place != "index.md":
                self._write(place, self._turned(page.read_text(encoding="utf-8"), page, place))
        template = HERE / "index.md"
        index = template.read_text(encoding="utf-8").replace("<!-- contents -->", self._contents())
        self._write("index.md", self._turned(index, self.root / "docs" / "index.md", "index.md"))
        for place, text in generated.items():
            self._write(place, self._turned(text, self.root / "docs" / place, place))
        for picture in figures.draw(self.out / "figures"):
            self.written.add(picture)
        for old in sorted(self.out.rglob("*")):
            if old.is_file() and old not in self.written:
                old.unlink()
        if self.broken:
            raise LinkBroken("\n".join(self.broken))

    def _generated(self):
        for name, text in configuration.pages(self.root):
            yield f"reference/{name}.md", text
        yield "reference/commands.md", commands.page()
        for name, text in api.pages():
            yield f"reference/python/{name}.md", text
        yield "reference/rust.md", rust_api.page(self.root)

    def _contents(self) -> str:
        """The tables of contents; pages that nobody lists come under their own heading."""
        listed = {f"{name}.md" for name in ("paper", *START)}
        others = [
            place.removesuffix(".md")
            for page, place in self.places.items()
            if page.parent == self.root / "docs" and place not in listed
        ]
        reference = ["commands", "navigator", "scenario", "profile", "controller", "rust"]
        parts = {
            "Start": START,
            "Concepts": [f"concepts/{name}" for name in CONCEPTS],
            "Guides": [f"guides/{name}" for name in GUIDES],
            "In depth": sorted(others),
            "Reference": [
                "paper",
                *(f"reference/{name}" for name in reference[:-1]),
                *(f"reference/python/{name}" for name in api.MODULES),
                "reference/rust",
            ],
            "Project": sorted(place[:-3] for place in ROOT_PAGES.values() if place != "index.md"),
        }
        return "\n\n".join(
            f"```{{toctree}}\n:caption: {caption}\n:maxdepth: 1\n:hidden:\n\n"
            + "\n".join(names)
            + "\n```"
            for caption, names in parts.items()
        )

    def _turned(self, text: str, page: Path, place: str) -> str:
        """`text` with its links as they are on the site; code stays as it is."""

        def turn(match: re.Match[str]) -> str:
            return match.group(1) + self._target(match.group(2), page, place) + match.group(3)

        done, end = [], 0
        for fence in FENCE.finditer(text):
            done += [LINK.sub(turn, text[end : fence.start()]), fence.group()]
            end = fence.end()
        return "".join([*done, LINK.sub(turn, text[end:])])

    def _target(self, link: str, page: Path, place: str) -> str:
        if link.startswith(("http://", "https://", "#", "mailto:")):
            return link
        path, hash_, anchor = link.partition("#")
        if path.startswith(("project:/", "/")):
            target = path.removeprefix("project:").removeprefix("/")
            if target in self.known or target.startswith("figures/"):
                return self._relative(target, place) + hash_ + anchor
            self.broken.append(f"{place}: no page `{target}`")
            return link
        file = Path(os.path.normpath(page.parent / path))
        if file in self.places:
            return self._relative(self.places[file], place) + hash_ + anchor
        if not file.exists():
            self.broken.append(f"{place}: `{link}` leads nowhere")
            return link
        inside = file.relative_to(self.root).as_posix()
        if file.is_dir():
            return self._listing(inside, place)
        kind = "pictures" if file.suffix in PICTURES else "files"
        copied = f"{kind}/{inside}"
        self._copy(file, copied)
        return self._relative(copied, place)

    def _listing(self, folder: str, place: str) -> str:
        self.broken.append(f"{place}: `{folder}` is a folder; link to a file in it")
        return folder

    def _relative(self, target: str, place: str) -> str:
        return os.path.relpath(target, Path(place).parent).replace(os.sep, "/")

    def _copy(self, file: Path, place: str) -> None:
        target = self.out / place
        self.written.add(target)
        if not target.exists() or target.read_bytes() != file.read_bytes():
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, target)

    def _write(self, place: str, text: str) -> None:
        target = self.out / place
        self.written.add(target)
        if not target.exists() or target.read_text(encoding="utf-8") != text:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text, encoding="utf-8")
