"""HDF5 files from elsewhere, read with h5py from their own bytes alone.

A file may point into other files of the computer, by external links, external storage or virtual
datasets; and it may claim more numbers than it has bytes. Neither is followed or allocated.
"""

from __future__ import annotations

import io
import pickle
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.errors import FormatError

MAGIC: Final = b"\x89HDF\r\n\x1a\n"
MOST_VALUES: Final = 60_000_000
"""Of one dataset."""


class Group:
    """A group of an HDF5 file whose members are read by name."""

    def __init__(self, file: str, group: Any) -> None:
        self.file, self._group = file, group

    @property
    def names(self) -> list[str]:
        return [str(name) for name in self._group]

    def has(self, *names: str) -> bool:
        return all(name in self._group for name in names)

    def text(self, attribute: str) -> str:
        """An attribute as text, empty where it is none."""
        return _text(self._group.attrs.get(attribute, ""))

    def group(self, name: str) -> Group | None:
        """A group within; None where there is none of that name."""
        import h5py

        member = self._own(name)
        return Group(self.file, member) if isinstance(member, h5py.Group) else None

    def values(self, name: str) -> NDArray[Any]:
        """All of a dataset; FormatError where there is none, or it is elsewhere or too large."""
        dataset = self._dataset(name)
        if dataset.size is None or dataset.size > MOST_VALUES:
            raise FormatError(f"{self.file}: its {name} has too many numbers.")
        return np.asarray(dataset[()])

    def numbers(self, name: str) -> NDArray[np.float64]:
        """A dataset of real numbers."""
        values = self.values(name)
        if values.dtype.kind not in "fiub":
            raise FormatError(f"{self.file}: its {name} are not numbers.")
        return values.astype(np.float64)

    def texts(self, name: str) -> list[str]:
        """A dataset of text."""
        return [_text(value) for value in self.values(name).ravel().tolist()]

    def dataset_text(self, name: str, attribute: str) -> str:
        """An attribute of a dataset as text, empty where it is none."""
        return _text(self._dataset(name).attrs.get(attribute, ""))

    def dataset_literal(self, name: str, attribute: str) -> Any:
        """An attribute of a dataset that Python wrote as a pickle: lists and text, nothing else."""
        return _literal(self.file, self._dataset(name).attrs.get(attribute, b""))

    def _dataset(self, name: str) -> Any:
        import h5py

        dataset = self._own(name)
        if not isinstance(dataset, h5py.Dataset):
            raise FormatError(f"{self.file} has no {name}.")
        if dataset.external or dataset.is_virtual:
            raise self._elsewhere(name)
        return dataset

    def _own(self, name: str) -> Any:
        import h5py

        link = self._group.get(name, getlink=True)
        if link is None:
            return None
        if not isinstance(link, h5py.HardLink):
            raise self._elsewhere(name)
        return self._group[name]

    def _elsewhere(self, name: str) -> FormatError:
        return FormatError(
            f"{self.file}: its {name} is only a link to somewhere else; export it anew."
        )


@contextmanager
def opened(file: str, content: bytes) -> Iterator[Group]:
    """The root of an HDF5 file; FormatError in one sentence for whatever is wrong within."""
    try:
        import h5py
    except ImportError:
        raise FormatError(
            f"{file} is HDF5, which needs h5py: pip install 'keypose[h5]', or export it as CSV."
        ) from None
    try:
        with h5py.File(io.BytesIO(content), "r") as root:
            yield Group(file, root)
    except FormatError:
        raise
    except Exception:  # noqa: BLE001 — whatever foreign bytes bring about
        raise FormatError(
            f"{file} is no whole HDF5 file: it may have been cut short; copy or export it anew."
        ) from None


def _text(value: Any) -> str:
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    return value if isinstance(value, str) else ""


class _Literals(pickle.Unpickler):
    """Makes lists, tuples, text and numbers, and calls nothing: a pickle could call anything."""

    def find_class(self, module: str, name: str) -> Any:
        raise pickle.UnpicklingError(f"{module}.{name}")


def _literal(file: str, value: Any) -> Any:
    try:
        return _Literals(io.BytesIO(bytes(value))).load()
    except Exception:  # noqa: BLE001 — whatever foreign bytes bring about
        raise FormatError(f"{file} names its columns in no way known: use its CSV.") from None
