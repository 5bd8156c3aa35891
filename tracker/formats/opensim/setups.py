"""The setups of OpenSim's tools: how to scale a model to our body, and to follow our markers.

markers.xml   our markers on the model as it is, before it is scaled
scale.xml     for the Scale Tool: factors of every body, nothing measured
ik.xml        for the Inverse Kinematics Tool: the scaled model follows motion.trc
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from keypose.tracker.formats.opensim.model import Scaled
from keypose.tracker.geometry.rotations import Array

OPENSIM_DOCUMENT_VERSION = "40000"
MARKERS_FILE = "markers.xml"
SCALE_FILE = "scale.xml"
IK_FILE = "ik.xml"
MOTION_FILE = "motion.mot"
ERRORS_FILE = "motion-errors.mot"

BESIDE_WEIGHT = (0.01 / math.radians(10)) ** 2
"""Ten degrees count like one marker a centimetre off: little beside markers that show the angle."""


def markers_xml(sizes: Scaled) -> str:
    """The marker set; places are divided by the factors that the Scale Tool will apply to them."""
    root, objects = _set_of("MarkerSet", "keypose")
    for name, (body, place) in sizes.placed.items():
        marker = SubElement(objects, "Marker", name=name)
        _text(marker, "socket_parent_frame", f"/bodyset/{body}")
        _text(marker, "location", _numbers(place / sizes.factors[body]))
        _text(marker, "fixed", "true")
    return _written(root)


def scale_xml(sizes: Scaled, model_path: str, scaled_path: str) -> str:
    """The setup of the Scale Tool, which makes scaled_path; paths are relative to its own."""
    root = _document()
    tool = SubElement(root, "ScaleTool", name="keypose")
    _text(tool, "mass", "-1")
    maker = SubElement(tool, "GenericModelMaker")
    _text(maker, "model_file", model_path)
    _text(maker, "marker_set_file", MARKERS_FILE)
    scaler = SubElement(tool, "ModelScaler")
    _text(scaler, "apply", "true")
    _text(scaler, "scaling_order", "manualScale")
    scales = SubElement(SubElement(scaler, "ScaleSet"), "objects")
    for body, factors in sizes.factors.items():
        scale = SubElement(scales, "Scale")
        _text(scale, "scales", _numbers(factors))
        _text(scale, "segment", body)
        _text(scale, "apply", "true")
    _text(scaler, "preserve_mass_distribution", "true")
    _text(scaler, "output_model_file", scaled_path)
    return _written(root)


def ik_xml(
    markers: Iterable[str],
    model_path: str,
    times_s: tuple[float, float],
    beside: Iterable[str] = (),
) -> str:
    """The setup of the Inverse Kinematics Tool, all markers with the same weight.

    beside: coordinates that stay near motion.mot, as far as the markers let them.
    """
    root = _document()
    tool = SubElement(root, "InverseKinematicsTool", name="keypose")
    _text(tool, "model_file", model_path)
    _text(tool, "marker_file", "motion.trc")
    _text(tool, "time_range", _numbers(times_s))
    kept = tuple(beside)
    if kept:
        _text(tool, "coordinate_file", MOTION_FILE)
    _text(tool, "output_motion_file", "ik.mot")
    _text(tool, "report_errors", "true")
    objects = SubElement(SubElement(tool, "IKTaskSet"), "objects")
    for name in markers:
        task = SubElement(objects, "IKMarkerTask", name=name)
        _text(task, "apply", "true")
        _text(task, "weight", "1")
    for name in kept:
        task = SubElement(objects, "IKCoordinateTask", name=name)
        _text(task, "apply", "true")
        _text(task, "weight", f"{BESIDE_WEIGHT:.6f}")
        _text(task, "value_type", "from_file")
    return _written(root)


def _document() -> Element:
    return Element("OpenSimDocument", Version=OPENSIM_DOCUMENT_VERSION)


def _set_of(kind: str, name: str) -> tuple[Element, Element]:
    root = _document()
    return root, SubElement(SubElement(root, kind, name=name), "objects")


def _text(parent: Element, name: str, words: str) -> None:
    SubElement(parent, name).text = words


def _numbers(values: Iterable[float] | Array) -> str:
    return " ".join(f"{value:.6f}" for value in values)


def _written(root: Element) -> str:
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"
