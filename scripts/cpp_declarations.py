"""Reads the public declarations of a C or C++ header with their comments.

This is not a compiler. It reads headers in the project's clang-format layout and documentation
style: `///` before a declaration, `///<` behind a member, and in plain C `/* ... */` in both
places. Bodies, private parts, preprocessor lines and namespaces called `detail` or `*_detail` are
left out. Structure is read from a copy in which comments and literals are blank, so that braces in
them do not count.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

LITERAL = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.DOTALL)
PREPROCESSOR = re.compile(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", re.MULTILINE)
SCOPE = re.compile(
    r"^(?:template\s*<.*?>\s*)?(?:typedef\s+)?(class|struct|enum(?:\s+class)?|namespace|extern)\b"
    r"\s*((?:\w|::)*)"
)
ACCESS = re.compile(r"\s*(public|protected|private)\s*:(?!:)")
MARKERS = re.compile(r"\b(SKYBODY_INLINE|inline|explicit)\s+")


@dataclass
class Declaration:
    """A class, function, member, enumerator list or alias."""

    name: str
    signature: str
    doc: str
    line: int
    scope: str = ""  # class, struct, enum; otherwise empty
    is_protected: bool = False
    members: list[Declaration] = field(default_factory=list)


def blank(text: str) -> str:
    """The same text with spaces for comments, literals and preprocessor lines; newlines stay."""

    def spaces(match: re.Match[str]) -> str:
        return re.sub(r"[^\n]", " ", match.group())

    return PREPROCESSOR.sub(spaces, LITERAL.sub(spaces, text))


def file_comment(text: str) -> str:
    """The comment at the head of a file."""
    if text.startswith("/*"):
        inner = text[2 : text.index("*/")]
        return "\n".join(re.sub(r"^ \* ?", "", line) for line in inner.strip().splitlines()).strip()
    lines = []
    for line in text.splitlines():
        if not line.startswith("//"):
            break
        lines.append(line[2:].removeprefix(" "))
    return "\n".join(lines).strip()


def read(path: Path) -> list[Declaration]:
    """The declarations of a header, including those within namespaces."""
    return Reader(path.read_text()).declarations()


class Reader:
    """Reads a header once from its beginning to its end."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.code = blank(text)
        self.at = 0

    def declarations(self) -> list[Declaration]:
        return self.scope(len(self.text), "", is_class=False)

    def scope(self, end: int, owner: str, is_class: bool) -> list[Declaration]:
        """The declarations up to `end`, which is the scope's closing brace."""
        found: list[Declaration] = []
        access = "private" if is_class else "public"
        while True:
            begin = self.skip_blanks(end)
            if begin >= end:
                return found
            label = ACCESS.match(self.code, begin)
            if label:
                access, self.at = label.group(1), label.end()
                continue
            declarations = self.declaration(begin, end, owner)
            if access == "private":
                continue
            for declaration in declarations:
                declaration.is_protected = access == "protected"
            found += declarations

    def skip_blanks(self, end: int) -> int:
        """The position of the next declaration."""
        while self.at < end and (self.code[self.at].isspace() or self.code[self.at] in ";}"):
            self.at += 1
        return self.at

    def declaration(self, begin: int, end: int, owner: str) -> list[Declaration]:
        """The declaration that begins at `begin`; for a namespace, all its declarations."""
        stop = self.end_of_head(begin, end)
        head = self.tidy(self.text[begin:stop], self.code[begin:stop])
        scope = SCOPE.match(head)
        opens = stop < end and self.code[stop] == "{"
        if opens and scope and "(" not in head.split("{")[0].split("=")[0]:
            return self.nested(begin, stop, head, scope)
        self.at = self.matching(stop) + 1 if opens else stop + 1
        name = self.name_of(head)
        if not name or head.startswith(("friend class", "friend struct", "static_assert")):
            return []
        return [Declaration(name, head, self.doc(begin), self.line(begin))]

    def nested(self, begin: int, brace: int, head: str, scope: re.Match[str]) -> list[Declaration]:
        kind, name = scope.group(1).split()[0], scope.group(2)
        close = self.matching(brace)
        self.at = brace + 1
        if kind in ("namespace", "extern"):
            inner = self.scope(close, "", is_class=False)
            self.at = close + 1
            return [] if name.endswith(("detail", "plugin_export")) else inner
        doc = self.comment_above(begin)
        if kind == "enum":
            members = self.enumerators(brace + 1, close)
        else:
            members = self.scope(close, name, is_class=kind == "class")
        rest = self.code.find(";", close)
        self.at = rest + 1
        signature = re.sub(r"^typedef\s+", "", head)
        if re.search(r"\b(?:class|struct)\s+\w+\s*<", signature):
            return []  # a specialisation: documented by the general template
        return [Declaration(name, signature, doc, self.line(begin), kind, False, members)]

    def enumerators(self, begin: int, end: int) -> list[Declaration]:
        found = []
        for match in re.finditer(r"(\w+)\s*(?:=\s*[^,]+)?(?:,|$)", self.code[begin:end].rstrip()):
            at = begin + match.start()
            doc = self.comment_behind(begin + match.end())
            found.append(Declaration(match.group(1), match.group(1), doc, self.line(at)))
        return found

    def end_of_head(self, begin: int, end: int) -> int:
        """The end of the declaration: its `;`, or the brace that opens its body."""
        depth = 0
        at = self.behind_template(begin)
        has_value = False
        while at < end:
            c = self.code[at]
            depth += (c in "([") - (c in ")]")
            if depth == 0 and c == ";":
                return at
            if depth == 0 and c == "=" and not re.search(r"operator\W*$", self.code[begin:at]):
                has_value = True
            if depth == 0 and c == "{":
                if not has_value:
                    return at
                at = self.matching(at)
            at += 1
        return end

    def behind_template(self, begin: int) -> int:
        """The position after `template <...>`, or `begin` if there is none."""
        found = re.compile(r"template\s*<").match(self.code, begin)
        if not found:
            return begin
        depth, at = 1, found.end()
        while depth > 0:
            depth += (self.code[at] == "<") - (self.code[at] == ">")
            at += 1
        return at

    def matching(self, brace: int) -> int:
        depth = 0
        for at in range(brace, len(self.code)):
            depth += (self.code[at] == "{") - (self.code[at] == "}")
            if depth == 0:
                return at
        return len(self.code)

    @staticmethod
    def tidy(text: str, code: str) -> str:
        """One line without comments, markers and a constructor's member initializers."""
        kept = "".join(
            t if c != " " or t in " \n\"'" or '"' in text else " "
            for t, c in zip(text, code, strict=True)
        )
        kept = re.sub(r"/\*.*?\*/|//[^\n]*", " ", kept, flags=re.DOTALL)
        kept = MARKERS.sub("", " ".join(kept.split()))
        kept = re.sub(r"__attribute__\(\(.*?\)\) ?", "", kept)
        return kept if "?" in kept else re.sub(r"(\)(?: const)?) : .*$", r"\1", kept)

    @staticmethod
    def name_of(head: str) -> str:
        plain = re.sub(r"^template\s*<.*?>\s", "", head)
        if plain.startswith("using "):
            return plain.split()[1]
        operator = re.search(r"operator\s*([^\s(]+|\(\))\s*\(", plain)
        if operator:
            return f"operator{operator.group(1)}"
        function = re.search(r"([~\w]+)\s*\(", plain)
        if function and "=" not in plain[: function.start()]:
            return function.group(1)
        variable = re.search(r"(\w+)\s*(?:\[[^]]*\])?\s*(?:=.*)?$", plain)
        return variable.group(1) if variable else ""

    def line(self, at: int) -> int:
        return self.text.count("\n", 0, at) + 1

    def doc(self, begin: int) -> str:
        """The comment before a declaration and the one behind it."""
        parts = [self.comment_above(begin), self.trailing(begin)]
        return "\n".join(part for part in parts if part)

    def comment_above(self, begin: int) -> str:
        lines = self.text[:begin].splitlines()
        if lines and not lines[-1].strip():
            lines.pop()
        above: list[str] = []
        while lines and lines[-1].strip().startswith("///") and "///<" not in lines[-1]:
            above.insert(0, lines.pop().strip()[3:].removeprefix(" "))
        if not above:
            above = self.block_comment(lines)
        return "\n".join(above)

    @staticmethod
    def block_comment(lines: list[str]) -> list[str]:
        """A C comment that ends in the last of these lines and fills them."""
        if not lines or not lines[-1].strip().endswith("*/"):
            return []
        begin = len(lines) - 1
        while begin >= 0 and "/*" not in lines[begin]:
            begin -= 1
        if begin < 0 or not lines[begin].strip().startswith("/*"):
            return []
        text = "\n".join(line.strip() for line in lines[begin:])
        text = re.sub(r"^/\*\s?|\s?\*/$", "", text)
        return [re.sub(r"^\* ?", "", line) for line in text.splitlines()]

    def trailing(self, begin: int) -> str:
        """The comment behind the declaration at `begin`."""
        return self.comment_behind(self.end_of_head(begin, len(self.text)))

    def comment_behind(self, end: int) -> str:
        """The comment in the rest of a line, with its continuation lines."""
        tail = self.text[end:]
        found = re.match(r"[^\n/]*///<([^\n]*(?:\n\s*///<[^\n]*)*)", tail)
        if found:
            return " ".join(re.sub(r"///<", "", found.group(1)).split())
        found = re.match(r"[^\n/]*/\*(.*?)\*/", tail, re.DOTALL)
        return " ".join(found.group(1).split()) if found else ""
