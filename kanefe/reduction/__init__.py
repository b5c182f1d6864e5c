"""From full-order matrices to flexible bodies: supports, bases, projection."""

from kanefe.factorise import splu_factorise as splu_factorise
from kanefe.reduction.body import flexible_body as flexible_body
from kanefe.reduction.enriched import Enriched as Enriched
from kanefe.reduction.free_interface import FreeInterface as FreeInterface
from kanefe.reduction.krylov import Krylov as Krylov
from kanefe.reduction.load_cases import LoadCase as LoadCase
from kanefe.reduction.methods import CraigBampton as CraigBampton
