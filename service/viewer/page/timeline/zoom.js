/** @import { Axis } from './ruler.js' */
/** @import { Span } from './span.js' */

const LINE = 16; // CSS pixels of a wheel that counts lines
const FACTOR = 1.002; // of a CSS pixel

/**
 * Lets the wheel zoom a time axis about the pointer, and pan it across or with Shift. Where the wheel scrolls the page, it
 * zooms only with Ctrl or Alt; a trackpad's pinch counts as Ctrl.
 *
 * @param {HTMLElement} element
 * @param {Span} span
 * @param {() => Axis} axis
 */
export function zoomByWheel(element, span, axis) {
  element.addEventListener('wheel', (event) => {
    const unit = event.deltaMode ? LINE : 1;
    const isAcross = event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY);
    const isMeant = event.ctrlKey || event.altKey || (isAcross && !span.isWhole) || !scrolls(element);
    if (!isMeant) return;
    event.preventDefault();
    if (isAcross) span.pan((event.deltaX || event.deltaY) * unit * (axis().time(1) - axis().time(0)));
    else span.zoom(axis().time(event.clientX - element.getBoundingClientRect().left), FACTOR ** (event.deltaY * unit));
  }, { passive: false });
}

/**
 * Whether something around an element can be scrolled.
 *
 * @param {HTMLElement} element
 */
function scrolls(element) {
  for (let around = element.parentElement; around; around = around.parentElement) {
    const isRoot = around === document.documentElement;
    if (around.scrollHeight > around.clientHeight && (isRoot || /auto|scroll/.test(getComputedStyle(around).overflowY))) return true;
  }
  return false;
}
