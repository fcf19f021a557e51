# SPDX-License-Identifier: Apache-2.0
"""Plays a sequence of meshes of a liquid (.ply, .bgeo, .vtp) on Blender's timeline, with velocities for motion blur.

File > Import > betamesh Sequence makes an object whose mesh is replaced on every frame change by that of the
frame's file. The settings are in Properties > Object Data > betamesh Sequence. They belong to the mesh, so linked
duplicates of the object follow. Only the settings and the mesh of the current frame are saved in the .blend file.

Cycles blurs a mesh by its point attribute `velocity`, in units per second, so that the number of vertices may change
from frame to frame. Between frames (shutters that open or close on the frame, slow motion), the mesh of the nearest
frame is displaced along its velocities.
"""

import math
import os
import re
import sys
from dataclasses import dataclass

import bpy
import numpy as np
from bpy.app.handlers import persistent
from bpy.props import BoolProperty, EnumProperty, IntProperty, PointerProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from .geometry import FileError, Geometry
from .houdini import read_bgeo
from .ply import read_ply
from .vtp import read_vtp

# ---------------------------------------------------------------------------------------------------------------------
# Reading files

READERS = {".ply": read_ply, ".bgeo": read_bgeo, ".bgeo.gz": read_bgeo, ".vtp": read_vtp}


def read_geometry(path: str) -> Geometry:
    """Reads a file in the format of its extension. Raises FileError."""
    for extension, read in READERS.items():
        if path.lower().endswith(extension):
            return read(path)
    raise FileError(f"{path}: the name has to end in one of {', '.join(READERS)}")


# ---------------------------------------------------------------------------------------------------------------------
# Filling Blender's meshes

# Attributes that are rotated with the mesh, as betamesh does with `--up-axis` and `--output-up-axis`.
DIRECTIONS = {"accel", "acceleration", "N", "normal", "normals"}
COLOURS = {"Cd", "color", "colour"}


def fill_mesh(mesh: bpy.types.Mesh, geometry: Geometry, up_axis: str) -> None:
    """Replaces points, faces and attributes. Materials, and everything that belongs to objects, stay."""

    def rotated(vectors: np.ndarray) -> np.ndarray:  # into Blender's axes
        return np.stack([vectors[:, 0], -vectors[:, 2], vectors[:, 1]], axis=1) if up_axis == "Y" else vectors

    mesh.clear_geometry()
    mesh.vertices.add(len(geometry.positions))
    mesh.loops.add(len(geometry.corners))
    mesh.polygons.add(len(geometry.face_starts))
    if len(geometry.positions):
        set_values(mesh.attributes["position"].data, "vector", rotated(geometry.positions))
    if len(geometry.corners):  # faster than through mesh.loops
        set_values(mesh.attributes[".corner_vert"].data, "value", geometry.corners)
        set_values(mesh.polygons, "loop_start", geometry.face_starts)
    mesh.update(calc_edges=True)
    if repeats_vertices(geometry):
        mesh.validate()
    mesh.shade_smooth()

    if geometry.velocities is not None:
        add_attribute(mesh, "velocity", rotated(geometry.velocities), "POINT")
    for name, values in geometry.point_attributes.items():
        add_attribute(mesh, name, rotated(values) if name in DIRECTIONS and values.ndim == 2 else values, "POINT")
    for name, values in geometry.face_attributes.items():
        if len(values) == len(mesh.polygons):  # else faces were invalid
            add_attribute(mesh, name, values, "FACE")
    if geometry.normals is not None and len(mesh.polygons):
        mesh.normals_split_custom_set_from_vertices(rotated(geometry.normals))


def set_values(collection: bpy.types.bpy_prop_collection, name: str, values: np.ndarray) -> None:
    collection.foreach_set(name, np.ascontiguousarray(values).reshape(-1))


def repeats_vertices(geometry: Geometry) -> bool:
    """True if a triangle has a vertex twice, or if there are other faces than triangles, which are not examined."""
    if len(geometry.corners) != 3 * len(geometry.face_starts):
        return True
    a, b, c = geometry.corners.reshape(-1, 3).T
    return bool(((a == b) | (b == c) | (c == a)).any())


def add_attribute(mesh: bpy.types.Mesh, name: str, values: np.ndarray, domain: str) -> None:
    """Keeps the kind of numbers. Four real numbers, and those named as colours, become a colour."""
    if values.dtype.kind == "f" or values.dtype.itemsize > 2 and not fits_int32(values):
        values = values.astype(np.float32)
        size = 1 if values.ndim == 1 else values.shape[1]
        if size == 3 and name in COLOURS:
            values, size = np.column_stack([values, np.ones(len(values), np.float32)]), 4
        kind, member = {1: ("FLOAT", "value"), 2: ("FLOAT2", "vector"), 3: ("FLOAT_VECTOR", "vector"),
                        4: ("FLOAT_COLOR", "color")}[size]
    else:
        kind, member = ("INT8" if values.dtype == np.int8 else "INT"), "value"
        values = values.astype(np.int8 if kind == "INT8" else np.int32)
    attribute = mesh.attributes.new(name, kind, domain)
    if not attribute:  # the name is too long, or Blender needs it, such as material_index
        attribute = mesh.attributes.new(f"{name[:40]}_", kind, domain)
    set_values(attribute.data, member, values)
    if kind == "FLOAT_COLOR" and not mesh.color_attributes.active_color:
        mesh.color_attributes.active_color_name = attribute.name
        mesh.color_attributes.render_color_index = 0


def fits_int32(values: np.ndarray) -> bool:
    return not len(values) or (int(values.min()) >= -(2**31) and int(values.max()) < 2**31)


# ---------------------------------------------------------------------------------------------------------------------
# Names of the files of a sequence


@dataclass
class SequenceName:
    """`folder/dam.####.ply`: as many `#` as the frame number has digits at least, in the name of the file."""

    before: str
    digits: int
    after: str

    @staticmethod
    def of_pattern(pattern: str) -> "SequenceName | None":
        folder, name = os.path.split(pattern)
        match = re.fullmatch(r"([^#]*)(#+)([^#]*)", name)
        return match and SequenceName(os.path.join(folder, match[1]), len(match[2]), match[3])

    @staticmethod
    def of_file(path: str) -> "SequenceName | None":
        """The sequence of a file, whose frame is the last number in its name. A minus after a letter is a hyphen."""
        folder, name = os.path.split(path)
        match = re.fullmatch(r"(.*?)((?<![A-Za-z0-9])-)?(\d+)(\D*)", name)
        if not match:
            return None
        sequence = SequenceName(os.path.join(folder, match[1]), len(match[3]), match[4])
        # 1001 may be padded to one, two, three or four digits: the other files tell.
        numbers = sequence.numbers_on_disk()
        padded = [number for number in numbers if number[0] == "0" and len(number) > 1]
        sequence.digits = min(map(len, padded or numbers))
        return sequence

    def pattern(self) -> str:
        return f"{self.before}{'#' * self.digits}{self.after}"

    def path(self, frame: int) -> str:
        return f"{self.before}{'-' if frame < 0 else ''}{abs(frame):0{self.digits}d}{self.after}"

    def numbers_on_disk(self) -> list[str]:
        """The digits in the names of all files that differ from this name only in the frame number."""
        folder, before = os.path.split(self.before)
        name = re.compile(re.escape(before) + r"-?(\d+)" + re.escape(self.after))
        return [match[1] for file in os.listdir(folder or ".") if (match := name.fullmatch(file))]

    def frames_on_disk(self) -> list[int]:
        frames = {int(number) * sign for number in self.numbers_on_disk() for sign in (1, -1)}
        return sorted(frame for frame in frames if os.path.exists(self.path(frame)))


# ---------------------------------------------------------------------------------------------------------------------
# Showing a frame

# Blender ignores what scripts write into data that is linked from another file.
LINKED = "linked meshes do not follow the frames; make this one local (Object > Relations > Make Local > All)"


def sequence_of(mesh: bpy.types.Mesh) -> SequenceName:
    pattern = mesh.betamesh_sequence.pattern
    sequence = SequenceName.of_pattern(bpy.path.abspath(pattern))
    if not sequence:
        raise FileError(f"{pattern}: the name of the file needs one group of #, such as ####, for the frame number")
    return sequence


def show_frame(mesh: bpy.types.Mesh, scene: bpy.types.Scene) -> None:
    """Fills the mesh with that of the scene's frame, unless it shows that already. Errors are kept in the settings."""
    if mesh.is_editmode:
        return
    if mesh.library:
        print(f"betamesh Sequence: '{mesh.name}': {LINKED}", file=sys.stderr)
        return
    settings: SequenceSettings = mesh.betamesh_sequence
    time = scene.frame_current + scene.frame_subframe - settings.frame_offset  # in frames of the files
    frame = math.ceil(time - 0.5)  # the nearest one
    seconds = (time - frame) * scene.render.fps_base / scene.render.fps
    held = settings.hold and not settings.first_frame <= frame <= settings.last_frame
    if held:
        frame, seconds = min(max(frame, settings.first_frame), settings.last_frame), 0.0

    geometry, shown, error = Geometry(np.zeros((0, 3), np.float32)), "", ""
    try:
        path = sequence_of(mesh).path(frame)
        if not os.path.isdir(os.path.dirname(path)):
            raise FileError(f"{os.path.dirname(path)}: there is no such folder")
        if settings.first_frame <= frame <= settings.last_frame and os.path.exists(path):
            shown = f"{path} {os.stat(path).st_mtime_ns} {seconds} {held} {settings.up_axis}"
            if shown == settings.shown:
                return
            geometry = read_geometry(path)
    except (FileError, OSError) as problem:
        error = str(problem)
        print(f"betamesh Sequence: frame {scene.frame_current} of '{mesh.name}': {error}", file=sys.stderr)
    if geometry.velocities is not None:
        geometry.velocities = geometry.velocities * (0 if held else 1)
        geometry.positions = geometry.positions + geometry.velocities * np.float32(seconds)
    fill_mesh(mesh, geometry, settings.up_axis)
    settings.shown, settings.error = shown, error
    mesh.update_tag()


@persistent
def show_frames(scene: bpy.types.Scene, *_: object) -> None:
    """Shows the scene's frame in every mesh that is a sequence; a handler of frame changes."""
    for mesh in bpy.data.meshes:
        if mesh.betamesh_sequence.pattern:
            show_frame(mesh, scene)


@persistent
def show_frames_after_loading(*_: object) -> None:
    """The files may have changed since the .blend file was saved."""
    show_frames(bpy.context.scene)


# ---------------------------------------------------------------------------------------------------------------------
# Settings, operators and panel


def settings_changed(settings: "SequenceSettings", context: bpy.types.Context) -> None:
    if settings.pattern:
        show_frame(settings.id_data, context.scene)


UP_AXES = [("Y", "Y", "betamesh's default: the file's y becomes Blender's z, and its z points to the front"),
           ("Z", "Z", "Nothing is rotated: files written with --output-up-axis z")]

# Blender 5.0 warns of // in properties without this option, which older versions do not know.
RELATIVE = {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (5, 0, 0) else set()


class SequenceSettings(bpy.types.PropertyGroup):
    """Which files a mesh shows. A mesh without a pattern is not a sequence."""

    pattern: StringProperty(
        name="Files", subtype="FILE_PATH", options=RELATIVE, update=settings_changed,
        description="Path of the files, with # for each digit of the frame number. // is the folder of the .blend file")
    up_axis: EnumProperty(
        name="Up Axis", items=UP_AXES, update=settings_changed, description="Axis that points up in the files")
    frame_offset: IntProperty(
        name="Frame Offset", update=settings_changed,
        description="Subtracted from the scene's frame to get the frame of the file")
    hold: BoolProperty(
        name="Hold Ends", update=settings_changed,
        description="Before the first and after the last frame of the files, show that frame, at rest. Off: nothing")
    first_frame: IntProperty(name="First Frame", update=settings_changed, description="First frame of the files used")
    last_frame: IntProperty(name="Last Frame", update=settings_changed, description="Last frame of the files used")
    shown: StringProperty(options={"HIDDEN"}, description="What the mesh contains; empty if no file")
    error: StringProperty(options={"HIDDEN"}, description="Why the file of the current frame could not be read")


class ImportSequence(bpy.types.Operator, ImportHelper):
    """Adds an object that shows a sequence of meshes, one for each frame, with velocities for motion blur"""

    bl_idname = "import_mesh.betamesh_sequence"
    bl_label = "Import betamesh Sequence"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".ply"
    filter_glob: StringProperty(default=";".join("*" + extension for extension in READERS), options={"HIDDEN"})
    up_axis: EnumProperty(name="Up Axis", items=UP_AXES, description="Axis that points up in the files")
    frame_offset: IntProperty(
        name="Frame Offset", description="Subtracted from the scene's frame to get the frame of the file")
    hold: BoolProperty(
        name="Hold Ends",
        description="Before the first and after the last frame of the files, show that frame, at rest. Off: nothing")
    relative_path: BoolProperty(
        name="Relative Path", default=True, description="Store the path relative to the .blend file, if that is saved")

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            read_geometry(self.filepath)
            sequence = SequenceName.of_file(self.filepath)
            if not sequence:
                raise FileError(f"{self.filepath}: the name has no frame number. Expected one such as dam.0001.ply")
            frames = sequence.frames_on_disk()
        except (FileError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}

        name = os.path.basename(sequence.before).rstrip("._- ") or "betamesh"
        mesh = bpy.data.meshes.new(name)
        settings: SequenceSettings = mesh.betamesh_sequence
        settings.up_axis, settings.frame_offset, settings.hold = self.up_axis, self.frame_offset, self.hold
        settings.first_frame, settings.last_frame = min(frames), max(frames)
        pattern = sequence.pattern()
        settings.pattern = bpy.path.relpath(pattern) if self.relative_path and bpy.data.filepath else pattern

        obj = bpy.data.objects.new(name, mesh)
        context.collection.objects.link(obj)
        for selected in context.selected_objects:
            selected.select_set(False)
        obj.select_set(True)
        context.view_layer.objects.active = obj
        # Blender's manual: handlers that change data during a render require a locked interface.
        context.scene.render.use_lock_interface = True
        missing = max(frames) - min(frames) + 1 - len(frames)
        self.report({"INFO"}, f"Frames {min(frames)} to {max(frames)}, {missing or 'none'} missing")
        return {"FINISHED"}


class ReloadSequence(bpy.types.Operator):
    """Searches the folder for new frames, and reads the current one again"""

    bl_idname = "mesh.betamesh_sequence_reload"
    bl_label = "Reload"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.object and context.object.type == "MESH" and context.object.data.betamesh_sequence.pattern

    def execute(self, context: bpy.types.Context) -> set[str]:
        mesh = context.object.data
        settings: SequenceSettings = mesh.betamesh_sequence
        try:
            frames = sequence_of(mesh).frames_on_disk()
            if not frames:
                raise FileError(f"{settings.pattern}: there are no such files")
        except (FileError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        settings.shown = ""
        settings.first_frame, settings.last_frame = frames[0], frames[-1]
        if settings.error:
            self.report({"ERROR"}, settings.error)
        return {"FINISHED"}


class SequencePanel(bpy.types.Panel):
    bl_label = "betamesh Sequence"
    bl_idname = "DATA_PT_betamesh_sequence"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "data"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return ReloadSequence.poll(context)

    def draw(self, context: bpy.types.Context) -> None:
        settings: SequenceSettings = context.object.data.betamesh_sequence
        layout = self.layout
        layout.use_property_split = True
        layout.prop(settings, "pattern")
        layout.prop(settings, "up_axis")
        layout.prop(settings, "frame_offset")
        column = layout.column(align=True)
        column.prop(settings, "first_frame")
        column.prop(settings, "last_frame", text="Last")
        layout.prop(settings, "hold")
        layout.operator(ReloadSequence.bl_idname, icon="FILE_REFRESH")
        if context.object.data.library:
            layout.label(text=LINKED, icon="ERROR")
        elif settings.error:
            layout.label(text=settings.error, icon="ERROR")
        elif not settings.shown:
            layout.label(text="There is no file for this frame", icon="INFO")


def add_to_import_menu(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    menu.layout.operator(ImportSequence.bl_idname, text="betamesh Sequence (.ply, .bgeo, .vtp)")


CLASSES = (SequenceSettings, ImportSequence, ReloadSequence, SequencePanel)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Mesh.betamesh_sequence = PointerProperty(type=SequenceSettings)
    bpy.types.TOPBAR_MT_file_import.append(add_to_import_menu)
    bpy.app.handlers.frame_change_pre.append(show_frames)
    bpy.app.handlers.load_post.append(show_frames_after_loading)


def unregister() -> None:
    bpy.app.handlers.load_post.remove(show_frames_after_loading)
    bpy.app.handlers.frame_change_pre.remove(show_frames)
    bpy.types.TOPBAR_MT_file_import.remove(add_to_import_menu)
    del bpy.types.Mesh.betamesh_sequence
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
