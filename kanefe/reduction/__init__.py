"""From full-order matrices to flexible bodies: supports, bases, projection."""

from kanefe.factorise import splu_factorise as splu_factorise
from kanefe.reduction.body import flexible_body as flexible_body
from kanefe.reduction.methods import CraigBampton as CraigBampton
