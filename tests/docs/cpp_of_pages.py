"""Every C++ snippet of every page compiles: cpp_of_pages.py COMPILER SOURCES [FLAG...]

Snippets with an `int main()` stand alone. The others are parts of a program: SURROUNDINGS has the lines that come before each of them, by page, in the
order of the page; a snippet without an entry is a fault.
"""
import pathlib
import subprocess
import sys
import tempfile

from commands_of_page import blocks, print_figure

DEVICE = """#include <maille/deform/probe/servo_loop.hpp>
#include <maille/scene/world/world_scene.hpp>
"""
# Page -> for each snippet that is no program what stands before it, and behind it.
SURROUNDINGS = {
    "docs/cpp.md": [("""#include <maille/deform/solve.hpp>
void ask(const maille::Scene& scene) {
""", "}")],
    "docs/probe.md": [(DEVICE, ""), (DEVICE + """class MyDevice : public maille::deform::ProbeDevice {
public:
  maille::deform::Pose read() override { return {}; }
  void write(const maille::deform::ProbeForce&) override {}
  double damping() const override { return 0.5; }
};
void feel() {
""", "(void)report;\n}")],
    "docs/render.md": [("""#include <maille/render/renderer.hpp>
#include <maille/scene/look.hpp>
#include <memory>
void draw(const maille::Seen& seen, const maille::Specimen& body, const maille::render::View& view) {
""", "(void)picture;\n}")],
}
ROOMS = ["materials", "scene/images", "scene", "deform/mechanics", "deform", "render"]


def main():
    compiler, sources = sys.argv[1], pathlib.Path(sys.argv[2])
    n_compiled, faults = 0, []
    with tempfile.TemporaryDirectory(prefix="maille-cpp-") as temporary:
        file = pathlib.Path(temporary) / "snippet.cpp"
        for page in sorted([*sources.glob("docs/**/*.md"), sources / "README.md"]):
            name = str(page.relative_to(sources))
            surroundings = iter(SURROUNDINGS.get(name, []))
            for language, lines in blocks(page):
                if language != "cpp":
                    continue
                text = "\n".join(lines) + "\n"
                before, behind = ("", "") if "int main(" in text else next(surroundings, (None, None))
                if before is None:
                    faults.append(f"{name}: nothing is known of what stands around\n{text}")
                    continue
                file.write_text(before + text + behind + "\n", encoding="utf-8")
                run = subprocess.run([compiler, "-std=c++20", "-fsyntax-only", *(f"-I{sources}/{room}/include" for room in ROOMS), *sys.argv[3:], str(file)],
                                     capture_output=True, text=True)
                n_compiled += 1
                if run.returncode != 0:
                    faults.append(f"{name}:\n{text}\n{run.stderr[:3000]}")
    print(f"{n_compiled} snippets of C++ compiled, {len(faults)} failed")
    print("\n".join(faults))
    print_figure(len(faults))
    return 1 if faults or n_compiled == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
