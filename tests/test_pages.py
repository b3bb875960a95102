"""Every page: its links lead somewhere, the commands and files that it names exist."""

from __future__ import annotations

import os
import re
import runpy
import shlex
import subprocess
import sys
from contextlib import suppress
from importlib import import_module
from pathlib import Path

import click
import pytest

import cornerstream
from cornerstream import Build, package_files
from cornerstream.cli import main

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
NAMES = sorted(str(page.relative_to(ROOT)) for page in [*ROOT.glob("*.md"), *DOCS.rglob("*.md")])
# the changelog names what there is no more
PAGES_OF_TODAY = pytest.mark.parametrize("page", [name for name in NAMES if name != "CHANGELOG.md"])
PAGES_TO_READ = pytest.mark.parametrize("page", NAMES)
GOALS = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
GENERATED = {"docs/reference/registers.md", "docs/results/comparison.md", "docs/results/evaluation.md"}
"""Pages whose templates decide where lines end."""


def options(command: click.Command) -> set[str]:
    """Options of a command and of all below it."""
    own = {option for each in command.params for option in (*each.opts, *each.secondary_opts)}
    below = command.commands.values() if isinstance(command, click.Group) else ()
    return own.union({"--help"}, *map(options, below))


OPTIONS = options(main)


def text_of(page: str) -> str:
    return (ROOT / page).read_text(encoding="utf-8")


def anchors(page: str) -> set[str]:
    """Anchors of the headings, as GitHub and MkDocs make them."""
    titles = re.findall(r"^#+ (.*)$", text_of(page), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).strip().replace(" ", "-") for title in titles}


def without_blocks(text: str) -> str:
    return re.sub(r"^ *```.*?^ *```$", "", text, flags=re.MULTILINE | re.DOTALL)


def commands(text: str, program: str) -> list[list[str]]:
    """Words of each call of the program: in code that is marked as such, and in blocks."""
    joined = re.sub(r"\\\n\s*", "", text)
    blocks = re.findall(r"^ *```sh\n(.*?)^ *```$", joined, re.MULTILINE | re.DOTALL)
    inline = [" ".join(code.split()) for code in re.findall(r"`([^`]+)`", without_blocks(joined))]
    lines = [*(line for block in blocks for line in block.splitlines()), *inline]
    parts = (part.strip() for line in lines for part in re.split(r"&&|\||;", line.split(" #")[0]))
    calls = (part for part in parts if re.match(rf"{program}(?: |$)", part))
    return [shlex.split(call) for call in calls if not re.search(r" (?:\.\.\.|COMMAND)", call)]


def parse(words: list[str]) -> None:
    """Hand the words to the real options; nothing runs.

    An argument may be missing, where the page speaks of the command.
    """
    command: click.Command = main
    context = main.make_context("cornerstream", [], resilient_parsing=True)
    while isinstance(command, click.Group) and words and not words[0].startswith("-"):
        name, *words = words
        found = command.get_command(context, name)
        assert found is not None, f"there is no command {name!r}"
        command = found
    if isinstance(command, click.Group) or set(words) & set(command.get_help_option_names(context)):
        return
    with suppress(click.MissingParameter):
        command.make_context(command.name, words, parent=context)


def test_there_are_pages() -> None:
    assert {"README.md", "CHANGELOG.md", "CONTRIBUTING.md", "docs/index.md", "docs/tutorial.md"} <= set(NAMES)
    rooms = {page.parent.name for page in DOCS.rglob("*.md")}
    assert rooms >= {"howto", "reference", "explanation", "results"}


@PAGES_TO_READ
def test_links_lead_somewhere(page: str) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)", without_blocks(text_of(page))):
        if re.match(r"https?://", target):
            continue
        path, _, anchor = target.partition("#")
        there = ((ROOT / page).parent / path).resolve() if path else ROOT / page
        assert there.exists(), f"there is no {target}"
        assert not page.startswith("docs/") or there.is_relative_to(DOCS), f"{target} is not on the site"
        if anchor and there.suffix == ".md":
            assert anchor in anchors(str(there.relative_to(ROOT))), f"{path or page} has no heading {anchor}"


@PAGES_OF_TODAY
def test_commands_can_be_given(page: str) -> None:
    """Each ``cornerstream ...`` names a command and options that exist, with values they take."""
    for words in commands(text_of(page), "cornerstream"):
        try:
            parse(words[1:])
        except click.ClickException as error:
            pytest.fail(f"{shlex.join(words)}: {error.format_message()}")


@PAGES_OF_TODAY
def test_options_exist(page: str) -> None:
    """Options that are named by themselves are those of some command of ours."""
    named = re.findall(r"`(--[a-z][a-z\d-]*)[ `=]", without_blocks(text_of(page)))
    assert set(named) <= OPTIONS | {"--tool"}, f"no command has {set(named) - OPTIONS}"


@PAGES_OF_TODAY
def test_goals_of_make_exist(page: str) -> None:
    for words in commands(text_of(page), "make"):
        goals = {word for word in words[1:] if "=" not in word}
        assert goals <= GOALS, f"make has no goal {goals - GOALS}"


@PAGES_TO_READ
def test_files_that_are_named_exist(page: str) -> None:
    """Paths in the project's own folders, written as code."""
    rooms = "golden|hdl|sim|flow|evaluation|cornerstream|tests|docs"
    for path in re.findall(rf"`((?:{rooms})/[\w./]*)`", without_blocks(text_of(page))):
        stands_for_a_name = re.search(r"\b[A-Z]+\b", path)
        assert stands_for_a_name or (ROOT / path).exists(), f"there is no {path}"


@pytest.mark.parametrize("page", [name for name in NAMES if name not in GENERATED])
def test_prose_has_100_columns(page: str) -> None:
    """Tables and blocks of code are as wide as they must be; so are single words and headings."""
    for line in without_blocks(text_of(page)).splitlines():
        if len(line) > 100 and not line.startswith(("|", "#", "    ", "![")):
            first = line.strip().removeprefix("- ")
            assert " " not in first, f"{len(line)} columns: {line}"


def test_every_page_is_in_the_navigation() -> None:
    told = re.findall(r"([\w/-]+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(told) == sorted(str(page.relative_to(DOCS)) for page in DOCS.rglob("*.md"))


def test_every_public_name_is_described() -> None:
    told = re.findall(r"^::: ([\w.]+)\.(\w+)$", text_of("docs/reference/python.md"), re.MULTILINE)
    assert sorted(name for _, name in told) == sorted(set(cornerstream.__all__) - {"__version__"})
    for home, name in told:
        assert getattr(import_module(home), name) is getattr(cornerstream, name)


def test_timing_diagrams_are_those_of_the_simulation() -> None:
    tools = runpy.run_path(str(DOCS / "tools" / "timing.py"))
    page = text_of("docs/reference/timing.md")
    assert re.findall(r"^```\n(.*?)\n```$", page, re.MULTILINE | re.DOTALL) == tools["diagrams"]()


def test_the_site_is_built_without_a_warning(tmp_path: Path) -> None:
    """``make docs``; `strict` in mkdocs.yml makes warnings errors."""
    pytest.importorskip("mkdocs", reason="the site needs cornerstream[docs], which `make test` installs")
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--site-dir", str(tmp_path / "site")]
    environment = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    for page in (tmp_path / "site").rglob("*.html"):
        fetched = r"<(?:script|img|iframe)[^>]*\ssrc=\"?(?:https?:)?//|<link[^>]*rel=\"?stylesheet[^>]*//"
        assert not re.search(fetched, page.read_text(encoding="utf-8")), f"{page.name} fetches something"
    reference = tmp_path / "site" / "reference"
    helps = (reference / "commands.html").read_text(encoding="utf-8")
    assert all(f"Usage: cornerstream {name} " in helps for name in main.commands)
    python = (reference / "python.html").read_text(encoding="utf-8")
    assert "Members:" in python and ":class:" not in python and "option(" not in python


def test_what_is_found_on_a_page() -> None:
    prose = "See `cornerstream synth\n--no-timing`."
    page = f"{prose}\n\n```sh\ncd x && cornerstream detect a.png \\\n  -o b  # why\n```\n"
    assert commands(page, "cornerstream") == [
        ["cornerstream", "detect", "a.png", "-o", "b"],
        ["cornerstream", "synth", "--no-timing"],
    ]
    for wrong in (
        ["detekt"],
        ["detect", "--profil", "x"],
        ["detect", "a", "b"],
        ["detect", "--profile", "x"],
    ):
        with pytest.raises((AssertionError, click.ClickException)):
            parse(wrong)


def test_interfaces_of_platform_designer() -> None:
    script = package_files(Build(), "avalon")["cornerstream_hw.tcl"]
    interfaces = set(re.findall(r"^add_interface (\w+) ", script, re.MULTILINE))
    rows = re.findall(r"^ *\| (`.*`) \|", text_of("docs/howto/platform-designer.md"), re.MULTILINE)
    assert set(re.findall(r"`(\w+)`", " ".join(rows))) == interfaces
