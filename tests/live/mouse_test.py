"""Every prototype is done by real mouse events: xdotool moves the pointer of an X server, `maille live` has the window.

The maze is walked, the puzzle solved, washer and nut are put on the bolt, a head is felt, a muscle poked, a calf pulled.

Usage: mouse_test.py MAILLE SCENES maze|puzzle|bolt|head|muscle|calf    (under xvfb-run; see CMakeLists.txt)
"""
import json
import os
import subprocess
import sys
import tempfile
import time
import tomllib

MAILLE, SCENES, PROTOTYPE = sys.argv[1:4]
WORLDS = os.path.join(SCENES, "world")
WIDTH, HEIGHT, PANEL = 960, 720, 300
STEP = 2.0  # of the pointer [mm]


def xdotool(*words):
    return subprocess.run(["xdotool", *map(str, words)], check=True, capture_output=True, text=True).stdout


def window_of_live():
    """Waited for here: xdotool's own --sync may wait for ever."""
    for _ in range(100):
        found = subprocess.run(["xdotool", "search", "--onlyvisible", "--name", "^Maille"], capture_output=True, text=True).stdout.split()
        if found:
            return found[0]
        time.sleep(0.1)
    raise TimeoutError("no window")


def place(world, x, y):
    """Where a place of the world [mm] is in the window: the whole world fits, with a fiftieth of room above and below."""
    across, up = world["cells"]
    aspect = (WIDTH - PANEL) / HEIGHT
    height = 1.04 * max(up, across / aspect)
    return ((0.5 + (x - across / 2) / (height * aspect)) * (WIDTH - PANEL), (0.5 - (y - up / 2) / height) * HEIGHT)


def move(window, world, x, y):
    px, py = place(world, x, y)
    xdotool("mousemove", "--window", window, round(px), round(py))
    time.sleep(0.02)


def drag(window, world, start, shifts):
    """From a place through shifts of it, all in millimetres."""
    move(window, world, *start)
    xdotool("mousedown", 1)
    time.sleep(0.1)
    now = (0.0, 0.0)
    for to in shifts:
        n = max(1, round(max(abs(to[0] - now[0]), abs(to[1] - now[1])) / STEP))
        for i in range(1, n + 1):
            move(window, world, start[0] + now[0] + (to[0] - now[0]) * i / n, start[1] + now[1] + (to[1] - now[1]) * i / n)
        now = to
        time.sleep(0.1)
    xdotool("mouseup", 1)
    time.sleep(0.1)


def millimetres(text):
    return float(text.removesuffix(" mm")) if isinstance(text, str) else float(text)


def walk_the_maze(window, scene):
    with open(os.path.join(WORLDS, "maze_path.toml"), "rb") as file:
        path = tomllib.load(file)["drive"]
    places = [[millimetres(v) for v in drive["to"]] for drive in path[:-1]]  # the last pulls back through the walls
    drag(window, scene["world"], (4.5, 4.5), [(x - 2, y - 2) for x, y in places])


def solve_the_puzzle(window, scene):
    objects = {each["name"]: each for each in scene["object"]}
    with open(os.path.join(WORLDS, "puzzle_solved.toml"), "rb") as file:
        drives = tomllib.load(file)["drive"]
    for name in dict.fromkeys(drive["object"] for drive in drives):
        x, y = (millimetres(v) for v in objects[name]["position"])
        column, row = objects[name]["piece"]
        # Its middle: pieces are a third of 48 mm by half of 32 mm.
        start = (x + 16 * column + 8, y + 16 * row + 8)
        # A little too far: it slides along what it meets, and is drawn home by what is around it.
        shifts = [(millimetres(d["to"][0]) - x, millimetres(d["to"][1]) - y) for d in drives if d["object"] == name]
        drag(window, scene["world"], start, shifts)


def drag_in_window(window, start, ends, keys=(), release=True):
    """From a pixel of the window through others, three pixels a move; keys are pressed when it is taken."""
    x, y = start
    xdotool("mousemove", "--window", window, x, y)
    xdotool("mousedown", 1)
    time.sleep(0.1)
    for key in keys:
        xdotool("key", key)
        time.sleep(0.1)
    drag_on(window, start, ends)
    if release:
        xdotool("mouseup", 1)
        time.sleep(0.2)


def drag_on(window, start, ends):
    x, y = start
    for to in ends:
        n = max(1, round(max(abs(to[0] - x), abs(to[1] - y)) / 3))
        for i in range(1, n + 1):
            xdotool("mousemove", "--window", window, round(x + (to[0] - x) * i / n), round(y + (to[1] - y) * i / n))
            time.sleep(0.02)
        x, y = to
    time.sleep(0.2)


# Where things are in a first picture of 660 x 720 pixels, as one sees them.
NOTCHES = 40  # of the wheel, each a fiftieth of the skull's half diagonal
WASHER, NUT, FINGERTIP, PROBE, CALF_END = (240, 238), (330, 130), (447, 355), (330, 260), (310, 600)


def assemble_the_bolt(window, scene):
    """The washer down to the head; the nut down to the thread, and on with it: a turn of 5 degrees, then a pixel down."""
    drag_in_window(window, WASHER, [(240, 640)], keys=["z"])
    drag_in_window(window, NUT, [(330, 240)], keys=["z"], release=False)
    for i in range(190):
        xdotool("key", "period")
        xdotool("mousemove", "--window", window, 330, 241 + i)
        time.sleep(0.03)
    time.sleep(0.5)
    xdotool("mouseup", 1)


def feel_the_head(window, scene):
    """From the cheek to the forehead, and away until bone stops it; then along it."""
    drag_in_window(window, FINGERTIP, [(350, 260)], release=False)
    for _ in range(NOTCHES):
        xdotool("click", 4)
        time.sleep(0.03)
    drag_on(window, (350, 260), [(330, 240)])
    time.sleep(0.3)
    xdotool("mouseup", 1)


def poke_the_muscle(window, scene):
    drag_in_window(window, PROBE, [(330, 320), (330, 260)], keys=["z"])


def pull_the_calf(window, scene):
    drag_in_window(window, CALF_END, [(310, 650)])


def bolt_is_assembled(result):
    at = {each["name"]: each for each in result["objects"]}
    # The washer lies on the head, 10 mm up; the nut, which began 62 mm up, and met the thread 45.5 mm up, has gone on for a turn.
    assert abs(at["washer"]["position"][2] - 0.0095) < 0.0006, at
    assert at["nut"]["position"][2] < 0.0355, at


def head_is_felt(result):
    tip = [1000 * v for v in result["objects"][-1]["position"]]
    start = [1000 * v for v in (0.1, 0.0033, 0.1005)]
    sight = [0.45, 0.82, -0.35]
    length = sum(v * v for v in sight) ** 0.5
    away = sum(v / length * (a - b) for v, a, b in zip(sight, tip, start))
    asked = NOTCHES / 50 * (204.8**2 + 204.8**2 + 139.5**2) ** 0.5 / 2
    assert 5 < away < 0.9 * asked, (away, asked, tip)


def muscle_is_poked(result):
    forces = [abs(drive["force"][2]) for frame in result["frames"] for drive in frame["drives"]]
    assert max(forces) > 0.01, forces  # [N]
    assert abs(result["objects"][-1]["position"][2] - 0.019) < 0.0005, result["objects"]  # it has come back


def calf_is_pulled(result):
    assert result["limit_violation"] < 1e-6, result["limit_violation"]
    assert any(drive["fraction"] > 0.1 for frame in result["frames"] for drive in frame["drives"]), result["frames"]


PROTOTYPES_IN_3D = {"bolt": (assemble_the_bolt, bolt_is_assembled), "head": (feel_the_head, head_is_felt),
                    "muscle": (poke_the_muscle, muscle_is_poked), "calf": (pull_the_calf, calf_is_pulled)}


def main():
    scene_file = os.path.join(SCENES, "calf_soleus.toml") if PROTOTYPE == "calf" else os.path.join(WORLDS, PROTOTYPE + ".toml")
    if PROTOTYPE in ("head", "calf") and "MAILLE_DATA" not in os.environ:
        print("skipped: MAILLE_DATA is not set")
        sys.exit(77)
    with open(scene_file, "rb") as file:
        scene = tomllib.load(file)
    with tempfile.TemporaryDirectory() as folder:
        record = os.path.join(folder, "hand.csv")
        live = subprocess.Popen([MAILLE, "live", scene_file, "--record", record, "--size", f"{WIDTH}x{HEIGHT}", "--text", "1"],
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        try:
            window = window_of_live()
            time.sleep(1)
            xdotool("windowfocus", window)
            by_hand = {"maze": walk_the_maze, "puzzle": solve_the_puzzle} | {name: each[0] for name, each in PROTOTYPES_IN_3D.items()}
            by_hand[PROTOTYPE](window, scene)
            time.sleep(0.5)
            xdotool("key", "ctrl+q")  # as from a keyboard: not sent to the window
            out, err = live.communicate(timeout=60)
        finally:
            if live.poll() is None:
                live.kill()
        assert live.returncode == 0, err
        assert "penetrations: 0" in out, out
        played = subprocess.run([MAILLE, "play", scene_file, record, "--json"], check=True, capture_output=True, text=True)
    result = json.loads(played.stdout)
    assert result["penetrations"] == 0
    at = {each["name"]: [1000 * v for v in each["position"][:2]] for each in result["objects"]}
    print(out, at)
    if PROTOTYPE in PROTOTYPES_IN_3D:
        PROTOTYPES_IN_3D[PROTOTYPE][1](result)
    elif PROTOTYPE == "maze":
        assert at["piece"][0] > 56 and at["piece"][1] > 40, at  # the room in the upper right corner
    else:
        pixel = 1.04 * max(76, 112 * HEIGHT / (WIDTH - PANEL)) / HEIGHT
        for name, (x, y) in at.items():
            assert abs(x - 24) < 1.5 * pixel + 0.1 and abs(y - 4) < 1.5 * pixel + 0.1, (name, x, y)


main()
