"""Runs every `maille ...` command of one page, in the order of the page, as a reader would: commands_of_page.py MAILLE SOURCES PAGE

A command fails where it ends with a code that its page does not promise: 0, or what `# exit N` behind it says; 2, a usage that is wrong or a file
with faults, never passes unnoticed. One that is still busy after SECONDS has been understood, and is interrupted: it must then end by itself.
TOML of the page that begins with `# NAME.toml` is written as that file first, and is checked. Words in capitals (SCENE.toml, DIR) stand for
something: such lines are usage, not examples. Lines with MAILLE_DATA are skipped where it is unset, as is what says so itself.
"""
import json
import os
import pathlib
import re
import shlex
import signal
import subprocess
import sys
import tempfile

SECONDS = 60
# Commands that take minutes: what matters here is that they are understood.
LONG, SECONDS_OF_LONG = {"study trade", "fit", "live"}, 4
SECONDS_TO_END = 60
STANDS_FOR = re.compile(r"\b[A-Z][A-Z0-9_]*(\.[a-z]+)?$|^\.\.\.$|\bFILE\b|\bDIR\b|\bSCENE\b|\bNAME\b|\bHOST\b")


def blocks(page):
    language, lines = None, []
    for line in page.read_text(encoding="utf-8").split("\n"):
        fence = re.match(r"\s*```(\w*)", line)
        if fence and language is None:
            language, lines = fence.group(1), []
        elif fence:
            yield language, lines
            language = None
        elif language is not None:
            lines.append(line)


def commands(lines):
    whole = ""
    for line in lines:
        whole += line.rstrip()
        if whole.endswith("\\"):
            whole = whole[:-1] + " "
            continue
        text, _, comment = whole.partition("   #") if "   #" in whole else whole.partition(" # ")
        whole = ""
        text = text.strip()
        needs_data = text.startswith("MAILLE_DATA=")
        text = re.sub(r"^MAILLE_DATA=\S+\s+", "", text)
        if re.match(r"(\S*/)?maille\s", text) and not any(c in text for c in "|<>;"):
            promised = re.search(r"exit (\d)", comment)
            yield shlex.split(text), int(promised.group(1)) if promised else 0, needs_data


def run(words, promised, folder):
    seconds = SECONDS_OF_LONG if {words[1], " ".join(words[1:3])} & LONG else SECONDS
    process = subprocess.Popen(words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    try:
        output, _ = process.communicate(timeout=seconds)
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGINT)
        try:
            output, _ = process.communicate(timeout=SECONDS_TO_END)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            return f"did not end within {SECONDS_TO_END} s of Ctrl-C"
        return None if process.returncode in (0, 1, 128 + signal.SIGINT, -signal.SIGINT) else f"exit {process.returncode} after Ctrl-C\n{output}"
    if process.returncode == promised:
        return None
    # 1 and 3: a program that is not installed, a machine without something; the command says which.
    if process.returncode in (1, 3) and re.search(r"not installed|no such program|is not set|skipped", output):
        return None
    return f"exit {process.returncode}, expected {promised}\n{output}"


def main():
    maille, sources, name = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    has_data = bool(os.environ.get("MAILLE_DATA"))
    n_run, skipped, faults = 0, 0, []
    with tempfile.TemporaryDirectory(prefix="maille-page-") as temporary:
        folder = pathlib.Path(temporary)
        for room in ("scene", "studies", "materials"):
            (folder / room).symlink_to(sources / room)
        (folder / "docs").mkdir()
        for language, lines in blocks(sources / name):
            title = re.match(r"#\s+(?:example:\s+)?([\w.-]+\.(?:toml|csv))\b", lines[0]) if lines else None
            if language in ("toml", "csv") and title:
                (folder / title.group(1)).write_text("\n".join(lines[1:] if language == "csv" else lines) + "\n", encoding="utf-8")
                continue
            if language not in ("", "sh", "bash", "console"):
                continue
            for words, promised, needs_data in commands(lines):
                if any(STANDS_FOR.search(word) for word in words[1:]):
                    continue
                if not has_data and (needs_data or any("MAILLE_DATA" in f.read_text(errors="replace") for f in files_of(words, folder))):
                    skipped += 1
                    continue
                n_run += 1
                fault = run([maille, *expanded(words[1:], folder)], promised, folder)
                if fault:
                    faults.append(f"{name}: {' '.join(words)}\n  {fault}")
    print(f"{name}: {n_run} commands run, {skipped} skipped without MAILLE_DATA, {len(faults)} failed")
    print_figure(len(faults))
    for fault in faults:
        print(fault)
    return 1 if faults else 0


def print_figure(n_failed):
    print(json.dumps({"name": "docs_snippets_failing", "value": n_failed, "goal": 0}))


def expanded(words, folder):
    """With * as a shell has it."""
    found = []
    for word in words:
        matches = sorted(str(p.relative_to(folder)) for p in folder.glob(word)) if "*" in word else []
        found += matches or [word]
    return found


def files_of(words, folder):
    return [folder / w for w in words if w.endswith(".toml") and (folder / w).is_file()]


if __name__ == "__main__":
    sys.exit(main())
