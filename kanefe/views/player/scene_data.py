"""Data of a run for the browser: moving frames, fixed parts, and arrows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import rotation_matrix
from kanefe.results.body_shape import BodyShape
from kanefe.results.load_lines import LoadLine
from kanefe.results.reader import Reader
from kanefe.results.surface_outline import SurfaceOutline
from kanefe.views.player.arrays import Arrays, quantised
from kanefe.views.player.boxes import SMALLEST, TRIANGLES, box_of, is_inside
from kanefe.views.player.creases import shaded
from kanefe.views.player.drawn_modes import StressField, drawn_modes, largest_values
from kanefe.views.player.room import room_of
from kanefe.views.player.skins import Skin, skin_of
from kanefe.views.player.tracks import GROUND, Tracks, up_axis
from kanefe.views.relief import relief

BEYOND = 1.3
"""Side of the square that represents a plane, relative to the size of the space that a run takes."""

ON_BODY = 1.5
"""Side of the square that represents a plane on a body with a box, relative to the size of the box."""


class SceneData:
    """Data of a run for the browser, with its arrays.

    Parameters
    ----------
    result : Reader
    frames : ndarray of int, shape (S,)
        The output times shown, by number.
    stresses : dict of str to StressField
        By body.
    forces : bool
        Whether reactions of joints are shown as well as forces of contacts.

    Attributes
    ----------
    content : dict
        The scene in types of JSON; arrays are given by their places in `arrays`.
    arrays : Arrays
    stressed, beams_stressed : set of str
        Bodies with stress, and those among them that are made of beams.
    mesh_error : float
        Of the largest stress that is shown, relative to it; NaN: not known.
    """

    def __init__(
        self, result: Reader, frames: np.ndarray, stresses: Mapping[str, StressField], forces: bool = False
    ) -> None:
        self.result, self.frames, self.arrays = result, frames, Arrays()
        self.tracks = Tracks(result, frames)
        self._shapes = [result.body(name) for name in result.bodies]
        self._skins = {shape.name: skin_of(shape) for shape in self._shapes if shape.is_flexible}
        lines = result.load_lines(frames)
        room = room_of(result, self.tracks, self._skins, lines)
        self.size, self.reach = room.size, room.box.size or 1.0
        self.origin = np.round(0.5 * (room.box.low + room.box.high), 6)
        self._boxes = {
            shape.name: box_of(shape, self._on(shape.name), SMALLEST * self.size)
            for shape in self._shapes
            if shape.mass > 0.0 and not shape.is_flexible
        }
        self.largest, self.mesh_error = {"displacement": 0.0, "stress": 0.0}, np.nan
        self.stressed = {name for name in stresses if name in self._skins}
        self.beams_stressed = {name for name in self.stressed if self._skins[name].fibres}
        bodies = self._joined([self._body(shape, stresses.get(shape.name)) for shape in self._shapes])
        if fixed := [self._surface(surface) for surface in self._on("")]:
            bodies.append({"name": "ground", "frame": GROUND, "kind": "ground", "parts": fixed})
        arrows = [*self._contacts(), *(self._reactions() if forces else ())]
        self.content: dict[str, Any] = {
            "times": self.arrays.add(result.times[frames].astype(np.float64)),
            "frames": [
                {"p": self._places(place), "e": self.arrays.add(turn.astype(np.float32))}
                for place, turn in self.tracks.poses
            ],
            "bodies": bodies,
            "arrows": arrows,
            "links": [self._line(line) for line in lines],
            "largest": self.largest,
            "size": self.size,
            "reach": self.reach,
            "origin": self.origin.tolist(),
            "low": (room.box.low - self.origin).tolist(),
            "high": (room.box.high - self.origin).tolist(),
            "up": up_axis(result),
        }
        if room.path is not None and room.about is not None:
            about = {"low": room.about.low.tolist(), "high": room.about.high.tolist()}
            self.content["travel"] = about | {"p": self._places(room.path)}

    def _line(self, line: LoadLine) -> dict[str, Any]:
        found = {"name": line.name, "p": self._places(line.points.reshape(len(line.points), -1, 3))}
        return found | ({"states": self.arrays.add(line.states)} if line.states.any() else {})

    def _on(self, body: str) -> list[SurfaceOutline]:
        """Return the surfaces of a body; "" is the ground."""
        return [surface for surface in self.result.surfaces if surface.body == body]

    def _places(self, places: np.ndarray) -> dict[str, Any]:
        """Add points (S, ..., 3) in N relative to the middle of the scene, where single precision is enough."""
        return self.arrays.add((places - self.origin).astype(np.float32))

    def _body(self, shape: BodyShape, stress: StressField | None) -> dict[str, Any]:
        frame = self.tracks.number(shape.name)
        found: dict[str, Any] = {"name": shape.name, "frame": frame}
        parts = [self._surface(surface) for surface in self._on(shape.name)]
        if shape.is_flexible:
            return found | {"kind": "flexible", "parts": [self._flexible(shape, stress), *parts]}
        if shape.mass <= 0.0:
            return found | {"kind": "frame", "parts": parts}
        box = self._boxes[shape.name]
        if box is not None:
            parts.insert(0, self._part(frame, box, TRIANGLES) | {"is_glass": self._holds_others(shape.name, box)})
            if float(np.linalg.norm(shape.com)) > 0.5 * float(np.linalg.norm(np.ptp(box, axis=0))):
                found["stick"] = shape.com.tolist()  # from the joint to the box
        return found | {"kind": "rigid", "parts": parts}

    def _joined(self, bodies: list[dict[str, Any]]) -> list[dict[str, Any]]:
        """Return the bodies, with the segments of a segmented body as its parts, those of its base first."""
        of = {part: whole for whole, parts in self.result.segmented.items() for part in parts}
        found: dict[str, dict[str, Any]] = {}
        for body in bodies:
            name = of.get(body["name"], body["name"])
            if name in found:
                found[name]["parts"] = [*found[name]["parts"], *body["parts"]]
            else:
                found[name] = body | {"name": name}
        return list(found.values())

    def _holds_others(self, name: str, box: np.ndarray) -> bool:
        """Return whether the centre of another body is inside a box at the start of the run."""
        corners = self.tracks.placed(self.tracks.number(name), box)
        points = [
            self.tracks.placed(self.tracks.number(other.name), other.com[None])
            for other in self._shapes
            if other.name != name and other.mass > 0.0
        ]
        return bool(points) and is_inside(corners, np.vstack(points))

    def _surface(self, surface: SurfaceOutline) -> dict[str, Any]:
        frame = self.tracks.number(surface.body, surface.interface)
        vertices = self._square(surface, frame) if surface.is_endless else surface.vertices
        offset = self.origin if frame == GROUND else np.zeros(3)
        part = self._part(frame, vertices - offset, surface.triangles)
        if len(surface.lines):
            shades = np.round(255.0 * relief(surface)).astype(np.uint8)
            part |= {"grid": self.arrays.add(surface.lines.astype(np.uint32)), "shades": self.arrays.add(shades)}
        return part | {"surface": surface.name, "is_endless": surface.is_endless}

    def _square(self, surface: SurfaceOutline, frame: int) -> np.ndarray:
        """Return the square that represents a plane, below the middle of the scene or of the box of its body."""
        vertices, middle = surface.vertices, surface.vertices.mean(axis=0)
        normal = np.cross(vertices[1] - vertices[0], vertices[2] - vertices[0])
        box = self._boxes.get(surface.body)
        if box is not None:
            seen, side = box.mean(axis=0), ON_BODY * float(np.linalg.norm(np.ptp(box, axis=0)))
        elif frame == GROUND:
            seen, side = self.origin, BEYOND * self.reach
        else:
            place, turn = self.tracks.poses[frame]
            others = np.mean([poses[0][0] for poses in self.tracks.poses], axis=0)
            seen, side = rotation_matrix(turn[0]).T @ (others - place[0]), BEYOND * self.reach
        return np.asarray(seen - normal * (normal @ (seen - middle)) + side * (vertices - middle))

    def _part(
        self, frame: int, points: np.ndarray, triangles: np.ndarray, creases: np.ndarray | None = None
    ) -> dict[str, Any]:
        """Return the data of a surface: points (p, 3) in a frame, triangles and sharp edges."""
        split = shaded(points, triangles)
        return {
            "frame": frame,
            "points": self.arrays.add(points.astype(np.float32)),
            "vertices": self.arrays.add(split.points.astype(np.uint32)),
            "triangles": self.arrays.add(split.triangles.astype(np.uint32)),
            "creases": self.arrays.add((split.creases if creases is None else creases).astype(np.uint32)),
        }

    def _flexible(self, shape: BodyShape, stress: StressField | None) -> dict[str, Any]:
        skin: Skin = self._skins[shape.name]
        eta = self.result.modal_coordinates(shape.name)[self.frames]
        modes = drawn_modes(shape, skin, eta, stress)
        moved, pressed, row = largest_values(modes)
        if stress is not None and pressed > self.largest["stress"]:
            self.mesh_error = stress.mesh_error_of(eta[row])
        self.largest = {k: max(v, self.largest[k]) for k, v in (("displacement", moved), ("stress", pressed))}
        shapes, factors = quantised(modes.shapes)
        part = self._part(self.tracks.number(shape.name), skin.points, skin.triangles, skin.creases) | {
            "lines": self.arrays.add(skin.lines.astype(np.uint32)),
            "modes": self.arrays.add(shapes),
            "factors": self.arrays.add(factors),
            "amplitudes": self.arrays.add(modes.amplitudes.astype(np.float32)),
        }
        if modes.stresses is not None:
            bare = np.isnan(modes.stresses).any(axis=(0, 2))
            stresses, factors = quantised(np.nan_to_num(modes.stresses))
            part |= {
                "stresses": self.arrays.add(stresses),
                "stress_factors": self.arrays.add(factors),
                "bare": self.arrays.add(bare.astype(np.uint8)),
            }
        return part

    def _contacts(self) -> Iterable[dict[str, Any]]:
        for name in self.result.contacts:
            contact = self.result.contact(name)
            yield self._arrow(name, "contact", contact.point[self.frames], contact.force[self.frames])

    def _reactions(self) -> Iterable[dict[str, Any]]:
        """Yield the force of each joint on its body, unless it is always zero."""
        if not self.result.has_forces:
            raise ModelError(
                "the result was saved without forces, so that they cannot be shown. Remedy: forces=False, or run again"
            )
        for shape in self._shapes:
            place, turn = self.tracks.poses[self.tracks.number(shape.name)]
            local = self.result.joint_reaction(shape.name)[self.frames, :3]
            force = np.array([rotation_matrix(e) @ f for e, f in zip(turn, local, strict=True)])
            if np.abs(force).max(initial=0.0) > 0.0:
                yield self._arrow(shape.name, "reaction", place, force)

    def _arrow(self, name: str, kind: str, place: np.ndarray, force: np.ndarray) -> dict[str, Any]:
        return {
            "name": name,
            "kind": kind,
            "p": self._places(place),
            "f": self.arrays.add(force.astype(np.float32)),
            "largest": float(np.sqrt((force**2).sum(axis=1)).max(initial=0.0)),
        }
