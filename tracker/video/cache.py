"""The pictures used last, as many as fit a number of bytes."""

from __future__ import annotations

from collections import OrderedDict

from keypose.tracker.video.picture import Picture


class PictureCache:
    """Keeps the pictures put or got last. The newest is kept even when it alone is too large."""

    def __init__(self, byte_limit: int) -> None:
        self._byte_limit = byte_limit
        self._bytes = 0
        self._pictures: OrderedDict[int, Picture] = OrderedDict()

    def get(self, number: int) -> Picture | None:
        picture = self._pictures.get(number)
        if picture is not None:
            self._pictures.move_to_end(number)
        return picture

    def put(self, number: int, picture: Picture) -> None:
        old = self._pictures.pop(number, None)
        self._bytes += picture.nbytes - (0 if old is None else old.nbytes)
        self._pictures[number] = picture
        while self._bytes > self._byte_limit and len(self._pictures) > 1:
            _, dropped = self._pictures.popitem(last=False)
            self._bytes -= dropped.nbytes

    def clear(self) -> None:
        self._pictures.clear()
        self._bytes = 0
