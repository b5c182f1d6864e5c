"""Loads, one concept a file. What is imported here is public: users write loads of their own by it."""

from kanefe.loads.base import Action as Action
from kanefe.loads.base import End as End
from kanefe.loads.base import Load as Load
from kanefe.loads.base import LoadEvent as LoadEvent
from kanefe.loads.base import LoadKernel as LoadKernel
from kanefe.loads.base import Tangent as Tangent
from kanefe.loads.rope import Rope as Rope
