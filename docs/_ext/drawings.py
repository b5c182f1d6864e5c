"""Pictures of the gallery: those that examples draw themselves, and drawings of those that do not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

Names = dict[str, Any]

# the file under out/ that an example writes
OWN = {
    "01_hub_arm_tip": "overview.png",
    "10_rotating_blade": "rotating_blade.png",
    "11_bracket_stress": "bracket.png",
    "13_choice_of_modes": "choice_of_modes.png",
    "14_campbell_diagram": "campbell.png",
    "17_carts_on_a_ramp": "carts_on_a_ramp.png",
    "18_gripper": "gripper.png",
    "19_beam_on_stops": "beam_on_stops.png",
    "21_helicopter_on_a_deck": "helicopter_on_a_deck.png",
    "22_helicopter_in_a_trap": "helicopter_in_a_trap.png",
    "23_control_of_an_arm": "control_of_an_arm.png",
    "25_stress_of_skids": "stress_of_skids.png",
    "26_stress_of_a_solid_gear": "solid_gear.png",
    "27_flying_noodle": "flying_noodle.png",
    "28_blade_cut_in_twelve": "blade_cut_in_twelve.png",
    "29_drop_of_a_compliant_gear": "drop_of_a_compliant_gear.png",
    "30_trolley_on_a_crane": "trolley_on_a_crane.png",
    "31_cable_car": "cable_car.png",
    "32_crank_from_cad": "crank_from_cad.png",
    "36_constrained_layer": "constrained_layer.png",
    "37_fan_blade_of_sheet": "fan_blade.png",
    "38_stiffened_panel_that_slews": "stiffened_panel.png",
    "39_folded_bracket": "folded_bracket.png",
    "40_composite_flexure": "composite_flexure.png",
}
# whose run can be turned with the mouse on its page
PLAYED = (
    "01_hub_arm_tip",
    "06_flexible_four_bar",
    "09_satellite",
    "18_gripper",
    "19_beam_on_stops",
    "22_helicopter_in_a_trap",
    "27_flying_noodle",
)


def _axes(xlabel: str, ylabel: str, **options: Any) -> tuple[Figure, Any]:
    figure, axes = plt.subplots(figsize=(7.0, 4.0), layout="constrained", **options)
    axes.set(xlabel=xlabel, ylabel=ylabel)
    axes.grid(color="0.9")
    return figure, axes


def flexible_pendulum(of: Names) -> Figure:
    """Draw the rod at each output, its end, and the path of a rigid one's end."""
    figure, axes = _axes("x [m]", "y [m]")
    shapes = of["result"].nodal_positions("rod")
    shades = plt.cm.viridis(np.linspace(0.0, 0.9, len(shapes)))
    for shape, shade, t in zip(shapes, shades, of["result"].times, strict=True):
        axes.plot(shape[:, 0], shape[:, 1], color=shade, label=f"{t:.1f} s")
    axes.plot(of["tip"][:, 0], of["tip"][:, 1], "k.", markersize=4)
    axes.legend(fontsize="small", ncols=2)
    axes.set_aspect("equal")
    return figure


def given_matrices(of: Names) -> Figure:
    """Draw the length of the dumbbell and the path of its two masses."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.6), layout="constrained")
    left.plot(of["result"].times, of["length"])
    left.set(xlabel="t [s]", ylabel="length [m]")
    for node in range(2):
        right.plot(of["x"][:, node, 0], of["x"][:, node, 1], linewidth=0.8)
    right.set(xlabel="x [m]", ylabel="y [m]")
    right.set_aspect("equal")
    left.grid(color="0.9")
    return figure


def driven_rotor(of: Names) -> Figure:
    """Draw the force at the root of the blade and the torque that drives it."""
    figure, axes = _axes("t [s]", "force at the root [N]")
    t = of["result"].times
    for column, name in ((0, "along the blade"), (1, "across, in the plane")):
        axes.plot(t, of["force"][:, column], label=name)
    other = axes.twinx()
    other.plot(t, of["torque"], color="tab:red", label="driving torque")
    other.set_ylabel("driving torque [N m]")
    axes.legend(handles=[*axes.lines, *other.lines])
    return figure


def slider_crank(of: Names) -> Figure:
    """Draw where the slider is and how far the rod bows."""
    figure, axes = _axes("t [ms]", "bow of the rod at its middle [mm]")
    t = 1e3 * of["result"].times
    axes.plot(t, 1e3 * of["bow"], label="bow of the rod")
    other = axes.twinx()
    other.plot(t, of["place"], color="tab:red", label="place of the slider")
    other.set_ylabel("place of the slider [m]")
    axes.legend(handles=[*axes.lines, *other.lines])
    return figure


def four_bar(of: Names) -> Figure:
    """Draw the linkage in some of its positions, and the bending of the coupler."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
    result = of["result"]
    for row in range(100, len(result.times), 14):
        for name in ("coupler", "rocker"):
            shape = result.nodal_positions(name, frames=[row])[0]
            left.plot(shape[:, 0], shape[:, 1], color="tab:blue" if name == "coupler" else "tab:red", linewidth=0.9)
        start = result.nodal_positions("coupler", frames=[row])[0][0]
        left.plot((0.0, start[0]), (0.0, start[1]), color="0.4", linewidth=0.9)
    left.plot((0.0, of["base"]), (0.0, 0.0), "k^")
    left.set(xlabel="x [m]", ylabel="y [m]")
    left.set_aspect("equal")
    right.plot(result.times, 1e3 * result.deflection("coupler", "tip")[:, 1])
    right.set(xlabel="t [s]", ylabel="end of the coupler, across [mm]")
    right.grid(color="0.9")
    return figure


def planar_cart(of: Names) -> Figure:
    """Draw the way of the cart and where its energy goes."""
    figure, axes = _axes("t [s]", "energy [J]")
    energy = of["energy"]
    axes.plot(of["result"].times, energy.total, label="kinetic and potential")
    axes.plot(of["result"].times, energy.dissipated, label="taken by friction and dampers")
    other = axes.twinx()
    other.plot(of["result"].times, of["x"], color="0.6", linewidth=0.9, label="place of the cart")
    other.set_ylabel("x [m]")
    axes.legend(handles=[*axes.lines, *other.lines], loc="center right")
    return figure


def chain(of: Names) -> Figure:
    """Draw the chain at some times."""
    figure, axes = _axes("x [m]", "y [m]")
    result, links = of["result"], of["links"]
    rows = np.linspace(0, len(result.times) - 1, 11).astype(int)
    places = np.array([result.position(f"link {i}") for i in range(links)])
    for row, shade in zip(rows, plt.cm.viridis(np.linspace(0.0, 0.9, len(rows))), strict=True):
        axes.plot(places[:, row, 0], places[:, row, 1], ".-", color=shade, label=f"{result.times[row]:.1f} s")
    axes.legend(fontsize="small", ncols=2)
    axes.set_aspect("equal")
    return figure


def satellite(of: Names) -> Figure:
    """Draw the attitude of the hub and the bending of a panel."""
    figure, axes = _axes("t [s]", "turn of the hub [deg]")
    t = of["result"].times
    axes.plot(t, np.degrees(of["attitude"]), label="turn of the hub")
    other = axes.twinx()
    other.plot(t, 1e3 * of["tip"], color="tab:red", label="end of a panel")
    other.set_ylabel("end of a panel, across [mm]")
    axes.legend(handles=[*axes.lines, *other.lines])
    return figure


def imported_bar(of: Names) -> Figure:
    """Draw the path of the bar's end: of the body read, and of the same handed on as SID."""
    figure, axes = _axes("x [m]", "y [m]")
    result = of["result"]
    for row in range(0, len(result.times), max(1, len(result.times) // 10)):
        tip = result.position("bar", "TIP")[row]
        axes.plot((0.0, tip[0]), (0.0, tip[1]), color="0.75", linewidth=0.8)
    path = result.position("bar", "TIP")
    axes.plot(path[:, 0], path[:, 1], label="end of the bar read back from SID")
    axes.plot(*of["tips"][0][:2], "o", fillstyle="none", label="of the bar read from matrices, at 0.5 s")
    axes.legend()
    axes.set_aspect("equal")
    return figure


def bead(of: Names) -> Figure:
    """Draw the wire, the magnet, and the place of the bead over time."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.4), layout="constrained")
    x = np.linspace(-0.55, 0.55, 101)
    left.plot(x, of["CURVATURE"] * x**2, "0.5")
    left.plot(of["START"], of["CURVATURE"] * of["START"] ** 2, "o")
    left.plot(0.0, -of["DEPTH"], "s", color="tab:red")
    left.set(xlabel="x [m]", ylabel="z [m]")
    left.set_aspect("equal")
    result = of["result"]
    right.plot(result.times, result.joint_coordinates("bead")[:, 0])
    right.set(xlabel="t [s]", ylabel="x of the bead [m]")
    right.grid(color="0.9")
    return figure


def shaken_ramp(of: Names) -> Figure:
    """Draw how much of the cone friction takes, and what the stop carries."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.6), layout="constrained")
    t = of["result"].times
    for name, contact in (("block", of["held"]), ("wheel", of["rolled"])):
        left.plot(t, contact.tangential / np.maximum(contact.normal, 1.0), label=name)
    left.set(xlabel="t [s]", ylabel="friction / normal force")
    left.legend()
    right.plot(t, of["caught"].normal)
    right.set(xlabel="t [s]", ylabel="the stop on the box [N]")
    for axes in (left, right):
        axes.grid(color="0.9")
    return figure


def learning(of: Names) -> Figure:
    """Draw how long each law that was tried kept the pole up."""
    figure, axes = _axes("generation", "time up [s]")
    for generation, times in enumerate(of["history"]):
        axes.plot(np.full(len(times), generation), times, "o", color="C0", alpha=0.5)
    axes.plot([np.mean(times) for times in of["history"]], color="C1", label="mean")
    axes.legend()
    return figure


def study(of: Names) -> Figure:
    """Draw the largest swing of each case, by speed and rope."""
    figure, axes = _axes("", "largest swing [deg]")
    table = of["table"]
    speed, rope, swing = (np.asarray(table.column(name)) for name in ("speed", "rope", "swing"))
    pairs = sorted(set(zip(speed.tolist(), rope.tolist(), strict=True)))
    for place, (v, length) in enumerate(pairs):
        of_pair = swing[(speed == v) & (rope == length)]
        axes.plot(np.full(len(of_pair), place), of_pair, "o", fillstyle="none")
    axes.axhline(10.0, color="tab:red", linewidth=0.9)
    axes.set_xticks(range(len(pairs)), [f"{v:g} m/s\n{length:g} m" for v, length in pairs])
    return figure


def spinning_blade(of: Names) -> Figure:
    """Draw the frequency of the flap over the speed."""
    figure, axes = _axes("speed [rev/min]", "first flap [Hz]")
    axes.plot(of["speeds"] * 30.0 / np.pi, of["flaps"], "o-")
    return figure


def oval_ring(of: Names) -> Figure:
    """Draw the nodes of the ring, at rest and as an oval in its plane."""
    figure, axes = _axes("x [m]", "y [m]")
    nodes = of["model"].nodes
    shape = of["ring"].basis[:, 2].reshape(-1, 3)
    moved = nodes + 0.05 * np.ptp(nodes[:, 0]) / np.abs(shape).max() * shape
    axes.plot(nodes[:, 0], nodes[:, 1], ".", color="0.7", markersize=3)
    axes.plot(moved[:, 0], moved[:, 1], ".", markersize=3)
    axes.set_aspect("equal")
    return figure


def swinging_arm(of: Names) -> Figure:
    """Draw the height of the load and the deflection of the end of the arm."""
    figure, axes = _axes("t [s]", "height of the load [m]")
    result = of["result"]
    axes.plot(result.times, result.position("load")[:, 2], label="height of the load")
    other = axes.twinx()
    other.plot(
        result.times, 1e3 * result.deflection("arm", "TIP")[:, 2], color="tab:red", label="deflection of the end"
    )
    other.set_ylabel("deflection of the end [mm]")
    axes.legend(handles=[*axes.lines, *other.lines])
    return figure


DRAWN: dict[str, Callable[[Names], Figure]] = {
    "02_flexible_pendulum": flexible_pendulum,
    "03_given_matrices": given_matrices,
    "04_driven_rotor": driven_rotor,
    "05_flexible_slider_crank": slider_crank,
    "06_flexible_four_bar": four_bar,
    "07_planar_cart": planar_cart,
    "08_chain_of_twenty": chain,
    "09_satellite": satellite,
    "12_import_matrices": imported_bar,
    "15_own_load_and_joint": bead,
    "16_contact_on_a_shaken_ramp": shaken_ramp,
    "20_study": study,
    "24_learning_to_balance": learning,
    "33_elements_of_scikit_fem": spinning_blade,
    "34_ring_of_ngsolve": oval_ring,
    "35_box_of_calculix": swinging_arm,
}
