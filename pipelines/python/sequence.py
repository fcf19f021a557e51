#!/usr/bin/env python3
"""Meshes a sequence of particle files, several frames at once.

    python3 sequence.py 'sim/splash.*.vdb' mesh
    python3 sequence.py 'sim/splash.*.vdb' mesh --extension .bgeo --radius 2dx --attribute temperature

Frames whose mesh exists are left out, so that an interrupted run can be continued. For farms, resume after changes of
the settings and reports, use the program: `betamesh run`.
"""

import argparse
import concurrent.futures
import glob
import pathlib
import re
import sys

import betamesh


def frame_number(path):
    """12 of splash.0012.vdb; None without a number."""
    found = re.search(r"(-?\d+)\.[^.]*$", path.name)
    return int(found[1]) if found else None


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("particles", help="pattern of particle files, in quotes")
    parser.add_argument("folder", type=pathlib.Path, help="for the meshes")
    parser.add_argument("--extension", default=".usda", help="format of the meshes (default: %(default)s)")
    parser.add_argument("--radius", default="1.5dx", help="world units, or particle spacings as in 1.5dx")
    parser.add_argument("--spacing", type=float, help="world units (default: measured in three frames)")
    parser.add_argument("--attribute", action="append", default=[], help="to transfer to the mesh; repeat for more")
    parser.add_argument("--at-once", type=int, default=2, help="frames at once (default: %(default)s)")
    arguments = parser.parse_args()

    files = [pathlib.Path(name) for name in sorted(glob.glob(arguments.particles))]
    if not files:
        sys.exit("no file matches %s" % arguments.particles)
    arguments.folder.mkdir(parents=True, exist_ok=True)

    # All frames get the same spacing: a radius that changes from frame to frame would make the surface jump. The
    # origin, too, is that of the first frame.
    first = betamesh.read_particles(files[0])
    typical = {files[0], files[len(files) // 2], files[-1]}
    spacing = arguments.spacing or betamesh.spacing(*map(betamesh.read_particles, sorted(typical)))
    print("spacing %.6g, radius %s" % (spacing, arguments.radius))

    def mesh_frame(file):
        output = arguments.folder / (file.stem + arguments.extension)
        if output.exists():
            return "%s exists" % output
        particles = betamesh.read_particles(file, origin=first.origin)
        mesh = betamesh.skin(particles, radius=arguments.radius, spacing=spacing, attributes=arguments.attribute)
        betamesh.write_mesh(output, mesh, frame=frame_number(file))
        return "%s: %d triangles, volume %.6g" % (output, len(mesh.triangles), betamesh.measure(mesh)["volume"])

    failures = 0
    with concurrent.futures.ThreadPoolExecutor(arguments.at_once) as pool:
        frames = {pool.submit(mesh_frame, file): file for file in files}
        for frame in concurrent.futures.as_completed(frames):
            try:
                print(frame.result())
            except (ValueError, OSError) as error:
                failures += 1
                print("%s failed: %s" % (frames[frame], error), file=sys.stderr)
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
