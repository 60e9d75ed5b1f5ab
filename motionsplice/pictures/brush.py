"""Colours, and painting in metres onto a picture that is later reduced, so that edges come out smooth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw

from motionsplice.motion.quaternion import Floats

Colour = tuple[int, int, int]

WHITE: Colour = (255, 255, 255)
OVERSAMPLING = 4


def mixed(colour: Colour, white: float) -> Colour:
    """`colour` with a share `white` (0 to 1) of white."""
    red, green, blue = (round(value + white * (255 - value)) for value in colour)
    return red, green, blue


def canvas(width: int, height: int) -> Image.Image:
    """A white canvas for a picture of that many pixels."""
    return Image.new("RGB", (width * OVERSAMPLING, height * OVERSAMPLING), WHITE)


def reduced(image: Image.Image) -> Image.Image:
    """The picture that was painted on a canvas, at its own size."""
    return image.reduce(OVERSAMPLING)


@dataclass(frozen=True)
class Brush:
    """Paints on `image`, a canvas, in metres to the right of and above `origin` (pixels of the picture).

    scale: pixels of the picture per metre.
    """

    image: Image.Image
    origin: tuple[float, float]
    scale: float

    def disc(self, centre: Floats, radius: float, colour: Colour, *, flatness: float = 1.0) -> None:
        """A disc of `radius` metres about `centre` [2], its height `flatness` times its width."""
        x, y = self._pixels(centre)
        rx = radius * self.scale * OVERSAMPLING
        ry = rx * flatness
        self._draw.ellipse((x - rx, y - ry, x + rx, y + ry), fill=colour)

    def polygon(self, corners: Floats, colour: Colour) -> None:
        """A filled polygon with `corners` [n, 2]."""
        self._draw.polygon([(round(x), round(y)) for x, y in self._pixels(corners)], fill=colour)

    def taper(self, start: Floats, stop: Floats, start_radius: float, stop_radius: float, colour: Colour) -> None:
        """A bone from `start` [2] to `stop` [2] with round ends, as thick at each as its radius there says."""
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
