"""A ship whose motions in waves are a formula, and files of them as programs write them, each in its own convention."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

FREQUENCIES = np.array((0.08, 0.15, 0.25, 0.35, 0.42, 0.47, 0.5, 0.53, 0.58, 0.65, 0.8, 1.0, 1.3, 1.7, 2.2, 3.0))
HEADINGS = np.arange(0.0, 181.0, 30.0)
ROLL, ROLL_RATIO = 0.5, 0.06
GRAVITY = 9.81


def motions(omega: Any, heading_deg: Any, speed: Any = 0.0) -> np.ndarray:
    """Surge to yaw in the convention of the house: with the surface in long waves; roll resonant."""
    omega, beta, speed = np.broadcast_arrays(*np.atleast_1d(omega, np.radians(heading_deg), speed))
    k, c, s = omega**2 / GRAVITY, np.cos(beta), np.sin(beta)
    met = omega + k * speed * c
    less = 1.0 / (1.0 + (omega / 0.9) ** 4 + 0.4j * (omega / 0.9) ** 3)
    roll = ROLL**2 / (ROLL**2 - met**2 + 2j * ROLL_RATIO * ROLL * met)
    return np.stack(
        (
            1j * c * less,
            1j * s * less,
            less * (1.0 + 0.2j * (1.0 - c**2) * k),
            1j * k * s * roll,
            -1j * k * c * less,
            0.1 * k * s * c * less,
        ),
        axis=-1,
    )


def table(speeds: Any = (0.0,), headings: Any = HEADINGS) -> np.ndarray:
    """The motions over speeds, headings and FREQUENCIES, shape (s, h, f, 6)."""
    return motions(FREQUENCIES, np.asarray(headings)[:, None], np.asarray(speeds, dtype=float)[:, None, None])


def write_veres(path: Path, speeds: Any = (0.0, 5.0, 10.0), values: np.ndarray | None = None) -> Path:
    """X aft, y to starboard: surge, sway, roll and pitch change their signs."""
    values = table(speeds) if values is None else values
    lines = ["MOTION TRANSFER FUNCTIONS", "run", "ship", "loading", "", "data", "1025.0 9.81", "100 20 5", "0 0"]
    lines.append(f"{len(speeds)} {len(HEADINGS)} {len(FREQUENCIES)} 6")
    for speed, of_speed in zip(speeds, values * (-1, -1, 1, -1, -1, 1), strict=True):
        lines.append(f"{speed} 0 0 1.5 7.25")
        for heading, of_heading in zip(HEADINGS, of_speed, strict=True):
            lines.append(f"{heading}")
            for omega, six in zip(FREQUENCIES, of_heading, strict=True):
                lines.append(f"{omega}")
                lines += [f"{i + 1} {z.real:.12E} {z.imag:.12E}" for i, z in enumerate(six)]
    path.write_text("\n".join(lines) + "\n")
    return path


def write_wamit(path: Path, length: float = 50.0) -> Path:
    """Headings are where waves go to from x to port: 180 is head seas, 270 from port; rotations times the length."""
    lines = []
    for f, omega in enumerate(FREQUENCIES):
        for h, heading in enumerate(HEADINGS):
            for i, z in enumerate(table()[0, h, f] * np.where(np.arange(6) < 3, 1.0, length)):
                phase = np.degrees(np.angle(z))
                row = (2 * np.pi / omega, heading + 180.0, i + 1, abs(z), phase, z.real, z.imag)
                lines.append("{:.12E} {:.6E} {:d} {:.12E} {:.6E} {:.12E} {:.12E}".format(*row))
    path.write_text("\n".join(lines) + "\n")
    return path


def capytaine_dataset(**more: Any) -> Any:
    """The data set: exp(-i omega t), wave directions in rad, real and imaginary part as an axis, as it is exported."""
    import xarray

    values = np.moveaxis(table()[0], 0, 1).conj()  # (omega, wave_direction, dof)
    return xarray.Dataset(
        {"RAO": (("complex", "omega", "wave_direction", "radiating_dof"), np.array((values.real, values.imag)))},
        coords={
            "complex": ["re", "im"],
            "omega": FREQUENCIES,
            "wave_direction": np.radians(HEADINGS + 180.0),
            "radiating_dof": ["Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"],
            "water_depth": np.inf,
            **more,
        },
    )


OURS = {
    "time": "exp(+iwt)",
    "heading_zero": "head",
    "heading_90": "port",
    "x": "forward",
    "y": "port",
    "z": "up",
    "rotations": "rad/m",
    "reference": "centre of gravity",
}


def write_table(path: Path, said: dict[str, str] = OURS, *, polar: bool = False, declared: Any = None) -> Path:
    """A table in any convention, with what is declared of it in its head: all, if nothing else is said."""
    values = table()[0].copy()
    for axis, ours in zip("xyz", ("forward", "port", "up"), strict=True):
        if said[axis] != ours:
            values[..., "xyz".index(axis) :: 3] *= -1.0
    if said["rotations"].endswith("slope"):
        values[..., 3:] /= (FREQUENCIES**2 / GRAVITY)[:, None]
    if said["rotations"].startswith("deg"):
        values[..., 3:] = np.degrees(values[..., 3:].real) + 1j * np.degrees(values[..., 3:].imag)
    if said["time"] == "exp(-iwt)":
        values = values.conj()
    headings = {
        ("head", "port"): HEADINGS,
        ("head", "starboard"): -HEADINGS,
        ("following", "port"): 180.0 - HEADINGS,
        ("following", "starboard"): HEADINGS - 180.0,
    }[said["heading_zero"], said["heading_90"]]
    names = ("surge", "sway", "heave", "roll", "pitch", "yaw")
    parts = ("amplitude", "phase") if polar else ("re", "im")
    lines = [f"# {name}: {value}" for name, value in (said if declared is None else declared).items()]
    lines.append(
        ",".join(["heading", "period" if polar else "omega", *(f"{n}_{part}" for n in names for part in parts)])
    )
    for heading, of_heading in zip(headings, values, strict=True):
        for omega, six in zip(FREQUENCIES, of_heading, strict=True):
            pairs = [(abs(z), np.degrees(np.angle(z))) if polar else (z.real, z.imag) for z in six]
            cells = (heading, 2 * np.pi / omega if polar else omega, *np.ravel(pairs))
            lines.append(",".join(f"{cell:.12g}" for cell in cells))
    path.write_text("\n".join(lines) + "\n")
    return path
