"""Looks through a site: every link leads somewhere, nothing is fetched from outside."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

# What a browser fetches by itself; a link that a person follows may lead out.
FETCHED = {"img": "src", "script": "src", "link": "href", "source": "src", "iframe": "src"}


class _Page(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.fetched: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        for key in ("id", "name"):
            if value := given.get(key):
                self.anchors.add(value)
        if tag == "a" and (href := given.get("href")):
            self.links.append(href)
        if tag in FETCHED and (target := given.get(FETCHED[tag])):
            self.fetched.append(target)


def faults(site: Path) -> list[str]:
    """What is wrong, in sentences; empty if all is well."""
    pages: dict[Path, _Page] = {}
    for path in sorted(site.rglob("*.html")):
        if "rust" not in path.relative_to(site).parts:
            page = pages[path.resolve()] = _Page()
            page.feed(path.read_text(encoding="utf-8"))
    found = []
    for path, page in pages.items():
        name = path.relative_to(site.resolve())
        for target in page.fetched:
            parts = urlsplit(target)
            if parts.scheme not in ("", "data") or parts.netloc:
                found.append(f"{name}: fetches {target}")
        for link in [*page.links, *page.fetched]:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            file = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if file.is_dir():
                file = file / "index.html"
            if not file.exists():
                found.append(f"{name}: {link} leads nowhere")
            elif file in pages and unquote(parts.fragment) not in {"", *pages[file].anchors}:
                found.append(f"{name}: {link}: no such place on that page")
    for style in sorted(site.rglob("*.css")):
        text = style.read_text(encoding="utf-8", errors="replace")
        if "rust" not in style.relative_to(site).parts and "@import url(http" in text:
            found.append(f"{style.relative_to(site)}: imports from outside")
        if "url(http" in text or "url(//" in text:
            found.append(f"{style.relative_to(site)}: fetches from outside")
    return found
