"""Contact and friction: shapes, laws, and the load that presses them together."""

from typing import TYPE_CHECKING

from kanefe._public import lazy

if TYPE_CHECKING:
    from kanefe.contact import shapes as shapes
    from kanefe.contact.laws.bristles import LuGre as LuGre
    from kanefe.contact.laws.compiled_law import CompiledLaw as CompiledLaw
    from kanefe.contact.laws.friction_laws import Coulomb as Coulomb
    from kanefe.contact.laws.normal_laws import Hertz as Hertz
    from kanefe.contact.laws.normal_laws import HuntCrossley as HuntCrossley
    from kanefe.contact.laws.normal_laws import KelvinVoigt as KelvinVoigt
    from kanefe.contact.laws.normal_laws import Restitution as Restitution
    from kanefe.contact.laws.rigid import Rigid as Rigid
    from kanefe.contact.laws.table_law import TableLaw as TableLaw

_names, __getattr__, __dir__ = lazy(__file__, globals())
