"""What a disk does that is full."""

import errno
import os


def full_disk(*arguments: object, **options: object) -> None:
    """Raise the error of a full disk, whatever is asked."""
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
