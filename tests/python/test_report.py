"""`maille report` and maille.report: one self-contained page with the contents of the folder."""

import json
import os
import random
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import pytest

import maille
from conftest import STRIP

for needed in ("jinja2", "matplotlib", "scipy"):
    pytest.importorskip(needed)
from maille import _command, _plots, _report
from maille._program import UsageError

SEEDS = Path(__file__).with_name("pages")
NAMES = ("a_compare_results.json", "a.json", "b.jsonl", "b_about.json")


def command(*words, code=0):
    if "MAILLE_COMMAND" not in os.environ:
        pytest.skip("the command is not built")
    run = subprocess.run([os.environ["MAILLE_COMMAND"], *map(str, words)], capture_output=True, text=True)
    assert run.returncode == code, run.stderr + run.stdout
    return run


class Page(HTMLParser):
    """Attributes, the page's text, and rows of tables by id: (text, key) of each cell."""

    def __init__(self, html):
        super().__init__()
        self.attributes, self.tables, self.tags, self.text, self.row = [], {}, [], "", []
        self.feed(html)

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.attributes += attributes
        self.tags.append(tag)
        if tag == "table":
            self.table = self.tables.setdefault(found["id"], [])
        elif tag == "tr":
            self.row = []
            self.table.append(self.row)
        elif tag == "td":
            self.row.append(["", found.get("data-key")])

    def handle_data(self, data):
        self.text += data
        if self.tags and self.tags[-1] == "td" and self.row:
            self.row[-1][0] += data.strip("\n")

    def rows(self, name):
        return [row for row in self.tables.get(name, []) if row]

    def values(self, name):
        return [value for key, value in self.attributes if key == name]


def page_of(folder):
    file = folder / "page.html"
    command("report", folder, "--out", file)
    return Page(file.read_text())


@pytest.fixture(scope="module")
def compared(tmp_path_factory):
    """A box whose title is not to be taken for HTML, compared, and its page."""
    folder = tmp_path_factory.mktemp("compared")
    body = STRIP.replace("[8, 4, 4]", "[8, 8, 8]").replace('"0.4 mm", 0, 0', '"0.4 mm", 0, "0.2 mm"')
    (folder / "box.toml").write_text('title = "<b>pull</b> & \\"turn\\""' + body + '''[[measure]]
name = "pull"
force = "move[1]"
[[measure]]
name = "stretch"
strain = { mean = "body" }
[[measure]]
name = "line"
displacement = { along = [[0, "4 mm", "4 mm"], ["8 mm", "4 mm", "4 mm"]], points = 5 }
''')
    said = command("compare", folder / "box.toml", "--methods", "limits,coupled,fem_q1", "--estimate", "--out", folder / "out").stdout
    assert "multigrid cycles" in said and "of finite elements there is none" in said
    assert b"DisplacementErrorEstimate" in (folder / "out/box_limits.vti").read_bytes()
    command("report", folder / "out")
    html = (folder / "out/report.html").read_text()
    return folder / "out", html, Page(html), json.loads((folder / "out/box_compare_results.json").read_text())


def test_page_contract_it_loads_nothing_and_escapes_what_files_say(compared):
    folder, html, page, _ = compared
    assert page.values("src") and all(value.startswith("data:") for value in page.values("src"))
    links = [value for value in page.values("href") if not value.startswith("#") and value != "data:,"]
    assert links and all((folder / value).exists() for value in links)
    assert "@import" not in html and "url(" not in html and page.tags.count("link") == 1
    assert "<b>pull" not in html and "&lt;b&gt;pull" in html
    assert len(page.values("alt")) == len(page.values("src")) and all(page.values("alt"))


def test_page_contract_it_opens_with_the_question_and_has_every_section_in_order(compared):
    html = compared[1]
    parts = ["A box of 8 × 8 × 8 mm, held at x-, x+ moved by (0.4, 0, 0.2) mm: what force does it take, and where do strain and stress go?",
             "The body at rest", "Strain in a layer", 'id="id-box-compare-measures"', 'id="id-box-compare-parts"', 'id="id-box-compare-forces"',
             "The answers beside each other", 'id="id-box-compare-table"', "estimated L2", "What accuracy costs in time", "Method by method",
             "Where the error sits", "The scene</h3>", "youngs_modulus", "maille check --why", "The command</h3>", "--methods", "Computed by maille", " UTC.</p>",
             "Files</h2>", "box_limits.vti"]
    places = [html.find(part, html.find("<main")) for part in parts]
    assert -1 not in places and places == sorted(places), list(zip(parts, places))


def test_tables_oracle_are_those_of_the_json(compared):
    _, _, page, results = compared
    key = "{:.9g}".format
    parts, forces, measures = (page.rows("id-box-compare-" + name) for name in ("parts", "forces", "measures"))
    rows = results["results"][0]["results"]
    reference, n_forces, n_errors = rows[-1]["mechanics"]["body"], 0, 0
    assert len(parts) == 3 and len(measures) == 9
    for row in rows:
        part = next(cells for cells in parts if cells[1][0] == row["method"])
        body = row["mechanics"]["body"]
        assert part[2][1] == key(body["volume"]) and part[4][1] == key(body["largest_strain"]["mean"])
        if row["method"] == "coupled":
            assert part[-4][1] == key(body["strain_energy"])
            assert part[-1][1] == key(abs(body["strain_energy"] / reference["strain_energy"] - 1))
            assert part[-3][1] == key(abs(body["largest_strain"]["mean"] / reference["largest_strain"]["mean"] - 1))
        if row["method"] == "fem_q1":
            assert part[-1][0] == "–"
        for one in row["mechanics"]["holds"] + row["mechanics"]["moves"]:
            force = next(cells for cells in forces if (cells[0][0], cells[2][0]) == (one["name"], row["method"]))
            assert force[1][0] == one["where"] and [cell[1] for cell in force[3:]] == [key(x) for x in one["force"] + one["moment"]]
            largest = max(map(abs, one["force"]))
            assert all(cell[0] == "0" for cell, x in zip(force[3:6], one["force"]) if abs(x) < 1e-7 * largest)
            n_forces += 1
        for measure in row["measures"]:
            shown = next(cells for cells in measures if (cells[0][0], cells[1][0]) == (measure["name"], row["method"]))
            if measure.get("value") is not None:
                assert shown[2][1] == key(measure["value"])
            error = row.get("error", {}).get("measures", {}).get(measure["name"])
            n_errors += error is not None
            assert error is None or shown[3][1] == key(error)
    assert len(forces) == n_forces >= 4 and n_errors >= 4
    assert any([cell[0] for cell in cells[:3]] == ["pull", "limits", "limits knows no forces"] for cells in measures)


def test_module_contract_the_function_makes_the_page_of_the_command(compared, tmp_path, monkeypatch):
    folder, html, page, _ = compared
    assert maille.report(folder, tmp_path / "page.html") == tmp_path / "page.html"
    assert Page((tmp_path / "page.html").read_text()).tables == page.tables
    (tmp_path / "scene.html").write_text("mine")
    for found in (True, False):  # without the command the page has no bodies
        if not found:
            monkeypatch.setattr(_command, "__file__", str(tmp_path / "a/b/c/d/e.py"))
            monkeypatch.setattr(_command.shutil, "which", lambda _: None)
        for faulty, out in ((tmp_path / "none", None), (folder, tmp_path / "scene.html"), (SEEDS, tmp_path / "new.html")):
            with pytest.raises(UsageError, match="expected"):
                maille.report(faulty, out)
    assert (tmp_path / "scene.html").read_text() == "mine" and not (tmp_path / "new.html").exists()


@pytest.mark.skipif(not shutil.which("chromium"), reason="there is no chromium here (apt-get install chromium)")
@pytest.mark.parametrize("sort, direction, order", [("8", "ascending", ["coupled", "limits", "fem_q1"]),  # the reference has no error: last
                                                    ("-8", "descending", ["limits", "coupled", "fem_q1"])])
def test_page_contract_a_browser_shows_it_without_complaint_and_sorts_its_table(compared, tmp_path, sort, direction, order):
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", f"--user-data-dir={tmp_path}", "--enable-logging=stderr",
               "--host-resolver-rules=MAP * ~NOTFOUND", "--dump-dom", f"file://{compared[0]}/report.html?sort=id-box-compare-table.{sort}"]
    run = subprocess.run(["chromium", *options], capture_output=True, text=True, timeout=60)
    assert run.returncode == 0 and "CONSOLE" not in run.stderr, run.stderr  # the page's policy forbids any request
    shown = Page(run.stdout)
    assert [row[0][0] for row in shown.rows("id-box-compare-table")] == order
    assert direction in shown.values("aria-sort") and "button" in shown.tags


def test_page_contract_folders_without_mechanics_or_scene_have_one(compared, tmp_path):
    results = json.loads(json.dumps(compared[3]))
    for row in results["results"][0]["results"]:
        del row["mechanics"]
    results.update(title="</script><script>alert(1)</script>", scene_text='title = "</title><script>"')
    (tmp_path / "box_compare_results.json").write_text(json.dumps(results))
    page = page_of(tmp_path)
    assert len(page.rows("id-box-compare-table")) == 3 and not page.rows("id-box-compare-parts")
    assert page.tags.count("script") == 1 and "no pictures of box" in page.text


def test_page_contract_plays_and_probes_have_their_sections(tmp_path):
    play = {"kind": "play", "scene": "ring", "title": "a <ring>", "method": "limits", "moments": 3, "command": "maille play ring.toml pull.csv",
            "scene_file": "/a/ring.toml", "scene_text": "[[object]]"}

    def frame(number, force):
        return {"frame": number, "drives": [], "contacts": [{"object": "ring", "other": "wall", "voxels": 2, "force": force}]}

    frames = {"scene": "ring", "trajectory": "pull", "method": "limits", "frames_asked": 2, "frame_seconds": 0.5, "objects": [],
              "frames": [frame(1, [3, 4, 0]), frame(2, [0, 0, 1])]}
    probe = {"title": "a finger & a belly", "ticks": 1000, "period_s": 0.001, "in_real_time": False, "tool_voxels": 57, "deformable_bodies": 1,
             "force": {"largest_n": 2.5, "mean_touching_n": 1, "largest_torque_nm": 0.01, "touching_ticks": 400}, "bodies": {"deepest_m": 0.002},
             "passivity": {"stiffness": 300}, "penetrations": 0}
    for name, data in (("ring_play_results", play), ("frames", frames), ("finger", probe)):
        (tmp_path / f"{name}.json").write_text(json.dumps(data))
    for name in ("ring_0000.png", "ring_0001.png", "ring_0002.png", "finger.png"):
        (tmp_path / name).write_bytes(b"\x89PNG")
    page = page_of(tmp_path)
    for text in ("Play: a <ring>", "by limits, driven by pull; 2 of 2 frames", "ring_0002.png", "maille play ring.toml pull.csv",
                 "Probe: a finger & a belly", "2.5 N", "2 mm"):
        assert text in page.text
    assert "finger.json" in page.values("href") and "Other pictures" not in page.text
    assert [[cell[0] for cell in row] for row in page.rows("id-ring-play-table")] == [["ring against wall", "2", "5 N"]]


def study_row(case, modulus, l2, most, time):
    return {"study": "ratio", "case": case, "cases": 2, "scene": "bar", "parameters": {"material.E_fibre": modulus, "limits.from": "taut"},
            "method": "limits", "status": "done", "message": "", "error": {"relative_l2": l2, "relative_max": most, "rms": 1e-4},
            "seconds": {"setup": 0.001, "solve": time - 0.001, "total": time}, "bytes": 2048, "iterations": 7, "reference": "fem_q2",
            "strain_energy": 0.002 if case == 1 else 1e-17}


STUDY = "".join(json.dumps(row) + "\n" for row in (study_row(1, 1000.0, 0.25, 0.5, 0.003), study_row(2, 50000.0, 0.125, None, 1.501)))


def test_study_golden_its_table(tmp_path):
    (tmp_path / "ratio.jsonl").write_text(STUDY + '{"study":"ratio","case":2,"ca')  # as a killed study leaves it
    page = page_of(tmp_path)
    assert page.rows("id-ratio-table") == [
        [["1", "1"], ["1000", "1000"], ["taut", None], ["limits", None], ["done", None], ["25 %", "0.25"], ["50 %", "0.5"], ["3 ms", "0.003"],
         ["2 KiB", "2048"], ["7", "7"], ["0.002 J", "0.002"]],
        [["2", "2"], ["50000", "50000"], ["taut", None], ["limits", None], ["done", None], ["12.5 %", "0.125"], ["–", None], ["1.5 s", "1.501"],
         ["2 KiB", "2048"], ["7", "7"], ["0 J", "0"]]]
    assert "2 of 2 cases, 2 rows, 0 of them not settled" in page.text


def test_page_contract_files_that_are_not_what_they_seem_are_named_and_left_out(tmp_path):
    (tmp_path / "ratio.jsonl").write_text(STUDY)
    (tmp_path / "ratio_older.jsonl").write_text(STUDY)
    indices = {"parameter": "E", "first": 0.25, "first_low": 0.2, "first_high": 0.3, "total": 0.5, "total_low": 0.5, "total_high": 0.5}
    about = {"kind": "study", "study": "ratio", "title": "stiff & soft", "command": "maille study r.toml", "scene_file": "/a/r.toml",
             "scene_text": "scene = 1", "explanation": "it costs", "sensitivity": [
                 {"scene": "bar", "method": "coupled", "label": "force [N]", "undetermined": "", "parameters": [indices]},
                 {"scene": "bar", "method": "relaxed", "label": "force [N]", "undetermined": "too few", "parameters": []}]}
    (tmp_path / "ratio_about.json").write_text(json.dumps(about))
    (tmp_path / "broken.json").write_text('{"kind":')
    (tmp_path / "deep.json").write_text("[" * 100000)
    (tmp_path / "odd_results.json").write_text('{"kind":"run","results":"none","files":[1,2],"title":3}')
    (tmp_path / "secret.png").write_text("root:x:0:0")
    (tmp_path / "huge.png").write_bytes(b"\x89PNG" + bytes(17 << 20))
    said = command("report", tmp_path, "--out", tmp_path / "r.html").stderr
    assert all(name in said for name in ("broken.json", "deep.json", "secret.png", "huge.png"))
    html = (tmp_path / "r.html").read_text()
    page = Page(html)
    for text in ("Study: stiff & soft", "scene = 1", "it costs", "maille study r.toml", "ratio_older.jsonl", "0.250 (0.20 to 0.30)", "0.500",
                 "How do the answers depend on material.E_fibre?", "bar, relaxed: undetermined: too few"):
        assert text in page.text, text
    assert "cm9vdDp4OjA6MA" not in html and html.count("2 of 2 cases") == 1 and len(html) < 1 << 20


def changed(text, draw):
    """The text of a JSON file with some bytes or values of other kinds."""
    if draw.random() < 0.3:
        at = draw.randrange(len(text) + 1)
        return text[:at] + draw.choice(["", "}", "[", '"', "1e999", "\x00", "\\ud800", "<script>", "null", "-"]) + text[at + draw.randrange(4):]
    values = list(re.finditer(r'(?<=:)(?:"[^"]*"|-?[\d.e+-]+|null|true|false|\[\]|\{\})', text))
    for value in draw.sample(values, min(len(values), draw.randrange(1, 4))):
        other = draw.choice(["null", "-1", "1e308", "[]", "{}", "[1,2]", '"<script>x</script>"', '"\\u0001$\\\\frac{"', "true", "10" * 20])
        text = text[:value.start()] + other + text[value.end():] if draw.random() < 0.5 else text.replace(value[0], other)
    return text


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_page_property_no_folder_breaks_it_or_gets_through_unescaped(tmp_path):
    """Folders of seeds, with a fixed seed changed: a page, or a fault; never another error, never a tag of theirs."""
    draw, n_pages = random.Random(7), 0
    seeds = [seed.read_text().split("\x1e") for seed in sorted(SEEDS.iterdir())]
    for i in range(120):
        for name, text in zip(NAMES, seeds[i % 4] + [""] * 4):
            (tmp_path / name).write_text(changed(text, draw) if i >= 4 else text, errors="replace")
        try:
            html, notes = _report.page(tmp_path, tmp_path / "r.html", "maille report", "", {})
        except UsageError:
            continue
        n_pages += 1
        if i % 16 == 0 and "MAILLE_COMMAND" in os.environ:  # through the command, which reads the results too
            command("report", tmp_path, "--out", tmp_path / "r.html")
        assert i >= 4 or not any("another form" in note for note in notes)
        assert html.endswith("</html>\n") and html.count("<script>") == 1 and "\x01" not in html
        html.encode(errors="replace")
    assert n_pages > 60


def test_plots_contract_the_same_figure_gives_the_same_bytes_and_no_text_is_a_formula():
    def drawn(kind):
        with _plots.style():
            figure, ((axes,),) = _plots.new_figure(4, 3, title="$\\frac{ & <b>\x01")
            for i, method in enumerate([*_plots.LOOKS, "another"]):
                axes.plot([1, 2], [i, i + 1], **_plots.look(method))
            axes.set(xlabel="time [s]", ylabel="force [N]")
            _plots.log_axis(axes, "x")
            return _plots.bytes_of(figure, kind)

    assert drawn("svg") == drawn("svg") and drawn("png") == drawn("png")
    assert b"$\\frac{ &amp; &lt;b&gt;?" in drawn("svg") and drawn("png").startswith(b"\x89PNG")
    assert len({look[:2] for look in _plots.LOOKS.values()}) == len({look[0] for look in _plots.LOOKS.values()}) == len(_plots.LOOKS)
    assert _plots.unit_for(0.012, "m") == (1e-3, "mm") and _plots.data_uri("a/b", b"foob") == "data:a/b;base64,Zm9vYg=="


def test_plots_contract_other_endings_are_refused(tmp_path):
    with pytest.raises(UsageError, match="expected a file that ends in .svg or .png"):
        _plots.save(_plots.new_figure()[0], tmp_path / "a.pdf")


def test_plots_contract_forces_have_units_that_suit_them_and_lines_only_of_what_is_known():
    from maille._curves import force_figure, hand_figure

    curves = {"coupled": [(0.001, 0.02, 1e-7), (0.002, 0.04, 4e-7)], "limits": [(0.001, None, None)]}
    with _plots.style():
        force, energy = force_figure("", curves, "force on moves", "/m").axes
        forces, _ = hand_figure("", [[0.0, 0, 3, 4, 50], [0.001, 0, 0, 0, 0]]).axes
    assert (force.get_xlabel(), force.get_ylabel(), energy.get_ylabel()) == ("largest displacement [mm]", "force on moves [mN/m]", "strain energy [nJ/m]")
    assert [line.get_label() for line in force.lines] == ["coupled"]
    assert force.lines[0].get_ydata() == pytest.approx([0, 20, 40]) and forces.lines[0].get_ydata() == pytest.approx([5, 0])
