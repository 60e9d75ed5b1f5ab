/** Icons of the transport, drawn as SVG in a square of 16. */

const SHAPES = {
  first: ['M3 3h2v10H3z', 'M13 3v10L6 8z'],
  back: ['M10.5 3v10L4.5 8z', 'M11.5 3h1.5v10h-1.5z'],
  play: ['M4 2.5v11L13 8z'],
  pause: ['M4 3h3v10H4z', 'M9 3h3v10H9z'],
  ahead: ['M5.5 3v10l6-5z', 'M3 3h1.5v10H3z'],
  last: ['M11 3h2v10h-2z', 'M3 3v10l7-5z'],
  clear: ['M4.1 3 8 6.9 11.9 3 13 4.1 9.1 8l3.9 3.9-1.1 1.1L8 9.1 4.1 13 3 11.9 6.9 8 3 4.1z'],
};

/** @typedef {keyof typeof SHAPES} Icon */

const SVG = 'http://www.w3.org/2000/svg';

/** @param {Icon} name */
export function icon(name) {
  const svg = document.createElementNS(SVG, 'svg');
  svg.setAttribute('viewBox', '0 0 16 16');
  svg.setAttribute('aria-hidden', 'true');
  for (const shape of SHAPES[name]) {
    const path = document.createElementNS(SVG, 'path');
    path.setAttribute('d', shape);
    svg.append(path);
  }
  return svg;
}
