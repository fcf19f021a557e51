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

from virtual_environment import SKIPPED, python_with

NEEDED = {"nanobind": "nanobind>=3.1", "numpy": "numpy", "pytest": "pytest"}
OF_EXAMPLES = {"matplotlib": "matplotlib", "pysplashsurf": "pysplashsurf"}  # tests of examples without them are skipped


def skip(why):
    print("skipped: " + why)
    sys.exit(SKIPPED)


def succeeds(*words):
    return subprocess.run(words, check=False).returncode == 0


def main():
    source, prefix, program, venv, build = map(os.path.abspath, sys.argv[1:6])
    if not os.path.exists(os.path.join(sysconfig.get_paths()["include"], "Python.h")):
        skip("there is no Python.h. Install python3-dev")
    python, reason = python_with(venv, NEEDED)
    if python is None:
        skip(reason)
    python_with(venv, OF_EXAMPLES)
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
