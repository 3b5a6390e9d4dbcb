"""Folders as `insectnav run` leaves them, made by hand: whole, or with whatever a test wants to be wrong."""

import json
import struct
import zlib
from pathlib import Path
from typing import Any

from insectnav.experiments.published import Verdict, write_verdicts

PROVENANCE: dict[str, Any] = {
    "scale": "quick", "seed": 3, "cells": 4, "cells_from_earlier_run": 0, "code": "0" * 12, "insectnav": "0.0.1",
    "python": "3.12.1", "machine": {"system": "Linux", "processor": "x86_64", "cores": 4},
    "finished": "2026-01-02T03:04:05+00:00", "seconds": 83.4,
}  # fmt: skip


def png(width: int = 4, height: int = 3) -> bytes:
    """A white picture, from the definition of the format."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    pixels = zlib.compress((b"\0" + b"\xff" * width) * height)
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")


def verdict(**other: Any) -> Verdict:
    values: dict[str, Any] = {
        "quantity": "speed of light", "published": 299.792, "low": 299.7, "high": 299.9, "ours": 299.8,
        "uncertainty": 0.0123, "unit": "Mm/s", "verdict": "agrees", "why": "", "source": "Table 1",
        "how_read": "printed",
    }  # fmt: skip
    return Verdict(**(values | other))


def leave(
    out: Path, name: str, key: str = "abc", files: dict[str, bytes] | None = None, verdicts: Any = None, **other: Any
) -> Path:
    """A result of the experiment ``name``; ``other`` goes to its provenance, ``files`` replace what there is."""
    folder = out / name / key
    folder.mkdir(parents=True)
    provenance = PROVENANCE | {"experiment": name, "key": key} | other
    (folder / "provenance.json").write_text(json.dumps(provenance), encoding="utf-8")
    (folder / "caption.txt").write_text("What is shown (n = 7 trials).\n", encoding="utf-8")
    (folder / "figure.png").write_bytes(png())
    write_verdicts(folder / "comparison.csv", [verdict()] if verdicts is None else verdicts)
    for file, content in (files or {}).items():
        (folder / file).write_bytes(content)
    return folder
