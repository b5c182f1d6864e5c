"""Bodies of several segments as one in results."""

from types import SimpleNamespace

from kanefe.results.wholes import numbers_of_parts


def test_nodes_of_cuts_belong_to_the_segment_nearer_to_the_base() -> None:
    """Their copies in the segments beyond follow all others."""
    nodes = {"arm 1": [0, 1], "arm 2": [1, 2], "arm 3": [2, 3]}
    numbers = {}
    for base in range(3):
        shapes = {n: SimpleNamespace(provenance={"segment": {"base": base, "nodes": at}}) for n, at in nodes.items()}
        numbers[base] = numbers_of_parts(shapes, list(nodes)).tolist()
    assert numbers == {0: [0, 1, 4, 2, 5, 3], 1: [0, 4, 1, 2, 5, 3], 2: [0, 5, 1, 4, 2, 3]}
