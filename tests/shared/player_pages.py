"""Pages of runs, read back as a browser reads them."""

from __future__ import annotations

import base64
import json
import re
import zlib
from typing import Any

import numpy as np

from kanefe.frames import rotation_matrix


def read_page(html: str) -> dict[str, Any]:
    """Return what a page tells, with its arrays in their places."""
    scene = re.search(r'<script type="application/json" id="scene">(.*?)</script>', html, re.DOTALL)
    block = re.search(r'id="arrays">(.*?)</script>', html, re.DOTALL)
    data = zlib.decompress(base64.b64decode(block[1]))

    def filled(value: Any) -> Any:
        if isinstance(value, list):
            return [filled(part) for part in value]
        if not isinstance(value, dict):
            return value
        if "at" in value and "type" in value:
            count = int(np.prod(value["shape"], dtype=int))
            return np.frombuffer(data, value["type"], count, value["at"]).reshape(value["shape"])
        return {key: filled(part) for key, part in value.items()}

    return filled(json.loads(scene[1]))


def body_of(told: dict[str, Any], name: str) -> dict[str, Any]:
    """Return what a page tells of a body."""
    return next(body for body in told["bodies"] if body["name"] == name)


def placed(told: dict[str, Any], part: dict[str, Any], row: int, points: np.ndarray | None = None) -> np.ndarray:
    """Return where the points of a part are in N at an instant, by the sum that the browser makes."""
    local = part["points"].astype(float) if points is None else points
    if "modes" in part:
        local = local + np.tensordot(part["amplitudes"][row] * part["factors"], part["modes"].astype(float), axes=1)
    if part["frame"] < 0:
        return local + told["origin"]
    frame = told["frames"][part["frame"]]
    return local @ rotation_matrix(frame["e"][row].astype(float)).T + frame["p"][row] + told["origin"]
