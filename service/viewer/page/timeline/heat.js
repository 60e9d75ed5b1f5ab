/** Colours of distances in the grid: dark where frames match, light where they do not. Even to the eye, and readable without hue. */

// Points of matplotlib's viridis (CC0), evenly spaced.
const STOPS = [
  [68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37],
];

/**
 * Returns red, green and blue, 0 to 255.
 *
 * @param {number} share 0 to 1
 */
export function heat(share) {
  const place = Math.max(0, Math.min(1, share || 0)) * (STOPS.length - 1);
  const before = Math.min(Math.floor(place), STOPS.length - 2);
  return STOPS[before].map((value, at) => value + (place - before) * (STOPS[before + 1][at] - value));
}

/**
 * Returns a picture of a grid, with its first row at the bottom.
 *
 * @param {import('./distance_grid.js').DistanceGrid} grid
 * @param {number} top metres that are lightest
 */
export function heatPicture({ columns, rows, values }, top) {
  const canvas = document.createElement('canvas');
  canvas.width = columns;
  canvas.height = rows;
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext('2d'));
  const image = context.createImageData(columns, rows);
  for (let row = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++) {
      image.data.set([...heat(values[row * columns + column] / top), 255], 4 * ((rows - 1 - row) * columns + column));
    }
  }
  context.putImageData(image, 0, 0);
  return canvas;
}
