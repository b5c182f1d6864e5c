"""What figures are measured with: our side, the peer's process, and how much patience there is."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from benchmarks.clocks import FEW_ROUNDS, ROUNDS
from benchmarks.peer_process import NoPeers, Peers
from benchmarks.work_precision.curves import Limits


@dataclass(frozen=True)
class Machine:
    """What figures are measured with.

    Parameters
    ----------
    peers : Peers or None
        The peer's process; None where there is no environment for it.
    trouble : str
        Why there is none.
    limits : Limits
    all_cores : set of int
        Cores that this process had before it was kept on one.
    tests : Path or None
        The repository whose test suite is timed.
    """

    peers: Peers | None
    trouble: str
    limits: Limits
    all_cores: Collection[int] = ()
    tests: Path | None = None

    @property
    def rounds(self) -> int:
        """Rounds of a race."""
        return FEW_ROUNDS if self.limits.quick else ROUNDS

    def peer(self) -> Peers:
        """Return the peer's process.

        Raises
        ------
        NoPeers
            If there is none.
        """
        if self.peers is None:
            raise NoPeers(self.trouble)
        return self.peers
