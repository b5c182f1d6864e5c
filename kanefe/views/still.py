"""A flexible body, or all of a run at one time, as a small picture."""

from __future__ import annotations

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.results.reader import Reader
from kanefe.views.player.boxes import SMALLEST, TRIANGLES, box_of
from kanefe.views.player.creases import shaded
from kanefe.views.player.skins import skin_of
from kanefe.views.player.tracks import Tracks, up_axis
from kanefe.views.thumbnail import Piece, thumbnail

COLOURS = ((91, 138, 184), (217, 149, 74), (121, 168, 107), (181, 107, 128), (140, 123, 179), (184, 163, 90))
"""Of bodies, one after the other."""

GROUND = (195, 202, 211)


def picture_of_body(body: FlexibleBody) -> bytes:
    """Return the undeformed body as a .png."""
    skin = skin_of(body)
    creases = shaded(skin.points, skin.triangles).creases if skin.creases is None else skin.creases
    return thumbnail([Piece(skin.points, skin.triangles, creases, COLOURS[0])])


def picture_of_run(result: Reader, row: int = -1) -> bytes:
    """Return the bodies and the finite surfaces of a run at an output time as a .png."""
    row = range(len(result.times))[row]
    tracks = Tracks(result, np.array([row]))
    shapes = [result.body(name) for name in result.bodies]
    origins = np.array([tracks.placed(tracks.number(s.name), s.com[None])[0] for s in shapes])
    least = SMALLEST * float(np.linalg.norm(np.ptp(origins, axis=0)))
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
            pieces.append(Piece(tracks.placed(frame, box), TRIANGLES, shaded(box, TRIANGLES).creases, colour))
    for surface in result.surfaces:
        if not surface.is_endless:
            place = tracks.placed(tracks.number(surface.body, surface.interface), surface.vertices)
            creases = shaded(place, surface.triangles).creases
            on = result.bodies.index(surface.body) if surface.body else -1
            pieces.append(Piece(place, surface.triangles, creases, COLOURS[on % len(COLOURS)] if on >= 0 else GROUND))
    return thumbnail(pieces, up_axis(result)) if pieces else b""
