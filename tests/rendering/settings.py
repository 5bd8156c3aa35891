"""What a rendered sequence looks like."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Occluder:
    """An opaque upright bar in front of everything, in pixels, that stands still."""

    left_px: float
    width_px: float
    colour: tuple[float, float, float] = (96.0, 84.0, 74.0)


@dataclass(frozen=True)
class RenderSettings:
    """Grey levels run from 0 to 255; everything random follows from the seed.

    texture_contrast:     standard deviation of the body's texture, grey levels; 4 is texture-poor.
    background_contrast:  the same for the background.
    pan_px_per_frame:     how far the background moves to the left from frame to frame.
    noise:                standard deviation of every pixel's own noise, grey levels.
    flicker:              every frame's gain lies within 1 ± flicker.
    illumination_ramp:    the gain grows by this much from the first to the last frame.
    shutter:              share of the frame time the shutter is open: 0 is sharp, 0.5 a film.
    sub_frames:           pictures averaged for motion blur.
    ambient:              share of the light that comes from everywhere.
    samples:              samples along each side of a pixel.
    """

    seed: int = 0
    texture_contrast: float = 28.0
    background_contrast: float = 20.0
    pan_px_per_frame: float = 0.0
    noise: float = 1.5
    flicker: float = 0.0
    illumination_ramp: float = 0.0
    shutter: float = 0.0
    sub_frames: int = 5
    ambient: float = 0.5
    samples: int = 3
    occluder: Occluder | None = None
