"""The documentation site: its text, its checks, and the built pages in a browser.

`./dev docs` builds it by scripts/docs_site/build.py; without it, tests of built pages are skipped.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
SITE = ROOT / "build/site"
sys.path.insert(0, str(ROOT / "scripts/docs_site"))

from check import problems  # noqa: E402
from finish import finished  # noqa: E402
from markdown_text import for_python_markdown, outside_code  # noqa: E402
from tree import Tree  # noqa: E402

WIDTHS = {"desktop": (1280, 900), "phone": (390, 844)}
PAGES = (
    "index.html",
    "docs/start/first_flight.html",
    "docs/python.html",
    "docs/gallery/index.html",
    "reference/cpp/simulation.html",
)


# --- text ---------------------------------------------------------------------------------------


def test_lists_within_lists_keep_their_levels() -> None:
    text = "Text:\n- one\n  more\n  - inner\n\n    code of inner\n- two\n\nend\n"
    expected = "Text:\n\n- one\n    more\n    - inner\n\n        code of inner\n\n- two\n\nend\n"
    assert for_python_markdown(text) == expected


def test_code_is_left_as_it_is() -> None:
    text = "```yaml\nkey:\n- a|b\n```\n\n    [x](y.md)\n"
    assert for_python_markdown(text) == text
    listing = "Text:\n\n    a:\n      - b: 1\n        c: 2\n"
    assert for_python_markdown(listing) == listing
    assert outside_code(f"[x](y.md)\n\n{text}", lambda part: part.replace("y.md", "z.md")) == (
        f"[x](z.md)\n\n{text}"
    )


def test_pipes_in_code_of_tables_have_no_backslash() -> None:
    assert for_python_markdown("| `a\\|b` | c |\n") == "| `a|b` | c |\n"
    assert for_python_markdown("in [0, pi] [rad]\n") == "in [0, pi] \\[rad]\n"


def test_a_linked_source_file_becomes_a_page(tmp_path: Path) -> None:
    tree = Tree(tmp_path / "pages")
    link = tree.linked("[hover](../scenarios/hover/hover.yaml)", "docs/cli.md")
    assert link == "[hover](../scenarios/hover/hover.yaml.md)"
    assert tree.linked("[sensors](sensors)", "README.md") == "[sensors](sensors/README.md)" or (
        tree.linked("[sensors](sensors)", "README.md") == "[sensors](sensors/index.md)"
    )
    tree.write_linked("scenarios/hover/hover.yaml")
    page = (tmp_path / "pages/scenarios/hover/hover.yaml.md").read_text()
    assert "`````yaml" in page
    assert "name: hover" in page


def test_every_page_of_the_manual_is_in_the_navigation() -> None:
    text = (ROOT / "docs/site/site.yml").read_text()
    pages = [path.relative_to(ROOT).as_posix() for path in (ROOT / "docs").glob("*.md")]
    assert [page for page in sorted(pages) if page not in text] == []


def test_pictures_get_a_name_and_are_loaded_when_seen() -> None:
    page = finished('<img src="a/first_flight.webp"><img alt="x" src="b.png">')
    assert page == (
        '<img alt="first flight" src="a/first_flight.webp"><img loading="lazy" alt="x" src="b.png">'
    )


def test_broken_links_and_other_hosts_are_found(tmp_path: Path) -> None:
    (tmp_path / "b.html").write_text('<h1 id="there">b</h1>')
    (tmp_path / "a.html").write_text(
        '<a href="b.html#there"></a><a href="b.html#gone"></a><a href="c.html"></a>'
        '<a href="https://example.com"></a><script src="https://example.com/x.js"></script>'
        '<img src="b.html">'
    )
    assert problems(tmp_path) == [
        "a.html: b.html: a picture without a text",
        "a.html: b.html#gone: no such anchor",
        "a.html: c.html: no such file",
        "a.html: https://example.com/x.js: is loaded from another host",
    ]


# --- built pages --------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    if not (SITE / "index.html").exists():
        pytest.skip("no site: ./dev docs makes it")
    api = pytest.importorskip("playwright.sync_api")
    with api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(
            executable_path="/usr/bin/chromium", args=["--no-sandbox"]
        )
        yield chromium
        chromium.close()


@pytest.mark.parametrize("width", WIDTHS)
def test_pages_fit_the_screen_and_load_nothing_from_other_hosts(browser: Any, width: str) -> None:
    columns, rows = WIDTHS[width]
    page = browser.new_context(viewport={"width": columns, "height": rows}).new_page()
    strange: list[str] = []
    page.on("request", lambda r: strange.append(r.url) if r.url.startswith("http") else None)
    page.on("pageerror", lambda error: strange.append(str(error)))
    for name in PAGES:
        page.goto((SITE / name).as_uri())
        assert page.locator("h1").first.is_visible()
        assert page.evaluate("document.documentElement.scrollWidth") <= columns, name
    assert strange == []


def test_search_works_from_files(browser: Any) -> None:
    page = browser.new_page()
    page.goto((SITE / "docs/cli.html").as_uri())
    page.keyboard.press("/")
    page.keyboard.type("determinism")
    found = page.locator(".md-search-result__item")
    found.first.wait_for(timeout=30_000)
    links = [a.get_attribute("href") for a in found.locator("a").all()]
    assert any("docs/determinism.html" in str(link) for link in links)
