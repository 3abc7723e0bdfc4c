"""`make docs`: the site, from the repository alone, into `site/`; nothing is fetched.

PYTHONPATH=docs python -m sitegen [--rust] [SITE]
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

from sitegen.check import faults
from sitegen.stage import LinkBroken, Stage

ROOT = Path(__file__).parents[2]


def main() -> int:
    """Build it; 1 if anything is wrong with it."""
    arguments = argparse.ArgumentParser(prog="sitegen", description=__doc__)
    arguments.add_argument("site", nargs="?", type=Path, default=ROOT / "site")
    arguments.add_argument(
        "--rust", action="store_true", help="with the documentation of the crate"
    )
    given = arguments.parse_args()
    try:
        from sphinx.cmd.build import build_main  # pyright: ignore[reportMissingImports]
    except ImportError:
        print('the site is built by Sphinx: pip install "cairn-nav[docs]"', file=sys.stderr)
        return 2
    work = ROOT / "target" / "site"
    try:
        Stage(ROOT, work / "pages").make()
    except LinkBroken as error:
        print(error, file=sys.stderr)
        return 1
    settings = ["-b", "html", "-c", str(Path(__file__).parent), "-d", str(work / "doctrees")]
    strict = ["-q", "-E", "-W", "--keep-going", "-j", "auto"]
    if code := build_main([*settings, *strict, str(work / "pages"), str(given.site)]):
        return code
    if given.rust:
        _rustdoc(given.site)
    wrong = faults(given.site)
    print("\n".join(wrong), file=sys.stderr, end="\n" if wrong else "")
    print(f"{given.site / 'index.html'}")
    return 1 if wrong else 0


def _rustdoc(site: Path) -> None:
    """The documentation of the crate beside the site; a warning is an error."""
    environment = {**os.environ, "RUSTDOCFLAGS": "-D warnings"}
    subprocess.run(
        ["cargo", "doc", "--no-deps", "--package", "cairn-nav", "--quiet"],
        cwd=ROOT, env=environment, check=True,
    )  # fmt: skip
    made = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "doc"
    shutil.copytree(made, site / "rust", dirs_exist_ok=True)


if __name__ == "__main__":
    sys.exit(main())
