"""The keys of a YAML file, checked one by one: a mistake is one line with the file and the key."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from skybody import InputError
from skybody.arguments import allowed_words

MOST_BYTES = 1 << 20  # of a map


class Keys:
    """A mapping of the file, and its place in it."""

    def __init__(self, file: Path, place: str, content: Any) -> None:
        self.file, self.place = file, place
        if not isinstance(content, dict):
            raise self.error(f"is `{content}`; allowed: keys with values")
        self._content: dict[str, Any] = {str(key): value for key, value in content.items()}

    def error(self, problem: str, key: str = "") -> InputError:
        """An error about this mapping, or one of its keys."""
        place = ".".join(part for part in (self.place, key) if part)
        return InputError(f"{self.file}: {place}{': ' if place else ''}{problem}")

    def allow(self, *names: str) -> None:
        """Raises InputError for other keys."""
        for key in self._content:
            if key not in names:
                raise self.error(f"unknown key{allowed_words(key, names)}", key)

    def __contains__(self, key: str) -> bool:
        return key in self._content

    def __iter__(self) -> Any:
        return iter(self._content)

    def keys(self, key: str) -> Keys:
        """The mapping of a key."""
        place = ".".join(part for part in (self.place, key) if part)
        return Keys(self.file, place, self.value(key))

    def value(self, key: str) -> Any:
        """The value of a key that must be there."""
        if key not in self._content:
            raise self.error("is missing", key)
        return self._content[key]

    def text(self, key: str, default: str | None = None) -> str:
        """A text; without a default it must be there."""
        value = self._content.get(key, default) if default is not None else self.value(key)
        if not isinstance(value, str):
            raise self.error(f"is `{value}`; allowed: a text", key)
        return value

    def word(self, key: str, words: Sequence[str], default: str | None = None) -> str:
        """One of some words."""
        value = self.text(key, default)
        if value not in words:
            raise self.error(f"is `{value}`{allowed_words(value, words)}", key)
        return value

    def flag(self, key: str) -> bool:
        """True or false; absent: false."""
        value = self._content.get(key, False)
        if not isinstance(value, bool):
            raise self.error(f"is `{value}`; allowed: true, false", key)
        return value

    def texts(self, key: str, count: int | None = None) -> tuple[str, ...]:
        """A list of texts, of a certain number."""
        value = self.value(key)
        number = f"{count} texts" if count else "texts"
        if (
            not isinstance(value, list)
            or not value
            or not all(isinstance(item, str) for item in value)
            or (count and len(value) != count)
        ):
            raise self.error(f"is `{value}`; allowed: a list of {number}", key)
        return tuple(value)

    def numbers(self, key: str, default: Sequence[float] | None = None) -> tuple[float, ...]:
        """A list of numbers; without a default it must be there."""
        value = self._content.get(key, default) if default is not None else self.value(key)
        if not isinstance(value, (list, tuple)) or not all(map(is_number, value)) or not value:
            raise self.error(f"is `{value}`; allowed: a list of numbers", key)
        return tuple(float(item) for item in value)

    def number(self, key: str, default: float, low: float, high: float) -> float:
        """A number in a range."""
        value = self._content.get(key, default)
        if not is_number(value) or not low <= value <= high:
            raise self.error(f"is `{value}`; allowed: {low:g} to {high:g}", key)
        return float(value)


def is_number(value: Any) -> bool:
    """Whether a value of YAML is a number."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def read_keys(file: Path) -> Keys:
    """The keys of a file.

    Raises:
        InputError: it cannot be read, or is no YAML with keys.
    """
    return Keys(file, "", read_yaml(file))


def read_yaml(file: Path) -> Any:
    """The content of a map.

    Raises:
        InputError: PyYAML is missing, or the file is long, cannot be read, or is no YAML.
    """
    try:
        import yaml
    except ModuleNotFoundError:
        raise InputError("a map needs the package PyYAML: `pip install PyYAML`") from None
    try:
        with file.open("rb") as opened:
            data = opened.read(MOST_BYTES + 1)
        if len(data) > MOST_BYTES:
            raise InputError(f"{file}: has more than {MOST_BYTES} bytes; a map is a short text")
        return yaml.safe_load(data)
    except OSError as error:
        raise InputError(f"{file}: cannot be read ({error.strerror})") from None
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError) as error:
        problem = " ".join(str(error).split())
        raise InputError(f"{file}: is no YAML: {problem}") from None
