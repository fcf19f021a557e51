"""Modules of Python and packages of npm that tests need and that are not part of the system: they are installed below
the build folder."""

import fcntl
import importlib
import importlib.util
import os
import subprocess
import sys

SKIPPED = 77
SECONDS = 300  # for all downloads together


def python_with(venv, modules):
    """The Python of a virtual environment which has all modules, and why not if that fails.

    venv: folder, which is made if it is not there. modules: names to import -> names on PyPI."""
    python = os.path.join(venv, "bin", "python")
    os.makedirs(os.path.dirname(os.path.abspath(venv)), exist_ok=True)
    with open(os.path.abspath(venv) + ".lock", "w") as lock:  # tests may run at the same time
        fcntl.flock(lock, fcntl.LOCK_EX)
        try:
            if not os.path.exists(python):
                subprocess.run([sys.executable, "-m", "venv", venv], check=True, capture_output=True, timeout=SECONDS)
            lacks = [package for module, package in modules.items()
                     if subprocess.run([python, "-c", "import " + module], capture_output=True).returncode != 0]
            if lacks:
                install = [python, "-m", "pip", "install", "--disable-pip-version-check", "--quiet", "--timeout", "15",
                           "--retries", "1", *lacks]
                subprocess.run(install, check=True, capture_output=True, text=True, timeout=SECONDS)
        except subprocess.TimeoutExpired as error:
            return None, "%s took more than %d s" % (" ".join(error.cmd), SECONDS)
        except (OSError, subprocess.CalledProcessError) as error:
            said = (getattr(error, "stderr", "") or "").strip() if isinstance(getattr(error, "stderr", ""), str) else ""
            return None, "%s%s" % (error, ": " + said.splitlines()[-1] if said else "")
    return python, None


def npm_package(folder, name):
    """The folder of a package of npm, which is unpacked into `folder` without what it depends on; and why not if that
    fails."""
    package = os.path.join(os.path.abspath(folder), name)
    os.makedirs(folder, exist_ok=True)
    with open(package + ".lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        try:
            if not os.path.exists(os.path.join(package, "package.json")):
                packed = subprocess.run(["npm", "pack", "--silent", name], cwd=folder, check=True, capture_output=True,
                                        text=True, timeout=SECONDS).stdout.split()[-1]
                os.makedirs(package, exist_ok=True)
                subprocess.run(["tar", "xzf", os.path.join(folder, packed), "-C", package, "--strip-components", "1"],
                               check=True, capture_output=True)
        except (OSError, IndexError, subprocess.SubprocessError) as error:
            return None, str(error)
    return package, None


def missing(modules):
    """Those that this Python does not have."""
    return [module for module in modules if importlib.util.find_spec(module.split(".")[0]) is None]


def run_with(venv, modules, may_lack=False):
    """Returns None if this Python has all modules. Otherwise runs this script again with a Python that has them.

    If none can be had: ends the test as skipped, or with may_lack returns the reason."""
    if not missing(modules):
        return None
    python, reason = python_with(venv, modules)
    if python is not None and os.path.realpath(sys.prefix) != os.path.realpath(venv):
        sys.stdout.flush()
        os.execv(python, [python, *sys.argv])
    importlib.invalidate_caches()  # they may have been installed for this very Python
    if not missing(modules):
        return None
    reason = reason or "the virtual environment lacks " + ", ".join(missing(modules))
    if may_lack:
        return reason
    print("skipped: there is no module %s: %s" % (", ".join(missing(modules)), reason))
    sys.exit(SKIPPED)
