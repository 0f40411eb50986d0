"""scripts/house finds what it measures, in small trees that are made for each check."""
import pathlib
import subprocess
import sys
import tempfile

HOUSE = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "house"
SETTINGS = 'base = "HEAD"\n[words]\nrefused = ["nobody"]\n[figures]\n'


class Tree:
    """A checkout in which files are written, committed and measured."""

    def __enter__(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)
        self.write("scripts/house", HOUSE.read_text(encoding="utf-8"))
        self.git("init", "-q")
        return self

    def __exit__(self, *_):
        self.folder.cleanup()

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def git(self, *words):
        subprocess.run(["git", "-c", "user.name=t", "-c", "user.email=t@t", *words], cwd=self.root, check=True, capture_output=True)

    def commit(self):
        self.git("add", "-A")
        self.git("commit", "-q", "-m", "Change")

    def house(self, *words):
        self.git("add", "-A")
        run = subprocess.run([sys.executable, self.root / "scripts/house", *words], capture_output=True, text=True, check=False)
        return run.returncode, run.stdout + run.stderr


def test_private_includes():
    for levels, code in (('[["low"], ["high"]]', 0), ('[["high"], ["low"]]', 1)):
        with Tree() as tree:
            tree.write("deform/src/low/a.hpp", "#pragma once\n")
            tree.write("deform/src/high/b.cpp", '#include "low/a.hpp"\n')
            tree.write("tests/architecture/rooms.toml", f"deform = {levels}\n")
            got, text = tree.house("--arrows")
            assert got == code and ("deform/high includes deform/low" in text) == bool(code), text


def test_public_headers_belong_to_their_implementer():
    with Tree() as tree:
        tree.write("tests/architecture/rooms.toml", 'deform = [["low"], ["high"]]\n')
        tree.write("tests/architecture/house.toml", SETTINGS)
        tree.write("deform/include/maille/plan.hpp", "#pragma once\n")
        tree.write("deform/src/high/plan.cpp", '#include "maille/plan.hpp"\n')
        assert tree.house("--list", "upward_arrows")[1].strip() == ""
        tree.write("deform/src/low/body.cpp", '#include "maille/plan.hpp"\n')
        text = tree.house("--list", "upward_arrows")[1]
        assert "deform/low includes deform/include/maille/plan.hpp, which deform/high implements" in text, text


def test_engines():
    with Tree() as tree:
        tree.write("tests/architecture/house.toml", SETTINGS)
        tree.write("deform/src/a.cpp", "void f() {\n  ++answer.iterations;\n}\nconstexpr int patience = 5;\n")
        tree.write("deform/src/b.hpp", "struct S {\n  std::vector<bool> is_fixed_;\n  Eigen::SimplicialLLT<M> factor;\n};\n")
        text = tree.house("--list", "engines")[1].split("\n")
        assert {"outer_iterations: deform/src/a.cpp", "stopping_rules: deform/src/a.cpp", "sparse_factorisations: deform/src/b.hpp"} <= set(text), text
        assert "std::vector<bool>" in tree.house("--list", "fixed_representations")[1]


def test_ratchet():
    with Tree() as tree:
        for commit, ceiling, code in ((True, 10, 0), (True, 9, 0), (False, 10, 1), (True, 10, 1)):
            tree.write("tests/architecture/house.toml", SETTINGS + f"types = {{ ceiling = {ceiling} }}\n")
            if commit:
                tree.commit()
            got, text = tree.house("--ratchet")
            assert got == code and ("types: ceiling 9 -> 10" in text) == bool(code), text
        tree.write("tests/architecture/house.toml", SETTINGS)
        assert "types: ceiling 10 -> none" in tree.house("--ratchet")[1]


def test_grant():
    with Tree() as tree:
        for granted, code in ((2, 0), (1, 0), (2, 1)):
            tree.write("tests/architecture/house.toml", SETTINGS + f"types = {{ ceiling = 10, granted = {granted} }}\n")
            got, text = tree.house("--ratchet")
            assert got == code and ("types: granted 1 -> 2" in text) == bool(code), text
            tree.commit()


for name, test in list(globals().items()):
    if name.startswith("test_"):
        test()
print("found")
