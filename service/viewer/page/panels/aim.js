const LINGER = 40; // ms on a row after which a click is likely

/** Fetches what a click on a clip would show, while the pointer rests on it. */
export class Aim {
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #timer;

  /**
   * @param {HTMLElement} lists
   * @param {(key: string, name: string) => void} fetch called with the value of the state that a click would set
   */
  constructor(lists, fetch) {
    lists.addEventListener('pointerover', ({ target }) => {
      clearTimeout(this.#timer);
      const row = target instanceof Element ? /** @type {HTMLElement | null} */ (target.closest('[role=option]')) : null;
      const key = row?.closest('.listing')?.classList[1];
      if (!row || !key || row.ariaSelected === 'true') return;
      this.#timer = setTimeout(() => fetch(key, row.dataset.name ?? ''), LINGER);
    });
    lists.addEventListener('pointerleave', () => clearTimeout(this.#timer));
  }
}
