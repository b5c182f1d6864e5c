"""Contact and friction: shapes, laws, and the load between them."""

from typing import TYPE_CHECKING

from kanefe._public import lazy

if TYPE_CHECKING:
    from kanefe.contact import shapes as shapes
    from kanefe.contact.rigid.rigid import Rigid as Rigid
    from kanefe.kernels.contact.laws import *  # noqa: F403

_names, __getattr__, __dir__ = lazy(__file__, globals())
