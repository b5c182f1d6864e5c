"""Files and digests of arrays and dataclasses; independent of bodies."""
