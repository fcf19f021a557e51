#!/usr/bin/env python3
"""Level sets that the program writes, turned into meshes by vdb_tool and compared with the meshes that they are from.

usage: level_set_reads.py PROGRAM
exit:  0 all agree, 1 some differ, 77 skipped (there is no vdb_tool)
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile


def check(what, good):
    print("%-70s %s" % (what, "right" if good else "WRONG"))
    return 0 if good else 1


def main():
    program = os.path.abspath(sys.argv[1])
    if shutil.which("vdb_tool") is None:
        print("skipped: there is no vdb_tool, which the Debian package libopenvdb-tools has")
        return 77
    failures = 0
    with tempfile.TemporaryDirectory() as folder:

        def run(*words):
            return subprocess.run(words, cwd=folder, check=True, stderr=subprocess.DEVNULL,
                                  stdout=subprocess.PIPE).stdout.decode()

        run(program, "sample", "drop", "p.ply", "--particles", "4000", "--frames", "1", "--seed", "7")
        run(program, "mesh", "p.ply", "m.ply", "--json")
        with open(os.path.join(folder, "m.ply.json")) as file:
            report = json.load(file)
        voxel = report["spacing"] / 2
        run(program, "mesh", "p.ply", "m.vdb", "--velocity-grid")
        info = json.loads(run(program, "info", "--json", "m.vdb"))
        volumes = {volume["name"]: volume for volume in info["volumes"]}
        failures += check("info: a level set and a velocity grid of half a spacing",
                          info["kind"] == "volumes" and volumes["surface"]["kind"] == "level set" and
                          volumes["v"]["type"] == "vec3s" and abs(volumes["surface"]["voxel"] - voxel) < 1e-6 * voxel)
        listed = run("vdb_print", "-l", "m.vdb")
        failures += check("vdb_print: class level set", "level set" in listed)
        run(program, "mesh", "p.ply", "s.vdb")
        run("vdb_tool", "-read", "s.vdb", "-ls2mesh", "-write", "back.ply")
        jump = json.loads(run(program, "coherence", "--json", "m.ply", "back.ply").splitlines()[0])
        # The rest of the area is where the surface bends within a voxel.
        failures += check("vdb_tool: 99.9 % of the area within half a voxel", 0 < jump["quantile_999"] < 0.5 * voxel)
        failures += check("vdb_tool: the mesh within a voxel", jump["max"] < voxel)
        run(program, "convert", "m.ply", "c.vdb", "--voxel", str(report["spacing"] / 4), "--band", "5")
        info = json.loads(run(program, "info", "--json", "c.vdb"))
        failures += check("convert: voxels as asked for",
                          abs(info["volumes"][0]["voxel"] - report["spacing"] / 4) < 1e-6 * voxel)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
