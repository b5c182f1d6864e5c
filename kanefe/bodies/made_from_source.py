"""MadeFromSource: the methods of a flexible body by which it is made again."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

from kanefe.arguments import checked

if TYPE_CHECKING:
    from kanefe.bodies.source import Rebuildable, Source


class MadeFromSource:
    """What can be made again from its source.

    Attributes
    ----------
    source : Source or None
        How to make it again. It is no field: copies, pickles and files have none.
    """

    source: ClassVar[Source | None] = None

    @property
    def rebuildable(self) -> Rebuildable:
        """What of it `rebuilt` can change, and where not, why; ``print(body.rebuildable)``."""
        from kanefe.bodies.source import about_body

        return about_body(self)

    @checked("refined", "order")
    def rebuilt(
        self,
        reduction: Any = None,
        stiffening: Literal["none", "inertial", "full"] | None = None,
        refined: int = 0,
        order: int | None = None,
    ) -> Self:
        """Return a body made again from the same source, with the same interfaces, surfaces, materials and options.

        Parameters
        ----------
        reduction : Reduction, "auto" or "none", optional
            Such as `CraigBampton`; "auto" is `CraigBampton()`, "none" keeps every degree of freedom; of an exact beam
            the functions of its strains, as its `basis`. Default: as it was.
        stiffening : "none", "inertial" or "full", optional
            Default: as it was.
        refined : int
            Number of times that each cell is split into halves along each of its sides; of an exact beam, that the
            number of functions is doubled. The old nodes stay, and groups and places hold the same parts as before.
            Curved sides keep their curves, straight ones stay straight: see `kanefe_fem.refined_mesh`.
        order : int, optional
            Order of the displacement of solids, 1 or 2. Default: as it was.

        Raises
        ------
        ModelError
            If something asked for cannot be changed, with the reason: see `rebuildable`.
        FileError
            If the file of its mesh is not there any more, or another one.

        Examples
        --------
        >>> from kanefe_fem import Material, Rectangle, beam_body, straight_beam
        >>> import kanefe as kf
        >>> rod = straight_beam(1.0, Rectangle(0.02, 0.02), Material(E=210e9, nu=0.3, rho=7850.0), elements=4)
        >>> body = beam_body(rod, {"root": "clamped"}, kf.CraigBampton(modes=4))
        >>> len(body.rebuilt(kf.CraigBampton(modes=8), refined=1).nodes)
        9
        """
        from kanefe.bodies.source import Changes, rebuilt_body

        body: Self = rebuilt_body(self, Changes(reduction, stiffening, refined, order))
        return body
