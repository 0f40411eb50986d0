"""Subjects whose cases are scenes: scenes/NAME.toml is a table of scenes, of what `maille` is asked about them, and of checks.

  [texts]                parts of scenes by name
  [[case]]               part, name, scene (text) or file, ask (a command of maille with its options, or a word of ASKS below)
    with, each, quick    values by name; `each` has lists, and the case is asked for every combination; `quick` replaces values, and takes `take`
                         cases, evenly spread, of a quick run; needs: a file of MAILLE_DATA; image: labels by an expression in x, y, z [mm]
  [checks]               name = "expression" in of(), rows() and share() of the answers' rows; without its rows a check is left out, with a note

<expression> in a text stands for its value. An answer is a row: case, method, setup_s, solve_s, total_s, iterations, bytes, error (relative L2
displacement against the reference), errors and estimates of force, energy and stress; peak_mib of the whole process.
"""
import contextlib
import fnmatch
import itertools
import json
import math
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time
import tomllib

import bodies
import laws

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
SCENES = ROOT / "scene" / "scenes"


class Stopped(Exception):
    pass


def filled(text, values):
    """A text whose <expressions> are replaced by their values, which may have some themselves."""
    if not isinstance(text, str):
        return text
    while (new := re.sub(r"<([^<>]+)>", lambda found: str(eval(found[1], {"math": math, "Lot": bodies.Lot, **values})), text)) != text:
        text = new
    return text


def spread(items, wanted):
    return [items[i * len(items) // wanted] for i in range(wanted)] if wanted < len(items) else items


def without_limits(text):
    return re.sub(r"(?m)^\[limits\]\n(?:(?!\[).*\n?)*", "", text)


def parts_of(subject):
    """What --only takes."""
    with open(HERE / "scenes" / f"{subject}.toml", "rb") as file:
        return list(dict.fromkeys(case.get("part", case["name"]) for case in tomllib.load(file)["case"]))


class Table:
    def __init__(self, subject, maille, lab, quick, only=(), threads=None):
        with open(HERE / "scenes" / f"{subject}.toml", "rb") as file:
            self.table = tomllib.load(file)
        if isinstance(parts := self.table.get("texts"), str):
            self.table["texts"] = tomllib.loads((HERE / "scenes" / f"{parts}.toml").read_text())["texts"]
        self.maille, self.lab, self.quick, self.only, self.threads = maille, lab, quick, only, threads
        self.rows, self.notes = [], []
        self.data = pathlib.Path(os.environ.get("MAILLE_DATA", "/nowhere"))

    def cases(self, folder):
        """Yields name, text of the scene, values, and what the table says."""
        for case in self.table["case"]:
            if self.only and case.get("part", case["name"]) not in self.only:
                continue
            quick = case.get("quick", {}) if self.quick else {}
            if quick is False:
                continue
            if "needs" in case and not (self.data / case["needs"]).exists():
                self.notes.append(f"{case['name']} left out: MAILLE_DATA has no {case['needs']}")
                continue
            each = {**case.get("each", {}), **{k: quick[k] for k in quick if k in case.get("each", {})}}
            made = [dict(zip(each, values)) for values in itertools.product(*each.values())]
            if "drawn" in case:
                count = quick.get("n", case["n"])
                made = [{"drawn": one} for one in bodies.DRAWN[case["drawn"]](count, case["seed"])]
            for one in spread(made, quick.get("take", len(made))):
                values = {**self.table.get("texts", {}), **case.get("with", {}), **{k: v for k, v in quick.items() if k not in each}, **one}
                for key, value in values.items():
                    if isinstance(value, str) and (whole := re.fullmatch(r"<([^<>]+)>", value)):
                        with contextlib.suppress(NameError):  # a text of other cases
                            values[key] = eval(whole[1], {"math": math, **values})
                if "image" in case:
                    values["image"] = bodies.write_image(folder, filled(case["image"]["label"], values), *(
                        eval(filled(str(case["image"][key]), values), {"math": math, **values}) for key in ("cells", "scale")))
                if "drawn" in one:
                    name, text, wish = one["drawn"]
                    values.update(wish)
                else:
                    name = filled(case["name"], values)
                    text = (SCENES / case["file"]).read_text() if "file" in case else 'units = "m, rad"\n' + filled(case["scene"], values)
                if "file" in case:
                    text = without_limits(text) + filled(case.get("more", ""), values)
                yield name, text.replace("\\n", "\n"), values, case

    def run(self, words, seconds=3600):
        """A process: its JSON or None, exit code (negative: a signal; 124: it took too long), errors and peak of memory [MiB]."""
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            child = subprocess.Popen(list(map(str, words)), stdout=out, stderr=err)
            end = time.monotonic() + seconds
            try:
                while not (found := os.wait4(child.pid, os.WNOHANG))[0]:
                    time.sleep(0.002)
                    if time.monotonic() > end:
                        child.kill()
            except (KeyboardInterrupt, SystemExit):
                child.kill()
                os.wait4(child.pid, 0)
                raise Stopped from None
            child.returncode = os.waitstatus_to_exitcode(found[1])
            out.seek(0), err.seek(0)
            text, errors = out.read().decode(errors="replace"), err.read().decode(errors="replace").strip()
        code = 124 if child.returncode == -9 and time.monotonic() > end else child.returncode
        try:
            return json.loads(text), code, errors, found[2].ru_maxrss / 1024
        except ValueError:
            return None, code, errors, found[2].ru_maxrss / 1024

    def ask(self, name, scene, values, case):
        """The rows of one case."""
        words = filled(case["ask"], values).split()
        if words[0] in ASKS:
            return ASKS[words[0]](self, name, scene, words[1:], case | {"values": values})
        threads = [] if "--threads" in words else ["--threads", str(self.threads or 1)]
        answer, code, errors, peak = self.run([self.maille, words[0], scene, *words[1:], *threads, "--json"])
        if answer is None:
            self.notes.append(f"{name}: {words[0]} ended with {code}: {(errors.splitlines() or [''])[-1][:300]}")
            return []
        reference = (answer.get("reference_error") or {}).get("relative_l2")
        rows = [row_of(name, answer, result, reference, peak) for result in answer.get("results") or answer.get("rows")]
        if "truth" in case:
            truth, of = float(eval(case["truth"], {"math": math, "laws": laws, **values})), case.get("of", "force")
            rows = [row | {"truth": truth, "truth_error": abs(row[of] / truth - 1)} for row in rows if row.get(of) is not None]
        return rows

    def report(self):
        checks = []
        try:
            with tempfile.TemporaryDirectory(prefix="maille_lab") as folder:
                for name, text, values, case in self.cases(pathlib.Path(folder)):
                    if sys.stderr.isatty():
                        print(f"\r\033[K{len(self.rows)} rows  {name[:100]}", end="", file=sys.stderr)
                    scene = pathlib.Path(folder) / "scene.toml"
                    scene.write_text(text)
                    for row in self.ask(name, scene, values, case):
                        self.rows.append({"case": name, **({"part": case["part"]} if "part" in case else {}), **row})
            for name, expression in self.table.get("checks", {}).items():
                try:
                    checks.append({"name": name, "value": float(eval(expression, self.words()))})
                except LookupError as missing:
                    self.notes.append(f"{name} omitted: no {missing.args[0]}")
        except (Stopped, KeyboardInterrupt, SystemExit):
            self.notes.append("interrupted: the rows so far, no checks")
            checks = None
        return {"machine": machine(self.maille), "rows": self.rows, "notes": self.table.get("notes", []) + self.notes, "checks": checks or []}, checks is not None

    def words(self):
        """What expressions of checks may use."""
        def rows(case="*", method="*", **same):
            found = [r for r in self.rows if fnmatch.fnmatchcase(r["case"], case) and fnmatch.fnmatchcase(str(r.get("method")), method)
                     and all(r.get(key) == value for key, value in same.items())]
            if not found:
                raise LookupError(f"row of {case}, {method}")
            return found

        def all_of(column, *where, **same):
            return [r[column] for r in rows(*where, **same) if r.get(column) is not None]

        def of(column, *where, **same):
            """The least: of finite elements to several tolerances the quickest."""
            if not (values := all_of(column, *where, **same)):
                raise LookupError(f"{column} of {where}")
            return min(values)

        def share(test, *where, **same):
            """The part of the rows for which a test of the row is true, among those that have the true errors it is about."""
            found = [r for r in rows(*where, **same) if all(name in r for name in re.findall(r"\b\w*error\b", test))]
            if not found:
                raise LookupError(f"row of {where} {same} with an error")
            return sum(bool(is_true(test, row)) for row in found) / len(found)

        def is_true(test, row):
            try:
                return eval(test, dict(row))
            except (TypeError, NameError):
                return False

        return {"rows": rows, "all_of": all_of, "of": of, "share": share, "median": statistics.median, "hypot": math.hypot,
                "ratios": lambda top, bottom, *where, **same: [r[top] / r[bottom] for r in rows(*where, **same) if r.get(top) and r.get(bottom)]}


def row_of(name, answer, result, reference, peak):
    seconds, error, estimate = result["seconds"], result.get("error") or {}, result.get("estimated_error") or {}
    row = {"method": result["method"], "status": result["status"], "tolerance": result.get("tolerance"), "step": result.get("step"),
           "setup_s": seconds["setup"], "solve_s": seconds["solve"], "total_s": seconds["total"], "iterations": result["iterations"],
           "bytes": result["bytes"], "nodes": result.get("nodes", answer.get("nodes")), "cells": answer.get("cells"), "peak_mib": peak,
           "error": error.get("relative_l2"), "reference_error": reference, "energy": result.get("strain_energy"),
           "violation": result.get("limit_violation")}
    for key in ("force", "strain_energy", "stress", "recovered_stress"):
        row[f"{key}_error"] = error.get(key)
    for key in ("relative_l2", "force", "stress"):
        row[f"estimated_{key}"] = estimate.get(key)
    moved = (result.get("reaction") or {}).get("moved")
    row["force"] = math.hypot(*moved) if moved else None
    row |= {measure["name"]: measure["value"] for measure in result.get("measures") or [] if measure.get("value") is not None}
    row["algorithm"] = result.get("algorithm")
    return {key: value for key, value in row.items() if value is not None}


def machine(maille):
    def first(file, key):
        found = [line.split(":", 1)[1].strip() for line in open(file) if line.startswith(key)]
        return found[0] if found else "unknown"
    version = subprocess.run([maille, "--version"], capture_output=True, text=True).stdout.split()
    return {"maille": version[-1] if version else "unknown", "processor": first("/proc/cpuinfo", "model name"), "cores": os.cpu_count(),
            "memory": first("/proc/meminfo", "MemTotal"), "load_average": os.getloadavg()[0]}


def choose(table, name, scene, words, case):
    """choose WISH SECONDS [force]: a promise, and what came of it: by trade against the best reference, of force against fem_q2."""
    wish, limit, of_force = float(words[0]), words[1], words[2:] == ["force"]
    chosen_scene = scene.with_name("chosen.toml")
    answer, code, errors, _ = table.run([table.maille, "choose", scene, "--error", wish, "--time", f"{limit}s", "--of",
                                         "force" if of_force else "displacement", "--json"])
    if answer is None or not answer.get("chosen"):
        return [{"method": "choose", "wish": wish, "status": "refused"}]
    way = answer["chosen"]
    row = {"method": way["method"], "wish": wish, "status": "promised", "spacing_factor": way["spacing_factor"], "promised": way["error"]["high"],
           "wish_s": float(limit)}
    if of_force:
        table.run([table.maille, "choose", scene, "--error", wish, "--time", f"{limit}s", "--of", "force", "--write", chosen_scene])
        found = [table.run([table.maille, "run", file, "--method", method, "--json"])[0] for file, method in ((chosen_scene, way["method"]), (scene, "fem_q2"))]
        if None in found or not all(one["results"] and "reaction" in one["results"][0] for one in found):
            return [row | {"status": "not judged"}]
        ours, truth = (one["results"][0]["reaction"]["moved" if any(one["results"][0]["reaction"]["moved"]) else "held"] for one in found)
        return [row | {"error": math.dist(ours, truth) / math.hypot(*truth)}]
    tolerance = ["--tolerances", way["tolerance"]] if way.get("tolerance") and not way["method"].startswith("fem") else []
    trade, *_ = table.run([table.maille, "trade", scene, "--methods", way["method"], "--spacings", way["spacing_factor"], *tolerance, "--reference",
                           "best", "--reference-seconds", 2 if table.quick else case.get("reference_seconds", 10), "--json"])
    known = trade and (trade.get("reference_error") or {}).get("relative_l2")
    if known is None or known > wish or not trade["rows"] or "error" not in trade["rows"][0]:
        return [row | {"status": "not judged"}]
    return [row | {"error": trade["rows"][0]["error"]["relative_l2"], "reference_error": known, "total_s": trade["rows"][0]["seconds"]["total"]}]


def start(table, name, scene, words, case):
    """start COUNT WORDS: milliseconds of the command, the middle of COUNT runs, and its peak of memory."""
    times = []
    for _ in range(2 if table.quick else int(words[0])):
        begin = time.perf_counter()
        *_, peak = table.run([table.maille, *(scene if word == "SCENE" else word for word in words[1:])])
        times.append(1e3 * (time.perf_counter() - begin))
    return [{"method": words[1], "milliseconds": statistics.median(times), "peak_mib": peak}]


def study(table, name, scene, words, case):
    """study FILE: seconds of a whole study, two cases at a time; quick: one value of every parameter."""
    file = ROOT / words[0]
    if table.quick:
        scene.write_text(re.sub(r"count( *)= \d+", r"count\1= 1", file.read_text()).replace('"scenes/', f'"{file.parent}/scenes/'))
        file = scene
    begin = time.monotonic()
    _, code, errors, _ = table.run([table.maille, "study", file, "--out", scene.with_name("study"), "--jobs", 2])
    if code != 0:
        table.notes.append(f"{name}: study ended with {code}: {(errors.splitlines() or [''])[-1][:300]}")
        return []
    return [{"method": "study", "total_s": time.monotonic() - begin}]


def fit(table, name, scene, words, case):
    """fit SCENES -- SCENES: limits fitted to the first, measured on the others, beside taut ones."""
    at = words.index("--")
    files = [[ROOT / word for word in part] for part in (words[:at], words[at + 1 :])]
    answer, code, errors, _ = table.run([table.maille, "fit", *files[0], *(w for file in files[1] for w in ("--test", file)), "--trials", 200 if table.quick else 20000, "--json"])
    held_out = (answer or {}).get("held_out") or {}
    return [{"method": "limits", "fitted": held_out.get("relative_l2"), "taut": held_out.get("taut"), "at_least": held_out.get("at_least")}]


ALL_METHODS = "limits,literal,dijkstra,sweep,relaxed,coupled,fem_q1,fem_q2"


def refused(table, name, scene, words, case):
    """refused VALUES: the scene with each value in place of `@`, of which the reader is to have a fault."""
    text, accepted = scene.read_text(), []
    for value in case["values_of_field"]:
        scene.write_text(text.replace("@", value))
        if (found := table.run([table.maille, "check", scene])[1]) != 2:
            accepted.append(f"{value}: {found}")
    return [{"method": "(reader)", "outcome": "refused", "broken": ", ".join(accepted) and f"check ended with {accepted}"}]


def promises(table, name, scene, words, case):
    """promises METHODS: every promise of each method's answer, by maille-lab, each in a process of its own that may take 300 s."""
    rows = []
    drives = []
    if "drives" in case:
        drives = [scene.with_name("drives.toml")]
        drives[0].write_text(filled(case["drives"], case["values"]).replace("\\n", "\n"))
    for method in (ALL_METHODS if words[0] == "all" else words[0]).split(","):
        if table.quick and method == "fem_q2":
            continue
        answer, code, errors, _ = table.run([table.lab, "--promises", scene, method, *drives], 300)
        died = "" if code == 0 else "took more than 300 s" if code == 124 else f"ended with {code}: {(errors.splitlines() or [''])[-1][:200]}"
        row = answer or {"method": method, "outcome": "died", "broken": died}
        if died and not row["broken"]:
            row["broken"] = died
        if row.get("note", "").startswith("by the reader") and not (case.get("must_be_refused") or case.get("may_be_refused")):
            row["broken"] = row["note"]
        if case.get("must_be_refused") and row["outcome"] != "refused":
            row["broken"] = row["broken"] or "is answered and has no answer"
        if "energy" in case and row["outcome"] == "settled" and (method == "coupled" or method.startswith("fem")):
            truth = float(eval(filled(case["energy"], case["values"]), {"math": math}))
            row["error"] = abs(row["energy"] / truth - 1)
            if not row["error"] <= 0.01:
                row["broken"] = row["broken"] or f"settled, and its energy is {row['error']:.2g} off"
        rows.append(row)
    return rows


def strains(table, name, scene, words, case):
    """strains: every method against fem_q2 at finite strain, and coupled at small strain by the force on moves; of
    each also line_error, of the measure `line`."""
    answer, code, errors, peak = table.run([table.maille, "compare", scene, "--methods", "limits,sweep,relaxed,coupled,fem_q1", "--reference", "fem_q2", "--threads", 1, "--json"])
    scene.write_text(scene.read_text().replace('strain = "finite"', ""))
    linear, *_ = table.run([table.maille, "run", scene, "--method", "coupled", "--threads", 1, "--json"])
    if answer is None or linear is None:
        table.notes.append(f"{name}: compare ended with {code}: {(errors.splitlines() or [''])[-1][:300]}")
        return []
    results = answer["results"] + linear["results"]
    rows = [row_of(name, answer, result, None, peak) for result in results]
    rows[-1]["method"] = "coupled, small"
    truth = next(result for result in results if result["method"] == "fem_q2")
    lines = [[point["vector"] for point in result["measures"][0].get("line", [])] for result in [truth, *results]]
    for row, result, line in zip(rows, results, lines[1:]):
        if line and lines[0] and row["method"] != "fem_q2":
            row["line_error"] = math.hypot(*(math.dist(a, b) for a, b in zip(line, lines[0]))) / math.hypot(*(math.hypot(*a) for a in lines[0]))
    if lines[0]:
        pull = truth["reaction"]["moved"]
        rows[-1]["force_error"] = math.dist(results[-1]["reaction"]["moved"], pull) / math.hypot(*pull)
    return rows


def dolfinx(table, name, scene, words, case):
    """dolfinx: fem_q2 against studies/lab/rivals/finite_strain_witness.py on the same cells, at the nodes of a few lines."""
    values = case["values"]
    mu, lam = values["E"] / (2 * (1 + values["nu"])), values["E"] * values["nu"] / ((1 + values["nu"]) * (1 - 2 * values["nu"]))
    by = {"stretch": 1.8e-3, "shear": 1.8e-3, "twist": math.radians(40)}[values["kind"]]
    witness = HERE / "rivals/finite_strain_witness.py"
    told = subprocess.run(["/usr/bin/python3", witness, values["kind"], *map(str, (values["nx"], values["ny"], values["nz"], values["h"], mu, lam, by))], capture_output=True, text=True)
    if told.returncode:
        table.notes.append(f"{name} left out: dolfinx ended with {told.returncode}")
        return []
    theirs = {tuple(round(x / values["h"]) for x in row[:3]): row[3:] for row in (list(map(float, text.split())) for text in told.stdout.splitlines())}
    nodes = [node for node in theirs if node[0] % 2 == 0 and 0 < node[0] < values["nx"]]
    scene.write_text(scene.read_text() + "".join(f'[[measure]]\nname = "n{i}"\ndisplacement = {{ at = {[x * values["h"] for x in node]} }}\n' for i, node in enumerate(nodes)))
    answer, *_ = table.run([table.maille, "run", scene, "--method", "fem_q2", "--json"])
    ours = {measure["name"]: measure["vector"] for measure in answer["results"][0]["measures"] if measure.get("vector")}
    row = row_of(name, answer, answer["results"][0], None, 0)
    return [row | {"error": math.hypot(*(math.dist(ours[f"n{i}"], theirs[node]) for i, node in enumerate(nodes))) / math.hypot(*(math.hypot(*theirs[node]) for node in nodes))}]


def steps(table, name, scene, words, case):
    """steps N: seconds of each of N equal steps that end at `by`."""
    answer, *_ = table.run([table.maille, "run", scene, "--method", "coupled", "--steps", words[0], "--json"])
    return [{"method": "coupled", "step": one["step"], "status": one["status"], "total_s": one["seconds"]["total"]} for one in answer["results"]] if answer else []


def buckling(table, name, scene, words, case):
    """buckling: the axial traction in place of `@` from which the state is called unstable, over Euler's load, by halving."""
    text, truth = scene.read_text(), float(eval(case["truth"], {"math": math, **case["values"]}))
    low, high = 0.8, 1.2
    for _ in range(5):
        middle = (low + high) / 2
        scene.write_text(text.replace("@", str(-middle * truth)))
        answer, *_ = table.run([table.maille, "run", scene, "--method", "coupled", "--json"])
        is_stable = answer and answer["results"][0]["status"] == "done" and "unstable" not in answer["results"][0].get("message", "")
        low, high = (middle, high) if is_stable else (low, middle)
    return [{"method": "coupled", "critical_over_euler": (low + high) / 2, "error": abs((low + high) / 2 - 1)}]


ASKS = {"strains": strains, "dolfinx": dolfinx, "steps": steps, "buckling": buckling, "choose": choose, "fit": fit, "start": start, "study": study, "promises": promises, "refused": refused}
