import { byId } from './dom.js';

/** Opens and closes the columns, which cover a part of the page on narrow screens, and the plots below the timeline. */
export class Columns {
  constructor() {
    this.openers = [...document.querySelectorAll('.opener')].map((one) => /** @type {HTMLButtonElement} */ (one));
    for (const opener of this.openers) {
      const column = byId(opener.getAttribute('aria-controls') ?? '');
      column.querySelector('.close button')?.addEventListener('click', () => this.#show(undefined));
      opener.addEventListener('click', () => this.#show(column.classList.contains('open') ? undefined : opener));
      column.addEventListener('keydown', (event) => {
        if (event.key !== 'Escape' || event.defaultPrevented || !column.classList.contains('open')) return;
        event.preventDefault();
        this.#show(undefined);
      });
    }
    this.folds = [...document.querySelectorAll('#folds button')];
    for (const fold of this.folds) {
      const plot = byId(fold.getAttribute('aria-controls') ?? '');
      fold.addEventListener('click', () => this.#unfold(plot.hidden ? plot : undefined));
    }
  }

  /**
   * Shows one plot below the timeline, or none. One at a time, so that the stage keeps its room.
   *
   * @param {HTMLElement | undefined} wanted
   */
  #unfold(wanted) {
    for (const fold of this.folds) {
      const plot = byId(fold.getAttribute('aria-controls') ?? '');
      plot.hidden = plot !== wanted;
      fold.setAttribute('aria-expanded', String(plot === wanted));
    }
  }

  /**
   * Opens the column of a button and closes the other, or closes both.
   *
   * @param {HTMLButtonElement | undefined} wanted
   */
  #show(wanted) {
    for (const opener of this.openers) {
      const column = byId(opener.getAttribute('aria-controls') ?? '');
      const hadFocus = column.contains(document.activeElement);
      column.classList.toggle('open', opener === wanted);
      opener.setAttribute('aria-expanded', String(opener === wanted));
      if (opener === wanted) column.querySelector('button')?.focus();
      else if (hadFocus) opener.focus();
    }
  }
}
