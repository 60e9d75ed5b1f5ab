import { Span } from './span.js';
import { zoomByWheel } from './zoom.js';

/** @import { Player } from '../player.js' */
/** @import { Axis } from './ruler.js' */

/** Seeks whole frames by clicks and drags, and reports the time under the pointer. */
export class Scrub {
  #isDown = false;

  /**
   * @param {HTMLElement} element
   * @param {Player} player
   * @param {() => Axis} axis
   * @param {(time: number | undefined, event: PointerEvent) => void} pointed
   */
  constructor(element, player, axis, pointed) {
    const timeOf = (/** @type {PointerEvent} */ event) => player.whole(axis().time(event.clientX - element.getBoundingClientRect().left));
    element.addEventListener('pointerdown', (event) => {
      if (event.button !== 0) return;
      element.setPointerCapture(event.pointerId);
      this.#isDown = true;
      pointed(undefined, event);
      player.seek(timeOf(event));
    });
    element.addEventListener('pointermove', (event) => {
      if (this.#isDown) player.seek(timeOf(event));
      else if (event.pointerType !== 'touch') pointed(event.offsetX < axis().left ? undefined : timeOf(event), event);
    });
    for (const end of /** @type {const} */ (['pointerup', 'pointercancel'])) element.addEventListener(end, () => { this.#isDown = false; });
    element.addEventListener('dblclick', () => Span.of(player).fit());
    zoomByWheel(element, Span.of(player), axis);
    element.addEventListener('pointerleave', (event) => pointed(undefined, event));
  }
}
