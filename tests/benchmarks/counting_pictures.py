"""Run ``count-video`` and keep count of the pictures that PyAV decodes for it.

``python counting_pictures.py TALLY SECONDS ARGUMENT...`` runs the command with these arguments in
this process. TALLY is a file of eight bytes that holds the number of pictures so far, so that it is
right even when the command is ended on its way; SECONDS of processor time end it, 0 for no limit.
"""

from __future__ import annotations

import ctypes
import gc
import mmap
import os
import resource
import runpy
import sys
from collections.abc import Callable
from typing import Any

# The command sets this before numpy is imported; so it must be set before PyAV is.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from av.codec.context import CodecContext

TALLY_BYTES = 8


def count_pictures(tally: mmap.mmap) -> None:
    """Count in ``tally`` what PyAV decodes from now on, in whichever way it is asked to.

    A container, a stream and a packet all decode by the codec context's method. A compiled class
    refuses a new attribute, so the method is exchanged in the dictionary beneath the class.
    """
    methods: dict[str, Any] = gc.get_referents(CodecContext.__dict__)[0]
    decode: Callable[..., list[Any]] = methods["decode"]
    total = 0

    def counted(*arguments: Any) -> list[Any]:
        nonlocal total
        pictures = decode(*arguments)
        total += len(pictures)
        tally[:TALLY_BYTES] = total.to_bytes(TALLY_BYTES, "little")
        return pictures

    methods["decode"] = counted
    ctypes.pythonapi.PyType_Modified(ctypes.py_object(CodecContext))


def main() -> None:
    """Count the pictures of one run of the command."""
    place, limit_s, *arguments = sys.argv[1:]
    if int(limit_s):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        # At the first of the two the process is sent SIGXCPU, which names the reason.
        resource.setrlimit(resource.RLIMIT_CPU, (int(limit_s), int(limit_s) + 5))
    with open(place, "r+b") as file:
        count_pictures(mmap.mmap(file.fileno(), TALLY_BYTES))
    sys.argv = ["count-video", *arguments]
    runpy.run_module("count_video", run_name="__main__")


if __name__ == "__main__":
    main()
