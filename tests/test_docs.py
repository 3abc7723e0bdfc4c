"""The documentation tells the truth: snippets run, names exist, links lead somewhere."""

import re
import shlex
import sys
from pathlib import Path

import numpy as np
import pytest
import typer

import cairn
from cairn.cli import app

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
PAGES = sorted(
    page
    for page in [*ROOT.glob("*.md"), *DOCS.rglob("*.md")]
    if "sitegen" not in page.parts and page.name != "CHANGELOG.md"
)
FENCE = re.compile(r"^```(\w*)[^\n]*\n(.*?)^```", re.M | re.S)
# Run by `make test-slow`: a drive of the benchmark, seventeen drives along a path.
SLOW = {"guides/stack.md", "concepts/track.md"}


# What a page takes as done already.
PREPARED = {"decision-record.md": ["run", "quick", "--record", "runs/office", "--no-picture"]}


def name_of(page):
    return page.relative_to(DOCS if page.is_relative_to(DOCS) else ROOT).as_posix()


def given(page):
    """What the snippets of a page take as there already: measurements, arrays."""
    sonars = cairn.Profile.load("p3at").range_count
    ranges = np.full(sonars, 2.0)
    if page.name == "avoidance.md":
        ranges = np.full(cairn.Profile.load("jackal").range_count, np.inf)
    rows = np.arange(130.0)
    elevation = 0.5 * rows[:, None] + 0.1 * np.arange(90.0)[None, :]
    return {"ranges": ranges, "wheels": (0.0, 0.0), "gyro": 0.0, "elevation": elevation}


def blocks(page):
    return FENCE.findall(page.read_text(encoding="utf-8"))


WITH_SNIPPETS = [
    pytest.param(page, marks=pytest.mark.slow if name_of(page) in SLOW else (), id=name_of(page))
    for page in PAGES
    if any(kind in ("python", "console") for kind, _ in blocks(page)) and page.name != "README.md"
]


@pytest.mark.timeout(600)
@pytest.mark.parametrize("page", WITH_SNIPPETS)
def test_every_snippet_of_a_page_runs_in_order(page, command, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))
    there = {**given(page), "__name__": "snippet"}
    if name_of(page) in PREPARED:
        there["cairn"] = cairn
        assert command(*PREPARED[name_of(page)])[0] == 0
    for kind, text in blocks(page):
        first, _, rest = text.partition("\n")
        if first.startswith("# file: "):
            (tmp_path / first.removeprefix("# file: ")).write_text(rest)
        elif kind == "python":
            exec(compile(text, name_of(page), "exec"), there)
        elif kind == "console":
            for line in re.findall(r"^\$ (cairn .*)", text, re.M):
                said, _, comment = line.partition("#")
                code, _, complaints = command(*shlex.split(said)[1:])
                expected = re.search(r"exit code (\d)", comment)
                assert code == int(expected[1] if expected else 0), f"{line}\n{complaints}"


def test_every_rust_snippet_is_a_documentation_test_of_the_crate():
    tested = "".join(
        re.sub(r"^\s*//[/!] ?(?!# Ok)", "", path.read_text(encoding="utf-8"), flags=re.M)
        for path in (ROOT / "crates").rglob("*.rs")
    )
    for page in PAGES:
        for kind, text in blocks(page):
            assert kind != "rust" or text in tested, f"{name_of(page)}:\n{text}"


def commands_named(page):
    """(the text, its words) of every `cairn …` that a page writes down."""
    text = page.read_text(encoding="utf-8")
    inline = re.findall(r"(?<!`)`cairn ([^`]+)`(?!`)", text)
    whole = re.findall(r"^(?:\$ | {4})?cairn ([^\n#`]+)", text, re.M)
    for said in [*inline, *(said for said in whole if re.match(r"[a-z-]+($| )", said))]:
        # A table escapes its bars; `{a,b}`, `[--x]` and `…` stand for choices.
        yield said, re.sub(r"\\\||[\[\]…]|\.\.\.", " ", " ".join(said.split())).split()


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_command_and_option_that_a_page_names_exists(page):
    for said, words in commands_named(page):
        known = typer.main.get_command(app)
        while words and hasattr(known, "commands"):
            if words[0].startswith("-") or words[0] == "COMMAND":
                break
            assert words[0] in known.commands, f"{name_of(page)}: cairn {said}"
            known = known.commands[words.pop(0)]
        options = {option for each in known.params for option in [*each.opts, *each.secondary_opts]}
        options |= {"--help", "-h", "--install-completion", "--show-completion", "--version"}
        for word in words:
            if word.startswith("--") and word != "--":
                assert word.split("=")[0].rstrip(".,;") in options, f"{name_of(page)}: cairn {said}"


def test_every_place_that_the_table_of_the_paper_names_exists():
    table = (DOCS / "paper.md").read_text(encoding="utf-8")
    places = re.findall(r"(?:`(\w+)` in )?`([\w./-]+\.(?:rs|py|toml|md))`", table)
    assert len(places) > 40
    for name, path in places:
        folders = [ROOT / "crates/cairn/src", ROOT / "python/cairn", ROOT / "tests", ROOT]
        file = next((each / path for each in folders if (each / path).exists()), None)
        assert file is not None, path
        text = file.read_text(encoding="utf-8")
        defined = (
            rf"\b(?:fn|struct|enum|const|trait|class|def|type)\s+{name}\b|^{name}\b|^\s+{name}[,:(]"
        )
        assert not name or re.search(defined, text, re.M), f"{path}: {name}"


def test_every_equation_figure_and_table_of_the_paper_has_its_place():
    table = (DOCS / "paper.md").read_text(encoding="utf-8")
    for number in range(1, 8):
        assert f"({number})" in table
    for number in range(1, 17):
        assert re.search(rf"Figs?\. [^|]*\b{number}\b", table), number
    assert "Table 1" in table


@pytest.fixture
def sitegen(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS))
    yield
    for name in [name for name in sys.modules if name.split(".")[0] == "sitegen"]:
        del sys.modules[name]


def test_every_setting_has_a_meaning_and_every_meaning_a_setting(sitegen):
    from sitegen.configuration import navigator_keys, pages
    from sitegen.rust_source import read_items

    items = read_items(ROOT / "crates/cairn/src")
    told = {key: text for key, _, text in navigator_keys(items)}
    assert all(told.values())

    def keys(values, before=""):
        for name, value in values.items():
            yield before + name
            if isinstance(value, dict):
                yield from keys(value, f"{before}{name}.")

    assert set(told) == set(keys(cairn.Navigator.default_config()))
    written = dict(pages(ROOT))
    assert set(written) == {"navigator", "profile", "controller", "scenario"}
    for key in ("effective_track_m", "sonar_miss_incidence_rad", "first_rad"):
        assert f"`{key}`" in written["profile"]
    assert "`inputs.NAME.range`" in written["controller"]
    assert '`[[events]] do = "hold"`' in written["scenario"]


def test_a_struct_is_read_with_its_units_names_and_choices(sitegen, tmp_path):
    from sitegen.rust_source import read_items

    (tmp_path / "x.rs").write_text(
        "/// A thing,\n/// [`Other`].\n#[serde(default)]\npub struct Thing {\n"
        "    /// How far \\[m\\].\n    pub far_m: f64,\n"
        "    #[serde(rename = \"C\")]\n    pub c: Kind,\n    hidden: f64,\n}\n\n"
        "#[serde(rename_all = \"snake_case\")]\npub enum Kind {\n    /// One.\n    #[default]\n"
        "    FirstKind,\n    /// Two.\n    Second([f64; 2]),\n}\n"
    )  # fmt: skip
    items = read_items(tmp_path)
    assert items["Thing"].text == "A thing,\n`Other`."
    assert [(part.name, part.type, part.text) for part in items["Thing"].parts] == [
        ("far_m", "f64", "How far [m]."),
        ("C", "Kind", ""),
    ]
    assert [part.name for part in items["Kind"].parts] == ["first_kind", "second"]


def slug(heading):
    """The anchor of a heading, as forges make it."""
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_between_pages_and_to_places_on_them_lead_somewhere(page, sitegen):
    from sitegen.configuration import pages as settings

    generated = (
        {f"/reference/{name}.md" for name, _ in settings(ROOT)} if page.parent != ROOT else set()
    )
    generated |= {"/reference/commands.md", "/reference/rust.md", "/reference/python/cairn.md"}
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    for link in re.findall(r"\]\(([^()\s]+)\)", text):
        if link.startswith(("http://", "https://")):
            continue
        path, _, anchor = link.partition("#")
        if path.startswith("project:"):
            place = path.removeprefix("project:")
            assert place in generated or place.startswith("/figures/"), link
            continue
        target = (page.parent / path) if path else page
        assert target.exists(), link
        if anchor:
            headings = re.findall(r"^#+ (.*)", target.read_text(encoding="utf-8"), re.M)
            assert anchor in map(slug, headings), link


def test_the_site_fetches_nothing_and_a_dead_link_is_found(sitegen, tmp_path):
    from sitegen.check import faults

    (tmp_path / "a.html").write_text(
        '<p id="here"></p><a href="b.html">b</a><a href="#here">h</a><a href="https://x.org">x</a>'
        '<script src="https://cdn.example/x.js"></script><a href="#gone">g</a><img src="no.png">'
    )
    (tmp_path / "a.css").write_text("@font-face { src: url(https://fonts.example/f.woff) }")
    found = "\n".join(faults(tmp_path))
    assert len(faults(tmp_path)) == 5
    for each in ("b.html leads nowhere", "fetches https://cdn", "#gone", "no.png", "a.css"):
        assert each in found


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_the_site_is_built_without_a_warning(sitegen, tmp_path, monkeypatch):
    pytest.importorskip("sphinx", reason='needs the extra: pip install "cairn-nav[docs]"')
    from sitegen.__main__ import main

    monkeypatch.setattr(sys, "argv", ["sitegen", str(tmp_path / "site")])
    assert main() == 0
    assert (tmp_path / "site/index.html").exists()
