const SPAN = 2000; // ms that the figures are of

/** What a crowd costs, over the last two seconds. */
export class Load {
  #pictures = new Window();
  #messages = new Window();
  #began = 0;

  /** Begins anew. @param {number} now ms */
  begin(now) {
    this.#pictures = new Window();
    this.#messages = new Window();
    this.#began = now;
  }

  /**
   * Notes a picture.
   *
   * @param {number} now ms
   * @param {number} script ms that its script took
   */
  picture(now, script) {
    this.#pictures.add(now, script);
  }

  /**
   * Notes a frame that has arrived.
   *
   * @param {number} now ms
   * @param {number} bytes
   */
  message(now, bytes) {
    this.#messages.add(now, bytes);
  }

  /** @param {number} now ms */
  at(now) {
    const seconds = Math.max(1, Math.min(SPAN, now - this.#began)) / 1000;
    const scripts = this.#pictures.since(now - SPAN).sort((a, b) => a - b);
    const bytes = this.#messages.since(now - SPAN);
    return {
      pictures: scripts.length / seconds, frames: bytes.length / seconds, kilobytes: bytes.reduce((sum, one) => sum + one, 0) / 1000 / seconds,
      median: scripts[scripts.length >> 1] ?? 0, worst: scripts.at(-1) ?? 0,
    };
  }
}

/** Values with the times at which they were measured. */
class Window {
  /** @type {number[]} */
  #times = [];
  /** @type {number[]} */
  #values = [];

  /** @param {number} now @param {number} value */
  add(now, value) {
    this.#times.push(now);
    this.#values.push(value);
    if (this.#times.length > 1000) this.since(now - SPAN);
  }

  /** Forgets what was before a time, and returns a copy of the rest. @param {number} from */
  since(from) {
    const first = this.#times.findIndex((time) => time > from);
    this.#times.splice(0, first < 0 ? Infinity : first);
    this.#values.splice(0, first < 0 ? Infinity : first);
    return [...this.#values];
  }
}
