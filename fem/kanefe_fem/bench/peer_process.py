"""The peers' process: it builds a scene once and is then asked for runs, so that ours can alternate with them."""

from __future__ import annotations

import json
import subprocess
import tempfile
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from kanefe_fem.bench.peer_environment import NoPeers, surroundings


class Peers:
    """A Python of the peers that answers requests, one line of JSON each.

    Parameters
    ----------
    python : Path
        Of their environment.
    server : Path
        The script that answers there.
    """

    def __init__(self, python: Path, server: Path) -> None:
        self._open = ExitStack()
        self._errors = self._open.enter_context(tempfile.TemporaryFile("w+"))  # noqa: SIM115  (closed by the stack)
        self._process = subprocess.Popen(
            [str(python), str(server)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            text=True,
            env=surroundings(),
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._process.stdin:
            self._process.stdin.close()
        if kind is not None:
            self._process.kill()
        self._process.wait()
        self._open.close()

    def ask(self, do: str, **request: Any) -> dict[str, Any]:
        """Return the answer to a request.

        Raises
        ------
        NoPeers
            If the process ended or answers with an error.
        """
        line = ""
        if self._process.stdin and self._process.stdout and self._process.poll() is None:
            self._process.stdin.write(json.dumps({"do": do, **request}) + "\n")
            self._process.stdin.flush()
            line = self._process.stdout.readline()
        if not line:
            self._errors.seek(0)
            raise NoPeers(f"the peers' process ended at {do!r}:\n{self._errors.read()[-800:]}")
        answer: dict[str, Any] = json.loads(line)
        if "error" in answer:
            raise NoPeers(f"the peers cannot {do}: {answer['error']}")
        return answer
