"""The door to matplotlib: plots of a result, drawn without a display."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from kanefe.errors import MissingDependency, ModelError
from kanefe.results.quantities import (
    DRIVES,
    ENERGIES,
    GEARS,
    INTERFACES,
    LOADS,
    LOOPS,
    MODES,
    MOMENTA,
    POINTS,
    QUANTITIES,
)
from kanefe.storage.files import ready_path, write_whole

try:
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure as Figure
except ImportError as _error:
    raise MissingDependency("matplotlib", "Result.plot", "pip install matplotlib") from _error

if TYPE_CHECKING:
    from kanefe.results.reader import Reader


class ShownFigure(Figure):
    """A figure that notebooks show, also without matplotlib's inline backend."""

    def _repr_png_(self) -> bytes:
        data = io.BytesIO()
        self.savefig(data, format="png", dpi=SCREEN)
        return data.getvalue()


Curves = Sequence[tuple[str, np.ndarray]]
Drawn = TypeVar("Drawn")

COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#444444")
"""Colours that are also distinct for colour-blind readers (Okabe & Ito)."""

STYLES = ("-", "--", ":", "-.")

STATUS_COLORS = {"sticks": "#d8ecd8", "slips": "#fbe3cf"}
"""Background colours of the curves of a contact; white where it is open."""

SCREEN = 100
"""Resolution of a picture in a notebook, dots per inch."""

LARGEST_LEGEND = 12
"""Number of curves above which a legend lists only the first ones."""


def draw(result: Reader, what: str, names: Sequence[str], path: str | Path | None) -> Figure:
    """Return the picture that `Result.plot` describes, and write it to `path` if given."""
    pictures: dict[str, Callable[[Reader], Figure]] = {
        "overview": _overview,
        "energy": _energy_picture,
        "momentum": _momentum_picture,
    }
    if what == "contacts":
        figure = _contacts_picture(result, names)
    elif what in pictures:
        if names:
            raise ModelError(f"the picture {what!r} is of the whole scene and takes no names, not {', '.join(names)}")
        figure = pictures[what](result)
    elif what in QUANTITIES:
        figure = _quantity_picture(result, what, names)
    else:
        raise ModelError(f"there is no picture {what!r}. There are: {', '.join((*pictures, 'contacts', *QUANTITIES))}")
    return saved_figure(figure, path)


def blank_figure(size: tuple[float, float]) -> Figure:
    """Return a figure without a display, of a size in inches."""
    figure = ShownFigure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _figure(rows: int, columns: int, size: tuple[float, float]) -> tuple[Figure, list[Axes]]:
    figure = blank_figure(size)
    return figure, list(np.ravel(figure.subplots(rows, columns, squeeze=False, sharex=True)))


def saved_figure(figure: Figure, path: str | Path | None) -> Figure:
    """Write a figure, if there is a path, in the format of its suffix; return the figure."""
    if path is None:
        return figure
    target = ready_path(path)
    kind = target.suffix.removeprefix(".").lower() or "png"
    known = figure.canvas.get_supported_filetypes()
    if kind not in known:
        raise ModelError(f"cannot draw to {target}: {kind!r} is none of {', '.join(sorted(known))}")
    buffer = io.BytesIO()
    figure.savefig(buffer, format=kind, dpi=150)
    write_whole(target, lambda file: file.write(buffer.getbuffer()))
    return figure


def _dress(axes: Axes, ylabel: str, title: str = "", time: bool = True) -> None:
    """Label a diagram; its legend is to the right of it, never on the curves."""
    axes.set_ylabel(ylabel)
    if title:
        axes.set_title(title, loc="left", fontsize="medium", fontweight="bold")
    if time:
        axes.set_xlabel("time [s]")
    axes.grid(color="0.9", linewidth=0.8)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.margins(x=0.01)
    axes.ticklabel_format(axis="y", scilimits=(-3, 4), useMathText=True)
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        if len(handles) > LARGEST_LEGEND:
            more = f"and {len(handles) - LARGEST_LEGEND + 1} more"
            handles, labels = handles[:LARGEST_LEGEND], [*labels[: LARGEST_LEGEND - 1], more]
        axes.legend(handles, labels, loc="upper left", bbox_to_anchor=(1.0, 1.02), frameon=False, fontsize="small")


def _curves(axes: Axes, times: np.ndarray, curves: Curves, style: str = "-", color: int = 0) -> None:
    for i, (label, values) in enumerate(curves, start=color):
        shown = style if i < len(COLORS) else STYLES[i // len(COLORS) % len(STYLES)]
        axes.plot(times, values, shown, color=COLORS[i % len(COLORS)], linewidth=1.4, label=label)


def _quantity_picture(result: Reader, quantity: str, names: Sequence[str]) -> Figure:
    """Draw a quantity: one diagram for each unit, one line style for each body."""
    targets = _targets(result, quantity, names)
    parts: dict[tuple[str, str], list[Curves]] = {}
    for target in targets:
        values = result.read(quantity, *target).reshape(len(result.times), -1)
        column, prefix = 0, " ".join(target) + " " if len(targets) > 1 else ""
        for label, unit, components in result.parts(quantity, target[0] if target else ""):
            own = components or ("",)
            part = [((prefix + name).strip(), values[:, column + i]) for i, name in enumerate(own)]
            parts.setdefault((label, unit), []).append(part)
            column += len(own)
    count = max(len(parts), 1)
    figure, axes = _figure(count, 1, (8.0, 1.2 + 2.8 * count))
    for ax, ((label, unit), sets) in zip(axes, parts.items(), strict=False):
        for number, curves in enumerate(sets):
            single = len(sets) > 1 and all(len(c) == 1 for c in sets)
            shown = [("" if name == label and not single else name, y) for name, y in curves]
            _curves(ax, result.times, shown, "-" if single else STYLES[number % len(STYLES)], number if single else 0)
        _dress(ax, f"{label} [{unit}]", time=ax is axes[count - 1])
    title = QUANTITIES[quantity].title
    figure.suptitle(title if len(targets) != 1 or not targets[0] else f"{', '.join(targets[0])}: {title}")
    return figure


def _targets(result: Reader, quantity: str, names: Sequence[str]) -> list[tuple[str, ...]]:
    """Return body and interface of every requested curve; without names, all that have the quantity."""
    if quantity in ENERGIES or quantity in MOMENTA:
        if names:
            raise ModelError(f"{quantity} is of the whole scene and takes no names, not {', '.join(names)}")
        return [()]
    if len(names) > 2:
        raise ModelError(f"{quantity} takes a body and an interface, not {', '.join(names)}")
    if names:
        if len(names) == 1 and quantity in INTERFACES:
            return [(names[0], interface) for interface in result.interfaces(names[0])] or [(names[0],)]
        return [tuple(names)]
    shapes = [result.body(name) for name in result.bodies]
    found: list[tuple[str, ...]]
    if quantity in LOOPS:
        found = [(name,) for name in result.loops]
    elif quantity in GEARS:
        found = [(name,) for name in result.gears]
    elif quantity in POINTS:
        found = [(name,) for name in result.contacts]
    elif quantity in LOADS:
        found = [(name,) for name in result.loads]
    elif quantity in INTERFACES:
        found = [(shape.name, interface) for shape in shapes for interface in shape.interfaces]
    elif quantity in MODES:
        found = [(shape.name,) for shape in shapes if shape.is_flexible]
    elif quantity in DRIVES:
        found = [(shape.name,) for shape in shapes if shape.is_driven]
    elif quantity.startswith("joint_") and quantity != "joint_reaction":
        found = [(shape.name,) for shape in shapes if shape.coordinate_names]
    else:
        found = [(shape.name,) for shape in shapes]
    if not found:
        raise ModelError(f"nothing to draw: no body of the run has {quantity.replace('_', ' ')}")
    return found


def _energy_picture(result: Reader) -> Figure:
    figure, (upper, lower) = _figure(2, 1, (8.0, 6.0))
    _energy_diagram(upper, result)
    _dress(upper, "energy [J]", "Energies", time=False)
    _curves(lower, result.times, [("", result.energy.balance_error)], color=1)
    _dress(lower, "error [J]", "Balance: mechanical + dissipated - work - start")
    return figure


def _energy_diagram(axes: Axes, result: Reader) -> None:
    energy = result.energy
    # gravity energy is relative to N's origin: far from it the other energies would be flat lines
    level = energy.gravity[0]
    for i, name in enumerate(("kinetic", "elastic", "gravity", "dissipated", "work", "impacts")):
        values = getattr(energy, name)
        if name == "gravity":
            values = values - level
        if name in ("kinetic", "work") or np.any(values):
            label = "gravity, from its start" if name == "gravity" and level else name
            axes.plot(result.times, values, color=COLORS[i], linewidth=1.4, label=label)
    axes.plot(result.times, energy.total - level, "--", color="0.2", linewidth=1.4, label="mechanical")


def _momentum_picture(result: Reader) -> Figure:
    figure, axes = _figure(2, 1, (8.0, 6.0))
    for ax, name in zip(axes, MOMENTA, strict=True):
        ((label, unit, components),) = QUANTITIES[name].parts
        values = result.read(name)
        _curves(ax, result.times, [(c, values[:, i]) for i, c in enumerate(components)])
        _dress(ax, f"{label} [{unit}]", QUANTITIES[name].title.capitalize(), time=ax is axes[1])
    return figure


def _contacts_picture(result: Reader, names: Sequence[str]) -> Figure:
    """Draw normal force, friction and slip of contacts, with their status as background colour."""
    shown = names or result.contacts
    if not shown:
        raise ModelError("nothing to draw: the run has no contact")
    times = result.times
    figure, axes = _figure(len(shown), 1, (9.0, 1.2 + 2.4 * len(shown)))
    for ax, name in zip(axes, shown, strict=True):
        history = result.contact(name)
        for status, color in STATUS_COLORS.items():
            there = history.status == status
            # the area ends at the first output after the status
            before = np.concatenate(([False], there[:-1])) | there
            if there.any():
                ax.fill_between(
                    times,
                    0.0,
                    1.0,
                    where=before,
                    transform=ax.get_xaxis_transform(),
                    color=color,
                    linewidth=0.0,
                    label=status,
                )
        _curves(ax, times, [("normal", history.normal)])
        if history.slip.any() or history.tangential.any():
            _curves(ax, times, [("friction", history.tangential)], color=1)
            slid = ax.twinx()
            slid.plot(times, 1e3 * history.slip, "--", color="0.35", linewidth=1.2)
            slid.set_ylabel("slip [mm] (dashed)", color="0.35")
            slid.spines["top"].set_visible(False)
            slid.ticklabel_format(axis="y", scilimits=(-3, 4), useMathText=True)
        _dress(ax, "force [N]", name, time=ax is axes[-1])
        if (legend := ax.get_legend()) is not None:
            legend.set_bbox_to_anchor((1.12, 1.02))  # beside the second axis
    return figure


def _overview(result: Reader) -> Figure:
    """Draw joints or positions, deflection or speeds, energies, and coupling forces or joint reactions."""
    figure, axes = _figure(2, 2, (13.0, 7.5))
    _joints_diagram(axes[0], result)
    _deflection_diagram(axes[1], result)
    _energy_diagram(axes[2], result)
    worst = abs(result.energy.balance_error).max()
    _dress(axes[2], "energy [J]", f"Energies (largest error of the balance {worst:.2g} J)")
    _forces_diagram(axes[3], result)
    return figure


def _joints_diagram(axes: Axes, result: Reader) -> None:
    """Draw the coordinates of all joints if they have one unit, else the positions of the bodies."""
    shapes = [result.body(name) for name in result.bodies]
    single = [shape for shape in shapes if len(shape.coordinate_names) == 1]
    units = {result.units("joint_coordinates", shape.name) for shape in single}
    if len(units) == 1:
        unit = units.pop()
        curves = [(shape.name, result.joint_coordinates(shape.name)[:, 0]) for shape in single]
        _curves(axes, result.times, curves)
        _dress(axes, f"{'angle' if unit == 'rad' else 'travel'} [{unit}]", "Joints", time=False)
        return
    shown, note = _first(shapes)
    for number, shape in enumerate(shown):
        position = result.position(shape.name)
        curves = [(f"{shape.name} {c}", position[:, i]) for i, c in enumerate("xyz")]
        _curves(axes, result.times, curves, STYLES[number])
    _dress(axes, "position [m]", f"Positions in N{note}", time=False)


def _deflection_diagram(axes: Axes, result: Reader) -> None:
    """Draw the deflections of the free interfaces, or the speeds of the bodies if there are none."""
    moving = [
        (shape.name, interface, result.deflection(shape.name, interface)[:, :3])
        for shape in (result.body(name) for name in result.bodies)
        for interface in shape.interfaces
        if np.any(result.deflection(shape.name, interface)[:, :3])
    ]
    if not moving:
        curves = [(name, np.linalg.norm(result.velocity(name), axis=1)) for name in result.bodies]
        _curves(axes, result.times, curves)
        _dress(axes, "speed [m/s]", "Speed of the bodies' origins", time=False)
        return
    millimetres = max(abs(values).max() for *_, values in moving) < 0.5
    first, note = _first(moving)
    for number, (body, interface, values) in enumerate(first):
        shown = values * (1e3 if millimetres else 1.0)
        prefix = f"{body} {interface} " if len(moving) > 1 else ""
        _curves(axes, result.times, [(f"{prefix}{c}", shown[:, i]) for i, c in enumerate("xyz")], STYLES[number])
    where = f"{moving[0][1]!r} of {moving[0][0]!r}" if len(moving) == 1 else "interfaces"
    _dress(
        axes,
        f"deflection [{'mm' if millimetres else 'm'}]",
        f"Deflection of {where} in its mesh frame{note}",
        time=False,
    )


def _forces_diagram(axes: Axes, result: Reader) -> None:
    """Draw the forces on the flexible bodies at their interfaces, or the reactions of the joints."""
    if not result.has_forces:
        axes.text(0.5, 0.5, "forces were not saved", ha="center", va="center", transform=axes.transAxes)
        _dress(axes, "force [N]")
        return
    shapes = [result.body(name) for name in result.bodies]
    pairs = [(shape.name, interface) for shape in shapes for interface in shape.interfaces]
    forces: list[tuple[str, Any]] = [(f"{b} {i}", result.coupling_force(b, i)[:, :3]) for b, i in pairs]
    title = "Coupling forces on the flexible bodies, in their mesh frames"
    if not forces:
        title = "Reactions of the joints, in the bodies' axes"
        forces = [(shape.name, result.joint_reaction(shape.name)[:, :3]) for shape in shapes]
    forces, note = _first([(name, values) for name, values in forces if np.any(values)])
    for number, (name, values) in enumerate(forces):
        _curves(axes, result.times, [(f"{name} {c}", values[:, i]) for i, c in enumerate("xyz")], STYLES[number])
    _dress(axes, "force [N]", title + note)


def _first(found: list[Drawn]) -> tuple[list[Drawn], str]:
    """Return as many as the line styles can distinguish, and a note with the total number."""
    note = f" (the first {len(STYLES)} of {len(found)})" if len(found) > len(STYLES) else ""
    return found[: len(STYLES)], note
