"""docs/gallery has a film and a still of every shipped scenario."""

from __future__ import annotations

import pytest
from PIL import Image, ImageSequence

from research.documents import gallery
from research.documents.gallery import FOLDER, LEAST, MOST

MOST_BYTES = 1_500_000
MOST_OF_ALL = 25_000_000


@pytest.mark.parametrize("name", [*gallery.scenarios(), "overview"])
def test_a_film_is_short_and_small(name: str) -> None:
    file = FOLDER / f"{name}.webp"
    assert file.is_file(), "python -m research run gallery"
    assert file.stat().st_size < MOST_BYTES
    with Image.open(file) as film:
        seconds = 0.0
        for frame in ImageSequence.Iterator(film):
            frame.load()
            seconds += 1e-3 * film.info["duration"]
    # A frame has whole milliseconds; 96 of 83 ms are 7.97 s.
    assert LEAST <= seconds <= MOST


def test_the_page_has_every_scenario_with_its_still() -> None:
    names = gallery.scenarios()
    assert (FOLDER / "README.md").read_text(encoding="utf-8") == gallery.page(names)
    assert {file.stem for file in (FOLDER / "stills").iterdir()} == {*names}
    assert sum(file.stat().st_size for file in FOLDER.rglob("*.webp")) < MOST_OF_ALL
