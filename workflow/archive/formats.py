"""What a file is, by its first bytes, and its bytes unpacked."""

from __future__ import annotations

import bz2
import gzip
import io
import lzma
import os
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from typing import Any, BinaryIO, cast

from workflow.data.files import PathLike
from workflow.data.text import shown
from workflow.errors import ArchiveError, EnvironmentFault, InputError

HEAD = 4096  # bytes that tell what a file is
BUFFER = 1 << 20
DUMP = b"ITEM: "
TEXT_DUMP = "give a text dump (dump custom of grains, dump local of contacts), plain or compressed"


def _zstd(path: PathLike) -> BinaryIO:
    """Python from 3.14 on reads Zstandard itself; before, the package zstandard does."""
    with suppress(ImportError):
        return cast(BinaryIO, import_module("compression.zstd").open(path, "rb"))
    try:
        reader: Any = import_module("zstandard")
    except ImportError:
        raise EnvironmentFault(
            f"'{path}' is compressed with Zstandard, which needs the package zstandard; pip install zstandard, or unpack "
            f"it with 'zstd -d {path}'"
        ) from None
    return cast(BinaryIO, reader.ZstdDecompressor().stream_reader(open(path, "rb"), read_across_frames=True))


PACKED: dict[bytes, tuple[str, Callable[[PathLike], Any]]] = {
    b"\x1f\x8b": ("gzip", gzip.GzipFile),
    b"\x28\xb5\x2f\xfd": ("Zstandard", _zstd),
    b"BZh": ("bzip2", bz2.BZ2File),
    b"\xfd7zXZ\x00": ("xz", lzma.LZMAFile),
}


class _Stream(io.RawIOBase):
    """Unpacked bytes; whatever the decompressor finds wrong is an OSError."""

    def __init__(self, source: Any) -> None:
        self.source, self.place = source, 0

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        try:
            data = self.source.read(len(buffer))
        except Exception as fault:  # each package has errors of its own
            raise OSError(str(fault)) from None
        buffer[: len(data)] = data
        self.place += len(data)
        return len(data)

    def tell(self) -> int:
        return self.place

    def close(self) -> None:
        self.source.close()
        super().close()


# first bytes, what the file is, what to give instead
OTHERS: tuple[tuple[bytes, str, str], ...] = (
    (b"\x89HDF", "an HDF5 file", "give the run directory that holds it, or a text dump"),
    (b"\xdf\x65\xdf\x65\xdf\x65\xdf\x65", "a GSD file", "give the run directory or the dumps it was made from, or a text dump"),
    (b"CDF", "a NetCDF file", TEXT_DUMP),
    (b"PK\x03\x04", "a ZIP archive", "unpack it and give the dumps in it"),
    (b"\x93NUMPY", "a NumPy array", "use workflow.data.build.make_frame in Python"),
    (b"PAR1", "a Parquet table", TEXT_DUMP),
    (b"\x89PNG", "a picture", TEXT_DUMP),
    (b"%PDF", "a PDF", TEXT_DUMP),
    (b"LammpS RestartT", "a LAMMPS restart file", "read it with LAMMPS (read_restart, write_dump) and give the dump"),
    (b"# vtk", "a VTK file", TEXT_DUMP),
    (b"<?xml", "an XML file", TEXT_DUMP),
    (b"<VTKFile", "a VTK file", TEXT_DUMP),
    (b"<!DOCTYPE", "an HTML page", TEXT_DUMP),
    (b"---\ncreator: LAMMPS", "a YAML dump of LAMMPS", TEXT_DUMP),
    (b"{", "a JSON file", TEXT_DUMP),
    (b"LAMMPS (", "a log of LAMMPS", TEXT_DUMP),
    (b"# step time", "a time series of this package", "give the run directory that holds it"),
)


def unpacked(path: PathLike) -> tuple[BinaryIO, str]:
    """The bytes of a file, decompressed, and how it is packed ("" if not).  Raises ArchiveError if it cannot be opened."""
    try:
        if not os.path.isfile(path):
            words = "is a directory" if os.path.isdir(path) else "is no regular file" if os.path.exists(path) else "not found"
            raise ArchiveError(f"cannot read '{path}': it {words}; give the path of a dump")
        with open(path, "rb") as file:
            head = file.read(HEAD)
        for magic, (name, opened) in PACKED.items():
            if head.startswith(magic):
                return cast(BinaryIO, io.BufferedReader(_Stream(opened(path)), BUFFER)), name
        return open(path, "rb", buffering=BUFFER), ""
    except OSError as error:
        raise ArchiveError(f"cannot read '{path}': {error.strerror}; check the path and that the run started") from None


def misfit(path: PathLike, head: bytes) -> InputError:
    """Says what a file is that is no text dump, from its first bytes."""
    what, instead = _kind(head)
    return InputError(f"'{path}' is {what}, no LAMMPS dump in text form; {instead}")


def _kind(head: bytes) -> tuple[str, str]:
    if not head.strip():
        return "empty", "give a dump that was written to"
    for magic, what, instead in OTHERS:
        if head.startswith(magic):
            return what, instead
    # the magic word of a binary dump follows its negated length; before LAMMPS of 2020 it began with the step
    if b"DUMPATOM" in head[:64] or b"DUMPCUSTOM" in head[:64]:
        return "a binary dump", "convert it with LAMMPS' tool binary2txt, or let the deck write a file without the ending .bin"
    if b"\0" in head or sum(byte < 9 for byte in head) > 0:
        return "a binary file", TEXT_DUMP
    return _text_kind(head)


def _text_kind(head: bytes) -> tuple[str, str]:
    lines = [line.strip() for line in head.split(b"\n")[:40]]
    words = {b" ".join(line.split()[1:3]) for line in lines if line[:1].isdigit()}
    if b"LAMMPS data file" in lines[0] or {b"atoms", b"atom types"} & words:
        return "a data file of LAMMPS", "it has no forces; give a dump"
    if lines[0].isdigit():
        return "an XYZ file, or a table that begins with a number", TEXT_DUMP
    if lines[0].count(b",") > 1:
        return "a table with commas (CSV)", "give the dump or the run directory it was made from"
    if any(line.startswith((b"pair_style", b"units ", b"atom_style")) for line in lines):
        return "an input script", "run it, and give the dump it writes"
    if any(line.startswith(b"scene =") for line in lines):
        return "a scene file", "'wf run' it, and give the run directory"
    return f"a text that begins with '{shown(lines[0])}'", TEXT_DUMP
