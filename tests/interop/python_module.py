#!/usr/bin/env python3
"""Builds the Python module against installed libraries, and runs its tests.

usage: python_module.py SOURCE PREFIX PROGRAM VENV BUILD [CMAKE OPTION...]
       PREFIX: where betamesh is installed; VENV: a virtual environment, which is made if it is missing; BUILD: a folder
exit:  0 all tests pass, 1 some fail, 77 skipped (headers of Python, pip or the network are missing)
"""

import os
import subprocess
import sys
import sysconfig

NEEDED = ["nanobind>=3.1", "numpy", "pytest"]
OF_EXAMPLES = ["matplotlib", "pysplashsurf"]  # those without them are skipped


def skip(why):
    print("skipped: " + why)
    sys.exit(77)


def succeeds(*words):
    return subprocess.run(words, check=False).returncode == 0


def environment(venv):
    """The Python of a virtual environment that has what the module needs."""
    python = os.path.join(venv, "bin", "python")
    if not os.path.exists(python) and not succeeds(sys.executable, "-m", "venv", venv):
        skip("no virtual environment can be made. Install python3-venv")
    pip = [python, "-m", "pip", "install", "--quiet", "--retries", "1", "--timeout", "20"]
    if not succeeds(python, "-c", "import nanobind, numpy, pytest") and not succeeds(*pip, *NEEDED):
        skip("pip cannot install " + ", ".join(NEEDED))
    if not succeeds(python, "-c", "import " + ", ".join(OF_EXAMPLES)):
        succeeds(*pip, *OF_EXAMPLES)
    return python


def main():
    source, prefix, program, venv, build = map(os.path.abspath, sys.argv[1:6])
    if not os.path.exists(os.path.join(sysconfig.get_paths()["include"], "Python.h")):
        skip("there is no Python.h. Install python3-dev")
    python = environment(venv)
    configure = ["cmake", "-S", os.path.join(source, "lib", "python"), "-B", build, "-DCMAKE_PREFIX_PATH=" + prefix]
    if not succeeds(*configure, "-DPython_EXECUTABLE=" + python, *sys.argv[6:]):
        return 1
    if not succeeds("cmake", "--build", build, "-j2"):
        return 1
    variables = {**os.environ, "PYTHONPATH": os.path.join(build, "python"), "BETAMESH_PROGRAM": program}
    tests = os.path.join(source, "tests", "interop", "python")
    words = [python, "-m", "pytest", "-q", "-rs", "-p", "no:cacheprovider", "--durations=5", tests]
    return subprocess.run(words, env={**variables, "PYTHONDONTWRITEBYTECODE": "1"}, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
