"""What tests of the Python module share: the suites are named as those of C++, by the truth of their numbers."""

import os
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest

sys.path.insert(0, os.environ["MAILLE_PYTHON_PATH"])
import maille  # noqa: E402

STRIP = """
[specimen]
shape = "box"
cells = [8, 4, 4]
spacing = "1 mm"
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = ["0.4 mm", 0, 0]
"""


def ended(program, **environment):
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True,
                          env={**os.environ, "PYTHONPATH": os.environ["MAILLE_PYTHON_PATH"], **environment})


def press_ctrl_c(after):
    threading.Timer(after, os.kill, (os.getpid(), signal.SIGINT)).start()


def faults_of_four_threads(once, times, until_first=False):
    """Calls once(thread, time) from four threads side by side. Any error but RuntimeError fails. @return what those say"""
    faults, others = [], []

    def repeat(thread):
        for time in range(times):
            if until_first and faults:
                return
            try:
                once(thread, time)
            except RuntimeError as error:
                faults.append(str(error))
            except Exception as error:
                others.append(error)

    threads = [threading.Thread(target=repeat, args=(thread,)) for thread in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not others
    return faults


@pytest.fixture
def strip(tmp_path):
    """A scene file of a bar that is pulled."""
    file = tmp_path / "strip.toml"
    file.write_text(STRIP)
    return file


def two_labels(order="C", dtype=np.uint8):
    """Labels 17 and 5 in 6 x 5 x 4 voxels, nothing around them."""
    labels = np.zeros((8, 7, 6), dtype=dtype, order=order)
    labels[1:7, 1:6, 1:3] = 17
    labels[1:7, 1:6, 3:5] = 5
    return labels


#: Oblique, in millimetres.
AFFINE = np.array([[1.6, -1.2, 0, 10], [1.2, 1.6, 0, -20], [0, 0, 3, 5], [0, 0, 0, 1]])


def label_scene(labels, **keys):
    return maille.Scene(
        maille.Image(labels, affine=AFFINE,
                     labels={17: "muscle/soleus", 5: {"youngs_modulus": "30 kPa", "poisson_ratio": 0.4}}, fibre=(1, 0, 0)),
        holds=[maille.hold("z-")], moves=[maille.move("z+", by=(0, 0, "0.3 mm"))], **keys)
