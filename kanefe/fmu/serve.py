"""The process that steps a scene with Python functions for a functional mock-up unit: see `source/served.c`.

A request is two whole numbers, its kind and a count, and as many floats. A reply is zero, a count and the floats; or
one, the length of a message and the message.
"""

from __future__ import annotations

import os
import pickle
import socket
import struct
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from kanefe._version import __version__
from kanefe.errors import FileError, ModelError
from kanefe.stepping.asked import Asked
from kanefe.stepping.simulation import Simulation, started
from kanefe.stepping.steppable import Steppable
from kanefe.storage.functions_by_value import dumps_by_value

RESET, BEGIN_AT, STEP, OUTPUTS = range(4)
HEAD = struct.Struct("=qq")


def packed(scene: Steppable, asked: Asked) -> bytes:
    """Return a scene and its request as the bytes that `serve` takes.

    Raises
    ------
    ModelError
        If functions of the scene cannot be sent to another process.
    """
    dumps = dumps_by_value() or pickle.dumps
    try:
        return dumps((__version__, scene, asked))
    except Exception as error:  # objects of users may raise anything
        raise ModelError(
            f"the scene cannot be sent to the process that steps it: {error}. Remedy: functions of a module in place "
            "of local ones, or pip install cloudpickle"
        ) from error


class Server:
    """Server of a scene that replies to requests.

    Parameters
    ----------
    path : path
        File with the bytes that `packed` returned.
    """

    def __init__(self, path: Path) -> None:
        version, self._scene, self._asked = pickle.loads(path.read_bytes())
        if version != __version__:
            raise FileError(
                f"the unit was made by kanefe {version}, and this Python has {__version__}. Remedy: install the former"
            )
        self._sim: Simulation = started(self._scene, self._asked)
        self._start = self._sim.save()

    def answer(self, what: int, numbers: np.ndarray) -> list[float]:
        """Carry out a request; return the numbers of the reply."""
        sim = self._sim
        if what == RESET:
            sim.restore(self._start)
        elif what == BEGIN_AT:
            t, options = float(numbers[0]), self._asked.options
            start, stop = options.span
            options = replace(options, t_span=(t, t + stop - start))
            self._sim = sim = started(self._scene, self._asked._replace(options=options))
            self._start = sim.save()
        elif what == STEP:
            sim.step(float(numbers[0]), dict(zip(sim.input_names, numbers[1:].tolist(), strict=True)))
            if not sim.status.is_finished:
                raise ModelError(str(sim.status))
            return [sim.time]
        else:
            return list(sim.outputs_with(dict(zip(sim.input_names, numbers.tolist(), strict=True))).values())
        return list(sim.inputs.values())


def serve(line: socket.socket, path: Path) -> None:
    """Reply until the other side closes the connection."""
    server: Server | None = None
    while head := _taken(line, HEAD.size):
        what, count = HEAD.unpack(head)
        numbers = np.frombuffer(_taken(line, 8 * count))
        try:
            server = server or Server(path)
            found = np.array(server.answer(what, numbers))
            line.sendall(HEAD.pack(0, len(found)) + found.tobytes())
        except Exception as error:  # noqa: BLE001 - it is reported, and the scene is unchanged
            message = f"{type(error).__name__}: {error}".encode()
            line.sendall(HEAD.pack(1, len(message)) + message)


def _taken(line: socket.socket, size: int) -> bytes:
    parts = b""
    while len(parts) < size and (part := line.recv(size - len(parts))):
        parts += part
    return parts if len(parts) == size else b""


def main(number: str, path: str) -> None:
    """Serve on an inherited socket; the output of functions goes to the standard error."""
    os.dup2(2, 1)
    with socket.socket(fileno=int(number)) as line:
        serve(line, Path(path))


if __name__ == "__main__":
    main(*sys.argv[1:])
