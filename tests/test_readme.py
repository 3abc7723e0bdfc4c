import re
import subprocess
import sys
from pathlib import Path

import typer

import cairn
from cairn.cli import app
from cairn.missions import shipped

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()
DOCUMENTS = sorted(
    [*ROOT.glob("*.md"), *(p for p in (ROOT / "docs").rglob("*.md") if "sitegen" not in p.parts)]
)


def leaves(group=None, names=()):
    """Names of every command that does something."""
    for name, each in (group or typer.main.get_command(app)).commands.items():
        if hasattr(each, "commands"):
            yield from leaves(each, (*names, name))
        else:
            yield (*names, name)


def test_the_python_of_the_readme_works(tmp_path):
    (code,) = re.findall(r"```python\n(.*?)```", README, re.S)
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    assert "reached goal" in done.stdout


def test_the_guide_to_missions_names_every_scenario():
    guide = (ROOT / "docs/guides/missions.md").read_text()
    assert set(re.findall(r"^\| `(\w+)` \|", guide, re.M)) == set(shipped())


def test_commands_at_a_glance_are_all_there_are():
    page = (ROOT / "docs/commands.md").read_text()
    for names in leaves():
        assert re.search(rf"`cairn {' '.join(names)}[ `]", page), names


def test_the_readme_is_about_one_screen():
    assert len(README.splitlines()) <= 60


def test_every_make_target_that_the_documents_name_exists():
    makefile = (ROOT / "Makefile").read_text()
    targets = set(re.findall(r"^([a-z-]+):", makefile, re.M))
    assert set(re.search(r"^\.PHONY: (.*)", makefile, re.M)[1].split()) == targets
    for document in ("README.md", "CONTRIBUTING.md"):
        named = set(re.findall(r"\bmake ([a-z-]+)\b", (ROOT / document).read_text()))
        assert named - {"a"} <= targets | {"and"}, document


def test_every_file_that_the_documents_link_to_exists():
    for document in DOCUMENTS:
        for link in re.findall(r"\]\(([^)#:]+)\)", document.read_text()):
            assert (document.parent / link).exists(), f"{document.name}: {link}"


def test_what_the_readme_uses_is_exported():
    used = set(re.findall(r"\bcairn\.(\w+)", README)) - {"errors"}
    assert used <= set(cairn.__all__)
