"""The page on the Rust crate: its modules, and where the full documentation is."""

from __future__ import annotations

import re
from pathlib import Path

INTRODUCTION = """\
# Rust API

The brain is a crate of its own, `crates/cairn`: no files, no clock, no randomness, no Python. Its
documentation is made by `make docs RUST=1`, which puts it into the folder `rust` of the site
(`site/rust/cairn/index.html`), or by `cargo doc --no-deps --package cairn-nav --open`. It is not a
stable interface yet.

| module | what it is |
|---|---|
"""
PRELUDE = """
A plan from Rust:

```rust
"""


def page(root: Path) -> str:
    """The page in Markdown; what a module is, is the first sentence of its documentation."""
    source = root / "crates" / "cairn" / "src"
    lines = [INTRODUCTION.rstrip("\n")]
    library = (source / "lib.rs").read_text(encoding="utf-8")
    for name in re.findall(r"^pub mod (\w+);", library, re.M):
        file = source / name / "mod.rs"
        if not file.exists():
            file = source / f"{name}.rs"
        lines.append(f"| `cairn::{name}` | {_about(file)} |")
    if example := re.search(r"^//! ```\n(.*?)^//! ```", library, re.M | re.S):
        code = re.sub(r"^//! ?(# .*\n)?", "", example.group(1), flags=re.M)
        lines.append(PRELUDE + code + "```")
    return "\n".join(lines) + "\n"


def _about(file: Path) -> str:
    told = re.findall(r"^//! ?(.*)", file.read_text(encoding="utf-8"), re.M)
    paragraph = (
        " ".join(told).split("  ")[0] if "" not in told else " ".join(told[: told.index("")])
    )
    text = paragraph.replace("\\[", "[").replace("\\]", "]").replace("|", "\\|")
    return re.sub(r"\[`([^`\]]+)`\](?:\([^)]*\))?", r"`\1`", text)
