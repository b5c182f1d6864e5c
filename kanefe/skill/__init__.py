"""Recipes for coding assistants, as ``kanefe skill`` prints them."""

from __future__ import annotations

from importlib.resources import files


def recipes() -> str:
    """Return the page of recipes, Markdown."""
    return files("kanefe.skill").joinpath("recipes.md").read_text(encoding="utf-8")
