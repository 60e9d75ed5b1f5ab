import { rangeOf } from './pieces.js';
import { LANE, RULER } from './ruler.js';
import { zoomByWheel } from './zoom.js';

/** @import { Timeline } from './timeline.js' */

const REACH = 9; // CSS pixels around a handle
const FINGER = 22;
const PAGE = 10; // frames

/** @typedef {(time: number, x: number) => void} Drag */

/** Turns the pointer, the wheel and keys on a timeline into seeking, the repeated range, and zoom. */
export class Pointer {
  /** What moves with the pointer. @type {Drag | undefined} */
  #drag = undefined;

  /** @param {Timeline} timeline */
  constructor(timeline) {
    this.timeline = timeline;
    this.player = timeline.player;
    const { slider } = timeline;
    slider.addEventListener('pointerdown', (event) => this.#down(event));
    slider.addEventListener('pointermove', (event) => this.#move(event));
    slider.addEventListener('pointerup', () => this.#up());
    slider.addEventListener('pointercancel', () => this.#up());
    slider.addEventListener('pointerleave', () => this.#point(undefined));
    slider.addEventListener('dblclick', (event) => this.#twice(event));
    zoomByWheel(slider, timeline.span, () => timeline.axis);
    slider.addEventListener('keydown', (event) => this.#key(event));
  }

  /** @param {PointerEvent} event */
  #down(event) {
    const isMiddle = event.button === 1; // pans
    if ((event.button !== 0 && !isMiddle) || !this.timeline.data || event.offsetX < this.timeline.axis.left - REACH) return;
    event.preventDefault(); // no selection, no scrolling by the middle button
    this.timeline.slider.focus({ preventScroll: true });
    this.timeline.slider.setPointerCapture(event.pointerId);
    const time = this.#time(event);
    this.#drag = isMiddle ? this.#pan(event.clientX, 1) : this.#dragAt(event, time);
    this.#point(undefined);
    this.#drag(time, event.clientX);
  }

  /**
   * Returns what a drag from here does.
   *
   * @param {PointerEvent} event
   * @param {number} start seconds
   * @returns {Drag}
   */
  #dragAt(event, start) {
    const y = event.offsetY, { axis } = this.timeline;
    const [from, to] = this.player.range;
    if (y >= this.timeline.bottom && !this.timeline.span.isWhole) return this.#pan(event.clientX, -1);
    if (event.shiftKey) return (time) => this.#repeat(start, time, time !== start);
    const isTouch = event.pointerType === 'touch';
    if (y >= RULER && y < RULER + LANE + (isTouch ? 8 : 0)) {
      const toFrom = Math.abs(axis.x(from) - event.offsetX), toEnd = Math.abs(axis.x(to) - event.offsetX);
      const isNear = Math.min(toFrom, toEnd) <= (isTouch ? FINGER : REACH);
      if (isNear) return toFrom < toEnd ? (time) => this.#repeat(time, to) : (time) => this.#repeat(from, time);
      if (start > from && start < to && to - from < this.player.duration) return (time) => this.#shift(from, to, time - start);
    }
    return (time) => this.player.seek(this.player.whole(time));
  }

  /** @param {PointerEvent} event */
  #move(event) {
    const time = this.#time(event);
    if (this.#drag) this.#drag(time, event.clientX);
    else {
      this.#point(event.pointerType === 'touch' || event.offsetX < this.timeline.axis.left - 4 ? undefined : this.player.whole(time));
      this.timeline.slider.style.cursor = this.#isOnLane(event) ? 'ew-resize' : '';
    }
  }

  /**
   * Returns a drag of what is visible: the strips with the pointer, or the bar below them.
   *
   * @param {number} x CSS pixels
   * @param {1 | -1} of the strips, or of the bar
   * @returns {Drag}
   */
  #pan(x, of) {
    const { span, axis } = this.timeline;
    const seconds = (of === 1 ? span.to - span.from : -span.duration) / (axis.right - axis.left);
    return (_, next) => {
      span.pan((x - next) * seconds);
      x = next;
    };
  }

  #up() {
    this.#drag = undefined;
  }

  /** @param {MouseEvent} event */
  #twice(event) {
    if (event.offsetY < RULER + LANE) this.player.state.set({ from: 0, to: 0 });
    else this.timeline.span.fit();
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const { player, timeline: { span } } = this;
    const frames = event.shiftKey ? PAGE : 1;
    const act = {
      ArrowLeft: () => player.step(-frames),
      ArrowRight: () => player.step(frames),
      PageDown: () => player.step(-PAGE),
      PageUp: () => player.step(PAGE),
      Home: () => player.seek(0),
      End: () => player.seek(player.duration),
      '+': () => span.zoom(player.time, 0.7),
      '=': () => span.zoom(player.time, 0.7),
      '-': () => span.zoom(player.time, 1 / 0.7),
      0: () => span.fit(),
    }[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    act();
    event.preventDefault();
    event.stopPropagation(); // the page's own keys would step once more
  }

  /** @param {MouseEvent} event */
  #time(event) {
    const box = this.timeline.slider.getBoundingClientRect();
    return Math.max(0, Math.min(this.player.duration, this.timeline.axis.time(event.clientX - box.left)));
  }

  /** @param {PointerEvent} event */
  #isOnLane(event) {
    const [from, to] = this.player.range, { axis } = this.timeline;
    const isNear = [from, to].some((time) => Math.abs(axis.x(time) - event.offsetX) <= REACH);
    return isNear && event.offsetY >= RULER && event.offsetY < RULER + LANE;
  }

  /** @param {number | undefined} time */
  #point(time) {
    if (time === this.timeline.pointed) return;
    this.timeline.pointed = time;
    this.timeline.front.request();
  }

  /**
   * @param {number} a
   * @param {number} b
   * @param {boolean} [isLong] a click is no range
   */
  #repeat(a, b, isLong = true) {
    const { duration, rate, state } = this.player;
    if (isLong && Math.abs(a - b) >= 1 / rate) state.set(rangeOf(a, b, duration, rate));
  }

  /**
   * Moves the range as a whole.
   *
   * @param {number} from
   * @param {number} to
   * @param {number} by
   */
  #shift(from, to, by) {
    const most = Math.max(-from, Math.min(this.player.duration - to, by));
    this.#repeat(from + most, to + most);
  }
}
