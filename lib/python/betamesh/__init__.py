"""Closed triangle meshes from particles of liquid simulations.

    import betamesh

    particles = betamesh.read_particles("sim/splash.0012.vdb")
    mesh = betamesh.skin(particles, radius="1.5dx")
    betamesh.write_mesh("mesh/splash.0012.ply", mesh)

Arrays are those of numpy. Lengths are in world units and times in seconds. A length may also be text such as "1.5dx",
in particle spacings. What an argument makes impossible raises ValueError, what the system refuses OSError; the message
says what to do. Functions release the lock of the interpreter, may be called from several threads at once, and are
ended by Ctrl-C. Results do not depend on the number of threads.
"""

from __future__ import annotations

import collections.abc
import numbers
import typing

from ._betamesh import (
    Curves,
    Mesh,
    Particles,
    Spheres,
    check,
    coherence,
    measure,
    read_curves,
    read_mesh,
    read_particles,
    simplify,
    spacing,
    version,
    write_mesh,
    write_particles,
    write_spheres,
)
from ._betamesh import skin as _skin
from ._betamesh import skin_plane as _skin_plane

if typing.TYPE_CHECKING:
    import numpy.typing

__all__ = [
    "Curves",
    "Mesh",
    "Particles",
    "Spheres",
    "__version__",
    "check",
    "coherence",
    "measure",
    "read_curves",
    "read_mesh",
    "read_particles",
    "simplify",
    "skin",
    "skin_plane",
    "spacing",
    "version",
    "write_mesh",
    "write_particles",
    "write_spheres",
]

__version__ = version()

Length = typing.Union[float, str]
"""World units, or text such as "1.5dx" in particle spacings."""

Progress = collections.abc.Callable[[str, float], object]
"""Called with the name of the stage in progress and the seconds since the call began."""


def skin(
    positions: Particles | numpy.typing.ArrayLike,
    velocities: numpy.typing.ArrayLike | None = None,
    *,
    radius: Length = "1.5dx",
    spacing: float | str | None = "auto",
    radius_attribute: str = "",
    radius_scale: float = 1,
    radius_rate_attribute: str = "",
    skin: Length = "auto",
    walls: collections.abc.Sequence[str] | str = (),
    box: collections.abc.Sequence[float] | str = "none",
    kind: str = "beta",
    tessellation: str = "complete",
    arc_subdivisions: int | str | None = "auto",
    predicates: str = "exact",
    resolve_intersections: bool = False,
    perturbation_retries: int = 3,
    perturbation_tolerance: float = 1e-5,
    smoothing_method: str = "coherent",
    smoothing_width: Length | None = "auto",
    smoothing_passes: int = 1,
    droplets: str = "mesh",
    droplet_particles: int = 8,
    tendrils: str = "mesh",
    bubbles: str | None = None,
    bubble_gap: Length = "5dx",
    ids: numpy.typing.ArrayLike | None = None,
    attributes: collections.abc.Mapping[str, numpy.typing.ArrayLike] | collections.abc.Sequence[str] | None = None,
    normals: bool | str | None = "auto",
    surface_attributes: collections.abc.Sequence[str] | str = (),
    components: bool = False,
    origin: collections.abc.Sequence[float] | str | None = "auto",
    threads: int | None = None,
    progress: Progress | None = None,
) -> Mesh:
    """The surface of one frame of particles, as a closed, oriented, manifold mesh.

    The settings from `radius` to `bubble_gap`, `normals` and `surface_attributes` are the keys of pipeline files in the
    sections surface, perturbation, smoothing, features and output, with the same defaults and values: `betamesh config
    print` explains them. The same settings give the same bytes as the program.

    Particles
        positions: (n, 3), n >= 0, floating-point or whole numbers, any strides; or Particles, which bring their
            velocities, ids, attributes and origin. No particles give an empty mesh.
        velocities: (n, 3), world units per second; then the mesh has velocities.
        ids: (n,), whole numbers from 0, which spheres carry.
        attributes: arrays by name, (n,) or (n, components). The mesh has them, too: floating-point numbers are averaged
            over nearby particles, whole numbers are those of the nearest one. NaN spreads to the vertices nearby. With
            Particles: the names of those of its attributes that the mesh is to have.
        origin: subtracted from positions in double precision; mesh.vertices + mesh.origin is in their coordinates.
            "auto": zero, unless positions are float64 and single precision would lose them.

    Lengths, in world units or as text such as "1.5dx" in particle spacings
        radius: of the balls. Particles closer than two radii are joined.
        spacing: dx, at which the simulation seeded its particles. "auto" or None: radius / 1.5 if the radius is in
            world units, else measured in this frame. Give all frames of a sequence the same, as from spacing().
        radius_attribute: name of an attribute that, times radius_scale, is each particle's own dx;
            radius_rate_attribute: of one with its change per second. "": all particles are alike.
        skin: distance from the outermost particles to the surface, less than the radius. "auto": the mesh encloses the
            volume of the liquid. "none": the surface of the balls themselves.

    Surface
        walls: planes such as "x>0" or "0.6x+0.8y<2", which tell where the liquid lies. The surface is laid flat against
            them.
        box: six numbers, lowest x, y, z, highest x, y, z: the mesh is cut off there and closed with plane polygons.
        kind: "beta", the liquid surface; "alpha", triangles between particles; "union", the union of balls.
        tessellation: "complete", or "paper".
        arc_subdivisions: segments per arc, 1 to 64; "auto" or None: by accuracy. 1 gives the smallest meshes.
        predicates: "exact", or "float" as in the paper, with perturbation_retries and perturbation_tolerance (radii).
        resolve_intersections: step 4 of the paper, for its tessellation.
        smoothing_method: "coherent", "paper" or "none"; smoothing_width: of the neighbourhood, "auto" or a length;
            smoothing_passes: from 0.
        droplets: "mesh", "points" (into mesh.spheres) or "drop": groups of fewer than droplet_particles.
        tendrils: "mesh" or "points": threads one particle thick.
        bubbles: "fill" or "mesh": voids in which no empty ball of diameter bubble_gap fits. None: "fill", where the
            tessellation allows it.
        normals: fit the normals of vertices to the surface nearby; mesh.normals and the attribute "N". "auto" or None:
            where the tessellation is complete.
        surface_attributes: some of "thickness", "curvature" and "shape" (drop, thread, sheet and bulk, weights with sum
            1), measured on the surface; attributes of the mesh.
        components: number the connected components, for mesh.components.

    The call
        threads: at most this many; None: one for each processor.
        progress: called as progress(stage, seconds), in this thread, when a stage begins and about ten times per
            second. The stages are "spacing", "structure", "tessellate", "smooth" and "velocity". An exception that it
            raises ends the call within a second or two, as Ctrl-C does.

    Warns (UserWarning) of lengths that do not suit the particles and of an origin that was chosen. Raises ValueError
    for impossible settings, arrays of a wrong shape, type or number of rows, and a position or velocity that is not
    finite (with its row); MemoryError.
    """
    settings = _settings(locals(), _KEYS)
    return _skin(positions, velocities, ids, attributes, origin, settings, components, threads, progress)


def skin_plane(
    positions: Particles | numpy.typing.ArrayLike,
    velocities: numpy.typing.ArrayLike | None = None,
    *,
    radius: Length = "1.5dx",
    spacing: float | str | None = "auto",
    radius_attribute: str = "",
    radius_scale: float = 1,
    radius_rate_attribute: str = "",
    skin: Length = "auto",
    kind: str = "beta",
    tessellation: str = "complete",
    arc_subdivisions: int | str | None = "auto",
    smoothing_method: str = "coherent",
    smoothing_width: Length | None = "auto",
    smoothing_passes: int = 1,
    droplets: str = "mesh",
    droplet_particles: int = 8,
    bubbles: str | None = None,
    bubble_gap: Length = "5dx",
    ids: numpy.typing.ArrayLike | None = None,
    attributes: collections.abc.Mapping[str, numpy.typing.ArrayLike] | collections.abc.Sequence[str] | None = None,
    origin: collections.abc.Sequence[float] | str | None = "auto",
    threads: int | None = None,
    progress: Progress | None = None,
) -> Curves:
    """The closed curves around one frame of particles in a plane, with the liquid on their left.

    positions and velocities: (n, 2); or (n, 3), where all particles lie in one plane across an axis, to within a
    hundredth of the spacing. Vertices have three coordinates; those of (n, 2) have z = 0. Everything else is as in
    skin(), with discs for balls: a bubble_gap is the diameter of a disc.
    """
    settings = _settings(locals(), _KEYS)
    return _skin_plane(positions, velocities, ids, attributes, origin, settings, threads, progress)


# Arguments by the key of pipeline files that they set.
_KEYS = {
    "radius": "surface.radius",
    "spacing": "surface.spacing",
    "radius_attribute": "surface.radius_attribute",
    "radius_scale": "surface.radius_scale",
    "radius_rate_attribute": "surface.radius_rate_attribute",
    "skin": "surface.skin",
    "walls": "surface.walls",
    "box": "surface.box",
    "kind": "surface.kind",
    "tessellation": "surface.tessellation",
    "arc_subdivisions": "surface.arc_subdivisions",
    "predicates": "surface.predicates",
    "resolve_intersections": "surface.resolve_intersections",
    "perturbation_retries": "perturbation.retries",
    "perturbation_tolerance": "perturbation.tolerance",
    "smoothing_method": "smoothing.method",
    "smoothing_width": "smoothing.width",
    "smoothing_passes": "smoothing.passes",
    "droplets": "features.droplets",
    "droplet_particles": "features.droplet_particles",
    "tendrils": "features.tendrils",
    "bubbles": "features.bubbles",
    "bubble_gap": "features.bubble_gap",
    "normals": "output.normals",
    "surface_attributes": "output.surface_attributes",
}
_AUTO_IF_NONE = {"spacing", "arc_subdivisions", "smoothing_width", "normals"}


def _settings(arguments: dict[str, object], keys: dict[str, str]) -> list[tuple[str, str, str]]:
    """Rows (argument, key, value as text) of the arguments that are keys of pipeline files."""
    rows = []
    for name, key in keys.items():
        if name not in arguments:
            continue
        value = arguments[name]
        if value is None:
            if name == "bubbles":
                continue
            value = "auto" if name in _AUTO_IF_NONE else "None"
        if name == "box" and not isinstance(value, str):
            value = [repr(float(number)) for number in value]
        rows.append((name, key, _text(value)))
    return rows


def _text(value: object) -> str:
    """A value as in pipeline files: the shortest text that stands for the same number."""
    if isinstance(value, bool) or type(value).__name__ in ("bool_", "bool"):
        return "true" if value else "false"
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        return repr(float(value))
    if isinstance(value, (list, tuple)) and all(isinstance(name, str) for name in value):
        return ",".join(value)
    return str(value)
