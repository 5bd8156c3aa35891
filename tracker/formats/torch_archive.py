"""Tensors of a PyTorch file (.pt) as arrays, without PyTorch and without running anything.

Since PyTorch 1.6 such a file is a zip archive: `<name>/data.pkl` is a pickle of dicts and lists in
which tensors refer to numbers beside it, `<name>/data/<key>`. A pickle may call whatever is
installed; here it may call what makes a tensor, which is ours, and nothing else.
"""

from __future__ import annotations

import io
import pickle
import pickletools
import zipfile
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

MOST_BYTES: Final = 256 * 2**20
"""Of all numbers in a file, and of all tensors made of them."""
DEEPEST: Final = 8
"""Objects within objects."""
_PUTS: Final = ("PUT", "BINPUT", "LONG_BINPUT")
_STORAGES: Final = {
    "DoubleStorage": "<f8",
    "FloatStorage": "<f4",
    "HalfStorage": "<f2",
    "LongStorage": "<i8",
    "IntStorage": "<i4",
    "ShortStorage": "<i2",
    "CharStorage": "i1",
    "ByteStorage": "u1",
    "BoolStorage": "?",
}


def torch_arrays(content: bytes) -> dict[str, NDArray[Any]]:
    """The tensors in nested dicts, their keys joined by dots; ValueError says what is wrong."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            tree = _Tensors(archive).load()
    except ValueError:
        raise
    except Exception as error:  # noqa: BLE001 — whatever foreign bytes bring about
        raise ValueError(f"{type(error).__name__} while reading it") from None
    arrays: dict[str, NDArray[Any]] = {}
    _collect(tree, (), arrays, set())
    return arrays


def _require_honest_memo(content: bytes) -> None:
    """Memory is taken for as many memos as the largest number of one says."""
    for opcode, argument, _ in pickletools.genops(content):
        if opcode.name in _PUTS and isinstance(argument, int) and argument > len(content):
            raise ValueError("it is damaged")


def _collect(
    tree: Any, path: tuple[str, ...], arrays: dict[str, NDArray[Any]], met: set[int]
) -> None:
    """met: the dicts that were met, each once: one may hold itself under many names."""
    if isinstance(tree, np.ndarray):
        arrays[".".join(path)] = tree
    elif isinstance(tree, Mapping) and len(path) < DEEPEST and id(tree) not in met:
        met.add(id(tree))
        for key, value in tree.items():
            _collect(value, (*path, str(key)), arrays, met)


class _Tensors(pickle.Unpickler):
    """Of one archive."""

    def __init__(self, archive: zipfile.ZipFile) -> None:
        entries = {entry.filename: entry for entry in archive.infolist()}
        name = next((name for name in entries if name.endswith("/data.pkl")), None)
        if name is None or sum(entry.file_size for entry in entries.values()) > MOST_BYTES:
            raise ValueError("it is too large" if name else "it holds no data.pkl")
        if any(entry.compress_type != zipfile.ZIP_STORED for entry in entries.values()):
            raise ValueError("it is compressed, as PyTorch does not write it")
        self._archive, self._folder, self._left = archive, name.removesuffix("data.pkl"), MOST_BYTES
        content = archive.read(name)
        _require_honest_memo(content)
        super().__init__(io.BytesIO(content))

    def find_class(self, module: str, name: str) -> Callable[..., Any] | str | type:
        if (module, name) == ("torch._utils", "_rebuild_tensor_v2"):
            return self._tensor
        if (module, name) == ("collections", "OrderedDict"):
            return dict
        if module == "torch" and name in _STORAGES:
            return _STORAGES[name]
        raise ValueError(f"it holds {module}.{name}, which may run code")

    def persistent_load(self, pid: Any) -> NDArray[Any]:
        """The numbers that a tensor is made of."""
        kind, dtype, key, _device, _count = pid
        if kind != "storage" or dtype not in _STORAGES.values():
            raise ValueError("it holds something else than tensors")
        return np.frombuffer(self._archive.read(f"{self._folder}data/{key}"), dtype)

    def _tensor(
        self,
        storage: NDArray[Any],
        offset: int,
        size: tuple[int, ...],
        stride: tuple[int, ...],
        *_: Any,
    ) -> NDArray[Any]:
        whole = (offset, *size, *stride)
        if not all(type(n) is int and 0 <= n < 2**40 for n in whole) or len(size) != len(stride):
            raise ValueError("it holds a tensor of no shape")
        count = int(np.prod([1, *size], dtype=object))
        self._left -= count * storage.itemsize
        last = offset + sum((n - 1) * step for n, step in zip(size, stride, strict=True))
        if self._left < 0 or (count and last >= len(storage)):
            raise ValueError("it holds a tensor larger than its numbers")
        strides = [step * storage.itemsize for step in stride]
        return np.lib.stride_tricks.as_strided(storage[offset:], size, strides).copy()
