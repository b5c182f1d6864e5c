"""Files and digests of arrays and dataclasses. It knows no body."""
