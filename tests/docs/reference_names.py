"""docs/python_reference.md has a directive for every public name of the module: reference_names.py SOURCES"""
import ast
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
package = ast.parse((root / "python/maille/__init__.py").read_text(encoding="utf-8"))
public = next(ast.literal_eval(node.value) for node in package.body
              if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "__all__")
shown = re.findall(r"^::: maille\.(?:\w+\.)?(\w+)$", (root / "docs/python_reference.md").read_text(encoding="utf-8"), re.M)
if faults := sorted(set(public) ^ (set(shown) - {"fem"})):
    sys.exit(f"docs/python_reference.md and maille.__all__ differ in {', '.join(faults)}")
