"""The examples of the gallery and the figures of pages: each runs as it stands, and makes a picture that shows something."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("matplotlib")

SOURCES = Path(__file__).resolve().parents[2]
EXAMPLES = sorted((SOURCES / "python/examples").glob("*.py"))
FIGURES = sorted(path for path in (SOURCES / "docs/figures").glob("*.py") if "import maille" in path.read_text())


@pytest.mark.parametrize("example", EXAMPLES + FIGURES, ids=lambda path: path.stem)
def test_examples_contract_make_their_pictures(example, tmp_path):
    if "MAILLE_DATA" in example.read_text() and not os.environ.get("MAILLE_DATA"):
        pytest.skip("MAILLE_DATA is not set")
    picture = tmp_path / "picture.png"
    environment = {**os.environ, "PYTHONPATH": os.environ["MAILLE_PYTHON_PATH"], "MPLCONFIGDIR": str(tmp_path)}
    run = subprocess.run([sys.executable, str(example), str(picture)], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    from matplotlib import image

    pixels = image.imread(picture)
    assert pixels.shape[0] > 300 and pixels.shape[1] > 500
    assert pixels[..., :3].std() > 0.05, "the picture is empty"


def test_examples_contract_are_all_in_the_gallery():
    page = (SOURCES / "docs/gallery.md").read_text()
    assert len(EXAMPLES) >= 5
    for example in EXAMPLES:
        assert f"../python/examples/{example.name}" in page, f"docs/gallery.md does not show {example.name}"
        assert f"gallery/{example.stem}.png" in page and (SOURCES / f"docs/gallery/{example.stem}.png").is_file()
    for picture in re.findall(r"\]\(([\w/.]+\.png)\)", page):
        assert (SOURCES / "docs" / picture).is_file(), picture


def test_figures_contract_are_on_pages():
    pages = "".join(page.read_text() for page in (SOURCES / "docs").glob("*.md"))
    assert len(FIGURES) >= 3
    for figure in FIGURES:
        assert f"]({figure.stem}.png)" in pages and f"](figures/{figure.name})" in pages, figure.name
        assert (SOURCES / f"docs/{figure.stem}.png").is_file()
