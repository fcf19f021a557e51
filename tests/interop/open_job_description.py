#!/usr/bin/env python3
"""What `submit` writes for farms, run and read by the programs of these farms: Open Job Description templates by
openjd-cli and openjd-sessions, job bundles by the client of AWS Deadline Cloud, commands for OpenCue by PyOutline.

usage: open_job_description.py PROGRAM VENV
       VENV: a virtual environment, into which openjd-cli, deadline and opencue-pyoutline are installed if they are not
       there
exit:  0 all agree, 1 some differ, 77 skipped (openjd-cli cannot be installed)
"""

import glob
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree

from virtual_environment import run_with

FRAMES = range(1, 10)
SECONDS = 240  # for one command
FOLDER = "a job's $HOME \"\u00e4\u2028\" {x} #1"  # U+2028 is a line break in YAML

failures = 0


def check(what, good, told=""):
    global failures
    print("%-90s %s" % (what, "right" if good else "WRONG"))
    if not good:
        failures += 1
        print(told)


def run(*words, **more):
    return subprocess.run([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=SECONDS, **more)


def must(*words, **more):
    result = run(*words, **more)
    if result.returncode != 0:
        sys.exit("%s: %s" % (shlex.join(map(str, words)), result.stdout))
    return result.stdout


def openjd(*words):
    return [os.path.join(os.path.dirname(sys.executable), "openjd"), *words]


def meshes(folder):
    """Names and contents of the meshes in a folder."""
    files = {}
    for path in sorted(glob.glob(os.path.join(glob.escape(folder), "*.ply"))):
        with open(path, "rb") as file:
            files[os.path.basename(path)] = file.read()
    return files


def frames_in(folder):
    return [int(name.split(".")[1]) for name in meshes(folder)]


def hidden_files(folder):
    return [name for name in os.listdir(folder) if name.startswith(".")]


class Job:
    """A pipeline with nine frames, and the meshes of a local run."""

    def __init__(self, program, folder):
        self.program, self.folder, self.out = program, folder, os.path.join(folder, "out")
        os.makedirs(folder)
        must(program, "sample", "dambreak", "in/a.####.ply", "--particles", 7000, "--frames", "1-9", "-q", cwd=folder)
        with open(os.path.join(folder, "job.yaml"), "w") as file:
            file.write("version: 1\ninput: {path: in/a.####.ply}\noutput: {path: out/a.####.ply}\nrun: {threads: 1}\n")
        must(program, "run", "job.yaml", "--set", "output.path=local/a.####.ply", cwd=folder)
        self.local = meshes(os.path.join(folder, "local"))
        assert len(self.local) == len(FRAMES)

    def submit(self, *words):
        return must(self.program, "submit", "job.yaml", *words, cwd=self.folder)

    def clear(self):
        shutil.rmtree(self.out, ignore_errors=True)

    def template(self):
        return os.path.join(self.folder, "job.openjd.yaml")


def run_to_the_end(job):
    result = run(*openjd("check", job.template()))
    check("openjd check accepts the template", result.returncode == 0, result.stdout)
    result = run(*openjd("run", job.template()))
    check("openjd run succeeds", result.returncode == 0, result.stdout)
    for chunk in ("1-3", "4-6", "7-9"):
        check("frames %s are a task" % chunk, "Frame(CHUNK[INT]) = %s\n" % chunk in result.stdout, result.stdout)
    check("the meshes are those of a local run", meshes(job.out) == job.local, os.listdir(job.out))
    check("the report is made after them", os.path.exists(os.path.join(job.out, "job.html")), result.stdout)


def run_other_frames(job):
    """The frames are a parameter, which the report follows."""
    job.clear()
    result = run(*openjd("run", job.template(), "-p", "Frames=1-9:4", "-p", "FramesPerTask=1"))
    check("a run with other frames succeeds", result.returncode == 0, result.stdout)
    check("it makes these frames alone", frames_in(job.out) == [1, 5, 9], os.listdir(job.out))


def cancel_and_run_again(job):
    job.clear()
    words = openjd("run", job.template(), "--step", "Mesh", "-tp", "Frame=1-9")
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    latest = time.monotonic() + SECONDS
    while not os.path.exists(os.path.join(job.out, "a.0001.ply.json")):
        assert process.poll() is None and time.monotonic() < latest, "the first frame was not written"
        time.sleep(0.01)
    begin = time.monotonic()
    process.send_signal(signal.SIGINT)
    told, _ = process.communicate(timeout=SECONDS)
    check("a cancelled task fails", process.returncode != 0, told)
    check("it ends long before it would be killed", time.monotonic() - begin < 20, told)
    check("it has the exit code of SIGTERM", "exited with code: 143" in told, told)
    check("finished frames remain, the others are not there", 1 <= len(frames_in(job.out)) < len(FRAMES), told)
    check("no frame is half-written", not hidden_files(job.out) and
          all(content == job.local[name] for name, content in meshes(job.out).items()), os.listdir(job.out))
    result = run(*openjd("run", job.template()))
    check("run again, the job succeeds", result.returncode == 0, result.stdout)
    check("its meshes are those of a local run", meshes(job.out) == job.local, os.listdir(job.out))


def fail_and_repair(job):
    job.clear()
    damaged = os.path.join(job.folder, "in/a.0005.ply")
    shutil.copy(damaged, damaged + ".whole")
    with open(damaged, "r+b") as file:
        file.truncate(1000)
    result = run(*openjd("run", job.template(), "--step", "Mesh", "-tp", "Frame=4-6"))
    check("the task of a damaged frame fails", result.returncode != 0, result.stdout)
    check("it has the exit code of a failed frame", "exited with code: 1 " in result.stdout, result.stdout)
    check("the reason names the file", "in/a.0005.ply: byte " in result.stdout, result.stdout)
    check("its other frames are written", frames_in(job.out) == [4, 6], os.listdir(job.out))
    result = run(*openjd("run", job.template(), "--step", "Mesh", "-tp", "Frame=1-3"))
    check("other tasks succeed", result.returncode == 0 and frames_in(job.out) == [1, 2, 3, 4, 6], result.stdout)
    os.replace(damaged + ".whole", damaged)
    result = run(*openjd("run", job.template()))
    check("after repair, the job succeeds", result.returncode == 0, result.stdout)
    check("its meshes are those of a local run", meshes(job.out) == job.local, os.listdir(job.out))


def session_of(job, statuses):
    """A session as the worker of a farm has it. Returns it with a function that runs a task."""
    from pathlib import Path

    import yaml
    from openjd.model import (IntRangeExpr, ParameterValue, ParameterValueType, RevisionExtensions,
                              SpecificationRevision, create_job, decode_job_template, preprocess_job_parameters)
    from openjd.sessions import Session

    with open(job.template(), encoding="utf-8") as file:
        template = decode_job_template(template=yaml.safe_load(file), supported_extensions=["TASK_CHUNKING"])
    values = preprocess_job_parameters(job_template=template, job_parameter_values={},
                                       job_template_dir=Path(job.folder), current_working_dir=Path(job.folder))
    steps = {step.name: step for step in create_job(job_template=template, job_parameter_values=values).steps}
    session = Session(session_id="test", job_parameter_values=values,
                      callback=lambda _, status: statuses.append(status),
                      revision_extensions=RevisionExtensions(spec_rev=SpecificationRevision.v2023_09,
                                                             supported_extensions=["TASK_CHUNKING"]))

    def run_task(frames):
        chunk = ParameterValue(type=ParameterValueType.CHUNK_INT, value=str(IntRangeExpr.from_str(frames)))
        session.run_task(step_script=steps["Mesh"].script, task_parameter_values={"Frame": chunk})
        latest = time.monotonic() + SECONDS
        while session.state.name == "RUNNING":
            assert time.monotonic() < latest
            time.sleep(0.05)
        return statuses[-1]

    return session, run_task


def progress_and_failure(job):
    """How a worker understands the lines that the program prints."""
    job.clear()
    with open(os.path.join(job.folder, "in/a.0003.ply"), "r+b") as file:
        whole = file.read()
        file.truncate(1000)
    statuses = []
    session, run_task = session_of(job, statuses)
    try:
        ended = run_task("1-4")
    finally:
        session.cleanup()
        with open(os.path.join(job.folder, "in/a.0003.ply"), "wb") as file:
            file.write(whole)
    percent = sorted({status.progress for status in statuses if status.progress is not None})
    check("the worker sees the progress of each frame", percent == [25, 50, 75, 100], percent)
    texts = {status.status_message for status in statuses}
    check("the worker sees what was done", any(text and text.startswith("1 of 4 frames") for text in texts), texts)
    check("the worker sees the failure", ended.state.name == "FAILED" and ended.exit_code == 1, ended)
    check("the worker sees why", "1 failed" in (ended.fail_message or ""), ended)


def bundle(job):
    job.clear()
    job.submit("--to", "deadline-cloud", "--chunk-size", 4, "-o", "bundle")
    path = os.path.join(job.folder, "bundle")
    # On a worker that has the folder elsewhere, and not where the paths of the parameters say.
    elsewhere = os.path.join(os.path.dirname(job.folder), "else where")
    shutil.copytree(os.path.join(job.folder, "in"), os.path.join(elsewhere, "in"))
    shutil.copy(os.path.join(job.folder, "job.yaml"), elsewhere)
    import json

    import yaml

    rules = {"version": "pathmapping-1.0", "path_mapping_rules": [
        {"source_path_format": "POSIX", "source_path": job.folder, "destination_path": elsewhere}]}
    with open(os.path.join(path, "parameter_values.yaml"), encoding="utf-8") as file:
        values = {row["name"]: str(row["value"]) for row in yaml.safe_load(file)["parameterValues"]}
    result = run(*openjd("run", os.path.join(path, "template.yaml"), "-p", json.dumps(values), "--path-mapping-rules",
                         json.dumps(rules)))
    check("the template of the bundle runs in a folder elsewhere", result.returncode == 0, result.stdout)
    out = os.path.join(elsewhere, "out")
    check("its meshes are those of a local run", os.path.isdir(out) and meshes(out) == job.local, result.stdout)
    check("nothing is written to the folder itself", not os.path.exists(job.out), result.stdout)
    return path


def bundle_for_client(job, path):
    from deadline.client.job_bundle.loader import (is_job_bundle_dir, read_yaml_or_json_object,
                                                   validate_directory_symlink_containment)
    from deadline.client.job_bundle.parameters import apply_job_parameters, read_job_bundle_parameters
    from deadline.client.job_bundle.submission import AssetReferences, split_parameter_args

    check("the client takes the folder for a bundle", is_job_bundle_dir(path))
    validate_directory_symlink_containment(path)
    parameters = read_job_bundle_parameters(path)
    references = AssetReferences.from_dict(read_yaml_or_json_object(path, "asset_references", required=True))
    apply_job_parameters([], path, parameters, references)
    _, for_job = split_parameter_args(parameters, path)
    check("the client reads all parameters", for_job == {"Frames": {"string": "1-9"}, "FramesPerTask": {"int": "4"},
                                                         "Folder": {"path": job.folder}}, for_job)
    inputs = {os.path.join(job.folder, "in/a.%04d.ply" % frame) for frame in FRAMES}
    check("the client transfers the inputs",
          references.input_filenames == inputs | {os.path.join(job.folder, "job.yaml")}, references)
    check("every one of them exists", all(map(os.path.isfile, references.input_filenames)), references)
    check("the client fetches the outputs", references.output_directories == {job.out} and
          not references.input_directories, references)
    check("workers get to know where the folder is", references.referenced_paths == {job.folder}, references)


def opencue(job):
    from outline import Outline
    from outline.backend.cue import serialize_simple
    from outline.cuerun import OutlineLauncher
    from outline.modules.shell import Shell

    job.clear()
    outline = Outline("job", shot="shot", show="show", user="user")
    outline.add_layer(Shell("mesh", command=job.submit("--to", "opencue", "--print").strip(), range="1-9", chunk=3))
    spec = serialize_simple(OutlineLauncher(outline))
    layer = xml.etree.ElementTree.fromstring(spec).find("job/layers/layer")
    check("PyOutline makes a layer with this range", layer.findtext("range") == "1-9", spec)
    # Cuebot replaces the token by the frames of a task, then RQD passes the command to a shell.
    for chunk in ("1-3", "4-6", "7-9"):
        must("sh", "-c", layer.findtext("cmd").replace("#FRAMESPEC#", chunk), cwd="/")
    check("the commands of a layer write the meshes of a local run", meshes(job.out) == job.local, os.listdir(job.out))


def main():
    program, venv = os.path.abspath(sys.argv[1]), sys.argv[2]
    run_with(venv, {"openjd": "openjd-cli"})
    lacks_client = run_with(venv, {"deadline": "deadline"}, may_lack=True)
    lacks_outline = run_with(venv, {"outline": "opencue-pyoutline"}, may_lack=True)
    with tempfile.TemporaryDirectory() as folder:
        job = Job(program, os.path.join(os.path.realpath(folder), FOLDER))
        job.submit("--to", "openjd", "--chunk-size", 3)
        run_to_the_end(job)
        run_other_frames(job)
        cancel_and_run_again(job)
        fail_and_repair(job)
        progress_and_failure(job)
        path = bundle(job)
        if lacks_client:
            print("skipped: the bundle is not read by the client of AWS Deadline Cloud: " + lacks_client)
        else:
            bundle_for_client(job, path)
        if lacks_outline:
            print("skipped: the command for OpenCue is not read by PyOutline: " + lacks_outline)
        else:
            opencue(job)
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
