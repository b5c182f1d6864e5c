"""Door to MuJoCo: its parser and compiler of MJCF only. The only file that imports mujoco."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from kanefe.errors import FileError, KanefeError, MissingDependency

OLDEST = 4
"""First number of the oldest version of MuJoCo that is read with."""

_UNUSED = (
    "keys",
    "sensors",
    "actuators",
    "tendons",
    "pairs",
    "excludes",
    "skins",
    "flexes",
    "lights",
    "cameras",
    "tuples",
    "texts",
    "numerics",
    "plugins",
)
"""Elements that are not read, in an order of removal in which no remaining element refers to a removed one."""

_FROM_FILES = "meshes", "hfields", "skins", "flexes", "plugins"
"""Elements that may need files, or code, beside the one that is read."""

_OF_SHAPES = ("materials", "textures")
"""Elements of shapes only."""

_OF_JOINTS = "qpos", "qvel", "mpos", "mquat"
"""Attributes of a keyframe for joints and mocap bodies."""

_OF_ACTUATORS = "ctrl", "act"
"""Attributes of a keyframe for actuators."""

_OF_FLEXES = ("plastic",)
"""Attributes of a keyframe for flexes."""

SILENT = {"keys": "keyframes", "sensors": "sensors", "cameras": "cameras", "lights": "lights", "skins": "skins"}
"""Names in `RobotScene.not_taken` of elements that would not change the motion."""

ACTING = {
    "actuators": "actuators",
    "tendons": "tendons",
    "flexes": "flexes",
    "plugins": "plugins",
    "equalities": "equalities of other kinds",
}
"""Names in `RobotScene.not_taken` of elements that would change the motion."""


class CompiledRobot(NamedTuple):
    """A compiled model, and the names of the other elements of the file.

    Attributes
    ----------
    model : mujoco.MjModel
        Angles in rad, defaults resolved, inertia of shapes for bodies without inertia of their own.
    named : dict of str to list of str
        Kind, as the parser calls it -> names of its elements.
    shapes : list of str
        Bodies that have shapes; "world" for the ground.
    key : int, optional
        Number in the model of the keyframe that is asked for.
    controls : list of str
        What that sets of actuators: "ctrl" and "act", where they are not zero.
    """

    model: Any
    named: dict[str, list[str]]
    shapes: list[str]
    key: int | None
    controls: list[str]


def compiled(path: Path, find_key: Callable[[list[str]], int] | None = None) -> CompiledRobot:
    """Return the model of a file without unsupported elements; meshes are read only if inertia needs them.

    Parameters
    ----------
    path : Path
    find_key : callable, optional
        Names of keyframes -> the number of the one to keep, which then has to be valid.

    Raises
    ------
    FileError
        If the parser refuses the file; the message contains that of the parser.
    MissingDependency
        Without mujoco.
    """
    mujoco = _import_mujoco()
    try:
        return _compiled(path, find_key, mujoco)
    except KanefeError:
        raise
    except (ValueError, RuntimeError, mujoco.FatalError) as error:
        remedy = "check the file"
        if "opening file" in str(error):
            remedy = "put the file there; for a mesh: give the body an <inertial>, then no mesh is needed"
        raise FileError(f"MuJoCo's parser refuses {path}: {' '.join(str(error).split())}. Remedy: {remedy}") from error


def with_shapes(path: Path) -> Any:
    """Return the model of a file with all its shapes, to draw them; None where meshes or others are missing."""
    mujoco = _import_mujoco()
    with suppress(ValueError, RuntimeError, mujoco.FatalError), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of what is not read
        return _parsed(path, mujoco).compile()
    return None


def _compiled(path: Path, find_key: Callable[[list[str]], int] | None, mujoco: Any) -> CompiledRobot:
    spec = _parsed(path, mujoco)
    named = {kind: [element.name or "unnamed" for element in getattr(spec, kind, ())] for kind in _UNUSED}
    shapes = list(dict.fromkeys(geom.parent.name or "unnamed" for geom in spec.geoms))
    key = None if find_key is None else find_key([key.name for key in spec.keys])
    controls: list[str] = []
    sizes: dict[str, int] = {}
    if key is not None:
        controls = [what for what in _OF_ACTUATORS if any(getattr(spec.keys[key], what))]
        sizes = {what: len(getattr(spec.keys[key], what)) for what in _OF_JOINTS}
        del named["keys"][key]
    others = _equalities_left(spec, mujoco)
    named["equalities"] = [equality.name or "unnamed" for equality in others]
    _delete(spec, others)
    if not _needs_files(spec):
        with suppress(ValueError, mujoco.FatalError):  # of what is not read: without that it may be right
            model = spec.compile()
            return CompiledRobot(_with_whole_key(model, sizes, path), named, shapes, key, controls)
        spec = _parsed(path, mujoco)
        _delete(spec, _equalities_left(spec, mujoco))
    points = _points_of_flexes(spec, mujoco)
    if key is not None and points:
        raise FileError(
            f"{path} has flexes, of whose points its keyframes have numbers too, and these are not read. Remedy: "
            "give the start of joints by positions"
        )
    _delete_unread(spec, key, points, mujoco)
    model = _with_whole_key(spec.compile(), sizes, path)
    return CompiledRobot(model, named, shapes, None if key is None else 0, controls)


def _delete_unread(spec: Any, key: int | None, points: list[Any], mujoco: Any) -> None:
    """Delete what is not read: elements, keyframes but one, points, shapes without mass, and what only these use."""
    if key is not None:
        for what in (*_OF_ACTUATORS, *_OF_FLEXES):
            setattr(spec.keys[key], what, [])
    for kind in _UNUSED:
        kept = key if kind == "keys" else None
        _delete(spec, [element for i, element in enumerate(getattr(spec, kind, ())) if i != kept])
    _delete(spec, points)
    _delete(spec, list(_shapes_without_mass(spec, mujoco)))
    for marked in (*spec.geoms, *spec.sites, *spec.meshes):
        marked.material = ""
    for kind in _OF_SHAPES:
        _delete(spec, getattr(spec, kind))
    used = {geom.meshname for geom in spec.geoms} | {geom.hfieldname for geom in spec.geoms}
    _delete(spec, [mesh for mesh in (*spec.meshes, *spec.hfields) if mesh.name not in used])


def _parsed(path: Path, mujoco: Any) -> Any:
    spec = mujoco.MjSpec.from_file(str(path))
    spec.compiler.fusestatic = False
    return spec


def _equalities_left(spec: Any, mujoco: Any) -> list[Any]:
    """Return the equalities of kinds that are not read."""
    kind = mujoco.mjtEq
    taken = kind.mjEQ_CONNECT, kind.mjEQ_WELD, kind.mjEQ_JOINT
    return [held for held in spec.equalities if held.type not in taken]


def _points_of_flexes(spec: Any, mujoco: Any) -> list[Any]:
    """Return the bodies that are no more than a point of a flex: they slide, and have neither shapes nor children."""
    names = {name for flex in spec.flexes for name in (*flex.vertbody, *flex.nodebody)}
    return [
        body
        for body in (spec.body(name) for name in sorted(names))
        if body is not None
        and len(body.joints)
        and all(joint.type == mujoco.mjtJoint.mjJNT_SLIDE for joint in body.joints)
        and not (len(body.geoms) or len(body.bodies) or len(body.sites))
    ]


def _needs_files(spec: Any) -> bool:
    """Return whether something in it may need more than itself: then what is not read is removed, one by one.

    Each removal takes the parser a time that grows with the whole model.
    """
    of_textures = (texture.file or any(texture.cubefiles) for texture in spec.textures)
    return any(len(getattr(spec, kind, ())) for kind in _FROM_FILES) or any(of_textures)


def _shapes_without_mass(spec: Any, mujoco: Any) -> Iterator[Any]:
    """Yield the shapes that contribute no inertia: those of the ground, and of bodies with their own inertia."""
    from_shapes = spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    for body in spec.bodies:
        is_ground = body.name == "world" and body is spec.bodies[0]
        if is_ground or (body.explicitinertial and not from_shapes):
            yield from body.geoms


def _with_whole_key(model: Any, sizes: dict[str, int], path: Path) -> Any:
    """Return a model; raise a FileError where its keyframe has too few numbers, which the parser fills up silently."""
    right = {"qpos": model.nq, "qvel": model.nv, "mpos": 3 * model.nmocap, "mquat": 4 * model.nmocap}
    for what, size in sizes.items():
        if size not in (0, right[what]):
            raise FileError(
                f"{what} of the keyframe of {path} has {size} numbers, and the model has {right[what]}. Remedy: "
                f"give {right[what]} numbers, or none for the start of the file"
            )
    return model


def _delete(spec: Any, elements: Any) -> None:
    for element in list(elements):
        spec.delete(element)


def _import_mujoco() -> Any:
    try:
        import mujoco
    except ImportError as problem:  # mujoco itself, or what it needs in turn
        missing = (problem.name or "mujoco").partition(".")[0]
        raise MissingDependency(missing, "read_mjcf", "pip install 'kanefe[robots]'") from problem
    if int(mujoco.__version__.partition(".")[0]) < OLDEST:  # without polynomials of springs and dampers
        wanted = f"mujoco {OLDEST}.0 or newer ({mujoco.__version__} is here)"
        raise MissingDependency(wanted, "read_mjcf", "pip install -U 'kanefe[robots]'")
    return mujoco
