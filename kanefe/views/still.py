"""Small pictures of a flexible body, or of a run at one time."""

from __future__ import annotations

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.results.load_lines import GONE, SLACK, LoadLine
from kanefe.results.reader import Reader
from kanefe.views.dashes import dashes
from kanefe.views.player.boxes import SMALLEST, TRIANGLES, box_of, is_inside
from kanefe.views.player.creases import shaded
from kanefe.views.player.room import room_of
from kanefe.views.player.skins import skin_of
from kanefe.views.player.tracks import Tracks, up_axis
from kanefe.views.relief import DARK, relief
from kanefe.views.thumbnail import Piece, thumbnail

COLOURS = ((91, 138, 184), (217, 149, 74), (121, 168, 107), (181, 107, 128), (140, 123, 179), (184, 163, 90))
"""Colours of successive bodies."""

GROUND = (195, 202, 211)
ROPE = (122, 75, 30)

LOOKED_AT = 25
"""Number of instants of a run by which moving parts are identified."""

DASH = 0.03
"""Length of a dash of a slack rope, relative to the size of the view."""


def picture_of_body(body: FlexibleBody) -> bytes:
    """Return the undeformed body as a .png."""
    skin = skin_of(body)
    creases = shaded(skin.points, skin.triangles).creases if skin.creases is None else skin.creases
    return thumbnail([Piece(skin.points, skin.triangles, creases, COLOURS[0])])


def picture_of_run(result: Reader, row: int = -1) -> bytes:
    """Return the bodies and the finite surfaces of a run at an output time as a .png."""
    row = range(len(result.times))[row]
    others = np.linspace(0, len(result.times) - 1, LOOKED_AT).round().astype(int)
    frames = np.append(row, others)  # the first is drawn, the others show what moves
    tracks, lines = Tracks(result, frames), result.load_lines(frames)
    shapes = [result.body(name) for name in result.bodies]
    room = room_of(result, tracks, {s.name: skin_of(s) for s in shapes if s.is_flexible}, lines)
    least = SMALLEST * room.size
    middles = {s.name: tracks.placed(tracks.number(s.name), s.com[None])[0] for s in shapes if s.mass > 0.0}
    pieces = []
    for number, shape in enumerate(shapes):
        frame, colour = tracks.number(shape.name), COLOURS[number % len(COLOURS)]
        own = [surface for surface in result.surfaces if surface.body == shape.name]
        if shape.is_flexible:
            skin = skin_of(shape)
            moved = skin.points + skin.motion(shape, result.modal_coordinates(shape.name)[[row]])[0]
            creases = shaded(skin.points, skin.triangles).creases if skin.creases is None else skin.creases
            pieces.append(Piece(tracks.placed(frame, moved), skin.triangles, creases, colour))
        elif shape.mass > 0.0 and (box := box_of(shape, own, least)) is not None:
            corners, creases = tracks.placed(frame, box), shaded(box, TRIANGLES).creases
            others = np.array([middles[name] for name in middles if name != shape.name]).reshape(-1, 3)
            sides = TRIANGLES[:0] if is_inside(corners, others) else TRIANGLES  # transparent, to show the bodies inside
            pieces.append(Piece(corners, sides, creases, colour))
    for surface in result.surfaces:
        if not surface.is_endless:
            place = tracks.placed(tracks.number(surface.body, surface.interface), surface.vertices)
            creases = shaded(place, surface.triangles).creases
            on = result.bodies.index(surface.body) if surface.body else -1
            shades = DARK + (1.0 - DARK) * relief(surface) if len(surface.lines) else None
            colour = COLOURS[on % len(COLOURS)] if on >= 0 else GROUND
            pieces.append(Piece(place, surface.triangles, creases, colour, shades))
    pieces += [_of_line(line, DASH * room.size) for line in lines if line.states[0] != GONE]
    around = None if room.is_whole and room.path is None else room.around(0)
    return thumbnail(pieces, up_axis(result), around) if pieces else b""


def _of_line(line: LoadLine, dash: float) -> Piece:
    points = line.points[0]
    pairs = dashes(points, dash) if line.states[0] == SLACK else np.stack((points[:-1], points[1:]), axis=1)
    numbers = np.arange(2 * len(pairs)).reshape(-1, 2)
    return Piece(pairs.reshape(-1, 3), np.zeros((0, 3), dtype=int), numbers, ROPE)
