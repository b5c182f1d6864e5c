"""What a load without a kernel does, as its `action` in Python has said."""

from typing import Any

from kanefe.kernels.force_elements.places import SIGNATURE
from kanefe.kernels.language import called_by_address


@called_by_address(*SIGNATURE)
def given(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write what comes as inputs, `numbers[0]` of them."""
    for i in range(int(numbers[0])):
        out[i] = inputs[i]
