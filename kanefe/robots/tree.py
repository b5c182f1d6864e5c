"""The order of links: parents before their children, from the root."""

from __future__ import annotations

from collections.abc import Mapping

from kanefe.errors import ModelError


def parents_first(parents: Mapping[str, str | None], where: str) -> list[str]:
    """Return the links in depth-first order from the root.

    Parameters
    ----------
    parents : dict of str to str or None
        Link -> its parent; None: it has none.
    where : str
        The file, for messages.

    Raises
    ------
    ModelError
        If there is no link, no root, more than one root, or a loop apart from the tree.
    """
    if not parents:
        raise ModelError(f"{where} has no links")
    roots = [name for name, parent in parents.items() if parent is None]
    if not roots:
        raise ModelError(
            f"{where} has no root: each link is the child of a joint. Remedy: leave out one joint of the loop"
        )
    if len(roots) > 1:
        raise ModelError(
            f"{where} has {len(roots)} links that no joint carries: {', '.join(roots)}. Remedy: join them, "
            "or a file each"
        )
    children: dict[str, list[str]] = {name: [] for name in parents}
    for name, parent in parents.items():
        if parent is not None:
            children[parent].append(name)
    order, left = [], roots
    while left:
        name = left.pop()
        order.append(name)
        left.extend(reversed(children[name]))
    if beside := sorted(set(parents) - set(order)):
        raise ModelError(f"{where}: links {', '.join(beside)} carry each other in a ring that the root does not reach")
    return order
