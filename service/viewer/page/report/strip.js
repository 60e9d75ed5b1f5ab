import { SIDES } from '../takes.js';
import { onTheme, themeOf } from '../timeline/theme.js';
import { make } from '../panels/dom.js';

/** @import { Pair } from './pairs.js' */

const SIZE = /** @type {const} */ ([220, 28]); // CSS pixels
const DOT = 2.5;

/**
 * The values of a pair over time: plain replacement as an area, the splice as a line with a dot at its worst moment. It links to
 * the viewer at the moment under the pointer.
 *
 * @param {Pair} pair
 * @param {number} rate moments per second
 * @param {number} top cm at the upper edge
 * @param {(time: number) => string | undefined} link
 */
export function strip(pair, rate, top, link) {
  const canvas = make('canvas', { 'aria-hidden': 'true' });
  const address = link(pair.worst.time);
  const element = make('a', { class: 'strip', tabindex: -1, 'aria-hidden': 'true', href: address }, canvas);
  canvas.width = SIZE[0] * Math.max(1, devicePixelRatio);
  canvas.height = SIZE[1] * Math.max(1, devicePixelRatio);
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext('2d'));
  const { naive = [], splice = [] } = pair.over_time;
  const count = Math.max(naive.length, splice.length, 2);
  const x = (/** @type {number} */ index) => (index / (count - 1)) * SIZE[0];
  const y = (/** @type {number} */ value) => SIZE[1] - 1 - Math.min(1, value / top) * (SIZE[1] - 4);

  /** @param {number} [hovered] index of a moment */
  const draw = (hovered) => {
    const theme = themeOf(element);
    context.setTransform(canvas.width / SIZE[0], 0, 0, canvas.height / SIZE[1], 0, 0);
    context.clearRect(0, 0, ...SIZE);
    context.fillStyle = SIDES.naive.colour;
    context.globalAlpha = 0.45;
    context.beginPath();
    context.moveTo(0, SIZE[1]);
    naive.forEach((value, index) => context.lineTo(x(index), y(value)));
    context.lineTo(x(naive.length - 1), SIZE[1]);
    if (naive.length) context.fill();
    context.globalAlpha = 1;
    context.strokeStyle = context.fillStyle = SIDES.splice.colour;
    context.lineWidth = 1.5;
    context.beginPath();
    splice.forEach((value, index) => context.lineTo(x(index), y(value)));
    context.stroke();
    context.beginPath();
    context.arc(Math.max(DOT, Math.min(SIZE[0] - DOT, x(pair.worst.time * rate))), y(pair.worst.value), DOT, 0, 7);
    context.fill();
    if (hovered === undefined) return;
    context.fillStyle = theme.text;
    context.fillRect(x(hovered), 0, 1, SIZE[1]);
    const text = [`${(hovered / rate).toFixed(2)} s`, ...[naive, splice].filter((one) => hovered < one.length).map((one) => one[hovered].toFixed(1))].join('  ');
    context.font = '10px system-ui, sans-serif';
    const width = context.measureText(text).width + 6;
    const left = x(hovered) + width + 2 < SIZE[0] ? x(hovered) + 2 : x(hovered) - width - 1;
    context.fillStyle = theme.panel;
    context.fillRect(left, 0, width, 13);
    context.fillStyle = theme.text;
    context.fillText(text, left + 3, 10);
  };

  element.addEventListener('pointermove', (event) => {
    const { left, width } = element.getBoundingClientRect();
    const index = Math.round(Math.max(0, Math.min(1, (event.clientX - left) / width)) * (count - 1));
    const found = link(index / rate);
    if (found) element.href = found;
    draw(index);
  });
  element.addEventListener('pointerleave', () => {
    if (address) element.href = address;
    draw();
  });
  return { element, draw: () => draw() };
}

/**
 * Draws strips when they come into view, and anew in other colours when the theme changes.
 *
 * @returns {(one: { element: Element, draw(): void }) => void}
 */
export function painter() {
  /** @type {Map<Element, () => void>} */
  const all = new Map();
  /** @type {Set<Element>} */
  const drawn = new Set();
  const observer = new IntersectionObserver((entries) => {
    for (const { isIntersecting, target } of entries) {
      if (!isIntersecting || drawn.has(target)) continue;
      drawn.add(target);
      all.get(target)?.();
    }
  }, { rootMargin: '200px' });
  onTheme(() => { for (const element of drawn) all.get(element)?.(); });
  return ({ element, draw }) => {
    all.set(element, draw);
    observer.observe(element);
  };
}
