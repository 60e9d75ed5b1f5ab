"""Colours, and a brush that paints in metres onto an oversampled canvas, which is reduced for smooth edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw

from motionsplice.motion.quaternion import Floats

Colour = tuple[int, int, int]

WHITE: Colour = (255, 255, 255)
OVERSAMPLING = 4


def mixed(colour: Colour, white: float) -> Colour:
    """Returns `colour` mixed with the fraction `white` (0 to 1) of white."""
    red, green, blue = (round(value + white * (255 - value)) for value in colour)
    return red, green, blue


def canvas(width: int, height: int) -> Image.Image:
    """Returns a white canvas for a picture of `width` x `height` pixels."""
    return Image.new("RGB", (width * OVERSAMPLING, height * OVERSAMPLING), WHITE)


def reduced(image: Image.Image) -> Image.Image:
    """Returns the picture on a canvas, reduced to the picture's size."""
    return image.reduce(OVERSAMPLING)


@dataclass(frozen=True)
class Brush:
    """Paints on a canvas; coordinates are in metres, to the right of and above an origin.

    image:  the canvas.
    origin: the origin in pixels of the picture, from its top left.
    scale:  pixels of the picture per metre.
    """

    image: Image.Image
    origin: tuple[float, float]
    scale: float

    def disc(self, centre: Floats, radius: float, colour: Colour, *, flatness: float = 1.0) -> None:
        """Paints a disc of `radius` metres around `centre` [2]; its height is `flatness` times its width."""
        x, y = self._pixels(centre)
        rx = radius * self.scale * OVERSAMPLING
        ry = rx * flatness
        self._draw.ellipse((x - rx, y - ry, x + rx, y + ry), fill=colour)

    def polygon(self, corners: Floats, colour: Colour) -> None:
        """Paints a filled polygon with `corners` [n, 2]."""
        self._draw.polygon([(round(x), round(y)) for x, y in self._pixels(corners)], fill=colour)

    def taper(self, start: Floats, stop: Floats, start_radius: float, stop_radius: float, colour: Colour) -> None:
        """Paints a bone from `start` [2] to `stop` [2] with round ends, tapering between the two radii, in metres."""
        along = stop - start
        length = float(np.hypot(*along))
        if length > 1e-9:
            across = np.array([-along[1], along[0]]) / length
            sides = (start_radius * across, stop_radius * across)
            self.polygon(np.stack([start + sides[0], stop + sides[1], stop - sides[1], start - sides[0]]), colour)
        self.disc(start, start_radius, colour)
        self.disc(stop, stop_radius, colour)

    @property
    def _draw(self) -> ImageDraw.ImageDraw:
        return ImageDraw.Draw(self.image)

    def _pixels(self, points: Floats) -> Floats:
        return (points * [self.scale, -self.scale] + self.origin) * OVERSAMPLING
