/** A canvas that fills its parent, sharp on every screen. It is painted when its size changes, or when asked. */
export class Surface {
  /** CSS pixels, 0 while it is hidden. Measured when it changes, so that painting forces no layout. */
  width = 0;
  height = 0;
  #isWaiting = false;

  /**
   * @param {HTMLElement} parent a positioned element
   * @param {(context: CanvasRenderingContext2D, width: number, height: number) => void} paint on a cleared canvas, in CSS pixels
   */
  constructor(parent, paint) {
    this.canvas = document.createElement('canvas');
    this.canvas.className = 'surface';
    this.canvas.setAttribute('aria-hidden', 'true');
    this.context = /** @type {CanvasRenderingContext2D} */ (this.canvas.getContext('2d'));
    this.paint = paint;
    parent.append(this.canvas);
    new ResizeObserver(([{ contentRect }]) => {
      [this.width, this.height] = [contentRect.width, contentRect.height];
      this.draw();
    }).observe(parent);
  }

  /** Paints before the next picture, once however often it is asked. */
  request() {
    if (this.#isWaiting) return;
    this.#isWaiting = true;
    requestAnimationFrame(() => this.draw());
  }

  /** Paints now. */
  draw() {
    this.#isWaiting = false;
    if (!this.width || !this.height) return;
    this.#fit();
    this.context.clearRect(0, 0, this.width, this.height);
    this.paint(this.context, this.width, this.height);
  }

  #fit() {
    const ratio = devicePixelRatio || 1;
    const [columns, rows] = [Math.round(this.width * ratio), Math.round(this.height * ratio)];
    if (this.canvas.width === columns && this.canvas.height === rows) return;
    this.canvas.width = columns;
    this.canvas.height = rows;
    this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
  }
}
