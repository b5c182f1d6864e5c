"""From full-order matrices to flexible bodies: supports, bases, projection."""

from kanefe.fe_model.factorise import splu_factorise as splu_factorise
from kanefe.reduction.build import flexible_body as flexible_body
from kanefe.reduction.craig_bampton import CraigBampton as CraigBampton
from kanefe.reduction.free_interface import FreeInterface as FreeInterface
from kanefe.reduction.krylov import Krylov as Krylov
from kanefe.reduction.load_cases import LoadCase as LoadCase
from kanefe.reduction.patch_case import PatchCase as PatchCase
