import { EDGE, GUTTER, NARROW, timeAxis } from './ruler.js';
import { Span } from './span.js';
import { Surface } from './surface.js';
import { onTheme, themeOf } from './theme.js';

/** @import { Player } from '../player.js' */

/** A drawing over time on two canvases: the back one is painted when what is shown changes, the front one at each picture. */
export class Plot {
  #narrow;

  /**
   * @param {HTMLElement} element
   * @param {Player} player
   * @param {HTMLElement} place that is added to the element, and that the canvases fill
   * @param {number} narrow left edge of the time axis where there is no gutter, in CSS pixels
   */
  constructor(element, player, place, narrow) {
    this.player = player;
    this.#narrow = narrow;
    this.span = Span.of(player);
    element.append(place);
    this.theme = themeOf(element);
    this.back = new Surface(place, (context, _, height) => this.paintBack(context, height));
    this.front = new Surface(place, (context, _, height) => this.paintFront(context, height));
    this.span.on(() => this.redraw());
    onTheme(() => {
      this.theme = themeOf(element);
      this.redraw();
    });
  }

  /** Paints all again. */
  redraw() {
    this.back.request();
    this.front.request();
  }

  get isNarrow() {
    return this.back.width < NARROW;
  }

  /** Where times are. */
  get axis() {
    return timeAxis(this.span, this.isNarrow ? this.#narrow : GUTTER, this.back.width - EDGE);
  }

  /** @param {CanvasRenderingContext2D} _context @param {number} _height */
  paintBack(_context, _height) {}

  /** @param {CanvasRenderingContext2D} _context @param {number} _height */
  paintFront(_context, _height) {}
}
