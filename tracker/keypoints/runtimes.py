"""What runs a network's file: LiteRT or ONNX Runtime where they are installed, OpenCV otherwise.

They agree to a hundredth of a pixel; the fast ones need less than half of OpenCV's time. All
compute on one thread, so that results do not depend on how many there are.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.errors import KeypointError
from keypose.tracker.scratch import Scratch

Tensor = NDArray[np.float32]
TFLITE = ".tflite"
ONNX = ".onnx"
_FAST: Final = {TFLITE: "ai-edge-litert", ONNX: "onnxruntime"}
"""By a file's suffix the package that runs it fast."""


_SILENT: Final = 0
"""OpenCV's level of logging at which it prints nothing."""


class Runtime(Protocol):
    """A network that has been read. name: of what runs it, with its version."""

    name: str

    def run(self, image: Tensor) -> list[Tensor]:
        """The outputs that were asked for, of an image (3, H, W). Of TFLite files some list
        the channels of maps last."""
        ...


def open_runtime(
    file: str, content: bytes, outputs: Sequence[str], *, fast: bool | None = None
) -> Runtime:
    """Read a network's file: these bytes, whatever lies on the disk by now.

    file: its name.  outputs: their names, in the order in which they are wanted.
    fast: by the package for such files; None: where it is installed.
    KeypointError in one sentence where the file cannot be run, or the package is not installed.
    """
    suffix = Path(file).suffix
    if fast is None:
        fast = fast_is_here(suffix)
    if fast and not fast_is_here(suffix):
        raise KeypointError(f"{_FAST[suffix]} is not installed: run `pip install {_FAST[suffix]}`.")
    fastest: type[_LiteRT | _OnnxRuntime] = _LiteRT if suffix == TFLITE else _OnnxRuntime
    kind: type[_LiteRT | _OnnxRuntime | _OpenCV] = fastest if fast else _OpenCV
    try:
        return kind(suffix, content, tuple(outputs))
    except Exception as error:  # noqa: BLE001  ONNX Runtime's have no other base
        network = f"The network {file!r}"
        raise cannot_run(network, runtime_name(suffix, fast), error) from None


def cannot_run(network: str, runtime: str, error: Exception) -> KeypointError:
    """Put what a library says of its failure into one sentence."""
    said = getattr(error, "err", "") or str(error).strip() or type(error).__name__
    why = said.splitlines()[0].rpartition("error: ")[2]
    is_fast = runtime.startswith(tuple(_FAST.values()))
    advice = "" if is_fast else " (what `pip install onnxruntime` installs may run it)"
    return KeypointError(f"{network} cannot be run by {runtime}{advice}: {why}")


def fast_is_here(suffix: str) -> bool:
    """Whether the fast package for such files is installed."""
    module = _FAST[suffix].replace("-", "_")
    return importlib.util.find_spec(module) is not None


def runtime_name(suffix: str, fast: bool | None = None) -> str:
    """What `Runtime.name` would be, with nothing read for it."""
    if fast_is_here(suffix) if fast is None else fast:
        return f"{_FAST[suffix]}-{importlib.metadata.version(_FAST[suffix])}"
    return f"opencv-{cv2.__version__}"


class _OpenCV:
    def __init__(self, suffix: str, content: bytes, outputs: tuple[str, ...]) -> None:
        engine = getattr(cv2.dnn, "ENGINE_CLASSIC" if suffix == TFLITE else "ENGINE_AUTO", None)
        read: Any = cv2.dnn.readNetFromTFLite if suffix == TFLITE else cv2.dnn.readNetFromONNX
        # By the path of a copy: from bytes, OpenCV 5 takes its new engine whatever is asked for,
        # and that one cannot run BlazePose; of ONNX it is the faster one.
        with Scratch("network") as folder, _quiet():
            copy = folder / f"network{suffix}"
            copy.write_bytes(content)
            self._net: Any = read(str(copy), *(() if engine is None else (engine,)))
        self._outputs = list(outputs)
        self.name = runtime_name(suffix, fast=False)

    def run(self, image: Tensor) -> list[Tensor]:
        with _one_thread():
            self._net.setInput(image[None])
            outputs: list[Tensor] = self._net.forward(self._outputs)
        return outputs


class _LiteRT:
    def __init__(self, _: str, content: bytes, outputs: tuple[str, ...]) -> None:
        from ai_edge_litert.interpreter import Interpreter

        with _unheard():
            self._net: Any = Interpreter(model_content=content, num_threads=1)
            self._net.allocate_tensors()
        self._input = self._net.get_input_details()[0]["index"]
        by_name = {o["name"]: o["index"] for o in self._net.get_output_details()}
        self._wanted = [by_name[name] for name in outputs]
        self.name = runtime_name(TFLITE, fast=True)

    def run(self, image: Tensor) -> list[Tensor]:
        self._net.set_tensor(self._input, np.ascontiguousarray(image.transpose(1, 2, 0))[None])
        self._net.invoke()
        return [self._net.get_tensor(i) for i in self._wanted]


class _OnnxRuntime:
    def __init__(self, _: str, content: bytes, outputs: tuple[str, ...]) -> None:
        import onnxruntime

        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.log_severity_level = 3
        self._net: Any = onnxruntime.InferenceSession(
            content, options, providers=["CPUExecutionProvider"]
        )
        self._input = self._net.get_inputs()[0].name
        self._outputs = list(outputs)
        self.name = runtime_name(ONNX, fast=True)

    def run(self, image: Tensor) -> list[Tensor]:
        outputs: list[Tensor] = self._net.run(self._outputs, {self._input: image[None]})
        return outputs


_HEARING: Final = threading.Lock()


@contextmanager
def _unheard() -> Iterator[None]:
    """LiteRT writes past Python, where errors are printed, that it began; nothing turns it off."""
    with _HEARING:
        try:
            before = os.dup(2)
        except OSError:  # a program without a terminal
            yield
            return
        nowhere = os.open(os.devnull, os.O_WRONLY)
        try:
            os.dup2(nowhere, 2)
            yield
        finally:
            os.dup2(before, 2)
            os.close(nowhere)
            os.close(before)


@contextmanager
def _quiet() -> Iterator[None]:
    """OpenCV prints nothing of what it raises as well."""
    before = _set_log_level(_SILENT)
    try:
        yield
    finally:
        _set_log_level(before)


def _set_log_level(level: int) -> int:
    """Set how much OpenCV prints; how much it did before. OpenCV 4 has it in another place."""
    here: Any = cv2 if hasattr(cv2, "setLogLevel") else cv2.utils.logging
    before: int = here.setLogLevel(level)
    return before


_threads_lock = threading.Lock()
_threads_before: list[int] = []
"""OpenCV's number of threads before each network that runs now."""


@contextmanager
def _one_thread() -> Iterator[None]:
    """OpenCV computes on this thread alone; its setting is the program's, so it is put back."""
    with _threads_lock:
        _threads_before.append(cv2.getNumThreads())
        cv2.setNumThreads(1)
    try:
        yield
    finally:
        with _threads_lock:
            before = _threads_before.pop()  # the last one out has the first one's
            if not _threads_before:
                cv2.setNumThreads(before)
