"""The pages of the site: the repository's Markdown, and a page for each source file that it links.

Folders are those of the repository, so that relative links stay as they are.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path

from markdown_text import for_python_markdown, outside_code

ROOT = Path(__file__).resolve().parents[2]
# Pages for developers of the repository alone, and parts of others.
LEFT_OUT = ("tests/", ".github/", "plugins/template/", "scripts/")
LINK = re.compile(r"(!?\[(?:[^\[\]]|\[[^\]]*\]\([^)]*\)|\[[^\]]*\])*\]\()([^)\s]+)(\))")
HTML_LINK = re.compile(r'((?:src|href)=")([^"]+)(")')
LANGUAGES = {
    ".py": "python", ".cpp": "cpp", ".h": "cpp", ".c": "c", ".yaml": "yaml", ".yml": "yaml",
    ".sh": "bash", ".cff": "yaml", ".toml": "toml", ".urdf": "xml", ".cmake": "cmake",
    ".in": "text", ".txt": "text", "": "text",
}  # fmt: skip
NO_SEARCH = "search:\n  exclude: true\n"


def tracked() -> set[str]:
    """Files of the repository that exist."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "--deduplicate"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return {name for name in listed.stdout.splitlines() if (ROOT / name).is_file()}


class Tree:
    """Writes the site's sources into a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.files = tracked()
        self.pages = {
            name for name in self.files if name.endswith(".md") and not name.startswith(LEFT_OUT)
        }
        self.wanted: set[str] = set()  # linked, not yet written

    def write(self) -> None:
        """All pages, and all files that they link."""
        if self.folder.exists():
            shutil.rmtree(self.folder)
        for name in sorted(self.pages):
            text = outside_code(
                (ROOT / name).read_text(), lambda part, n=name: self.linked(part, n)
            )
            self.put(name, for_python_markdown(text))
        for name in sorted(self.wanted - self.pages):
            self.write_linked(name)

    def put(self, name: str, text: str) -> None:
        target = self.folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text)

    def linked(self, text: str, page: str) -> str:
        """The text with the links of the site; notes the files that it links."""

        def of_markdown(found: re.Match[str]) -> str:
            head = LINK.sub(of_markdown, found[1]) if "](" in found[1][:-2] else found[1]
            head = HTML_LINK.sub(of_html, head)
            return head + self.target(found[2], page) + found[3]

        def of_html(found: re.Match[str]) -> str:
            return found[1] + self.target(found[2], page) + found[3]

        return HTML_LINK.sub(of_html, LINK.sub(of_markdown, text))

    def target(self, link: str, page: str) -> str:
        """The link as it is on the site."""
        path, mark, anchor = link.partition("#")
        if not path or re.match(r"[a-z]+:", path):
            return link
        try:
            name = (ROOT / page).parent.joinpath(path).resolve().relative_to(ROOT).as_posix()
        except ValueError:
            return link
        if (ROOT / name).is_dir():
            inner = f"{name}/README.md"
            path = f"{path.rstrip('/')}/" + ("README.md" if inner in self.pages else "index.md")
            self.wanted.add(inner if inner in self.pages else f"{name}/index.md")
        elif name in self.files and name not in self.pages:
            self.wanted.add(name)
            path += ".md" if Path(name).suffix in LANGUAGES else ""
        return path + mark + anchor

    def write_linked(self, name: str) -> None:
        """A page with the file's text or the folder's names; other files as they are."""
        if name.endswith("/index.md"):
            folder = name.removesuffix("/index.md")
            inside = sorted(n for n in self.files if n.startswith(f"{folder}/"))
            names = "\n".join(f"- `{n.removeprefix(f'{folder}/')}`" for n in inside)
            self.put(name, f"---\ntitle: {folder}\n{NO_SEARCH}---\n# {folder}\n\n{names}\n")
        elif Path(name).suffix in LANGUAGES:
            text = (ROOT / name).read_text()
            language = "cmake" if name.endswith("CMakeLists.txt") else LANGUAGES[Path(name).suffix]
            code = f"`````{language}\n{text}\n`````\n"
            self.put(f"{name}.md", f"---\ntitle: {name}\n{NO_SEARCH}---\n# {name}\n\n{code}")
        else:
            target = self.folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / name, target)


def matching(folder: Path, pattern: str) -> Iterable[str]:
    """Pages of a pattern of the navigation, by name."""
    return sorted(path.relative_to(folder).as_posix() for path in folder.glob(pattern))
