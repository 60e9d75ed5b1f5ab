import { byId } from './dom.js';

/** Opens and closes the columns, which cover a part of the page on narrow screens, and the plots below the timeline. */
export class Columns {
  constructor() {
    this.columns = [...document.querySelectorAll('.opener')].map(opened);
    for (const { opener, element: column } of this.columns) {
      column.querySelector('.close button')?.addEventListener('click', () => this.#show(undefined));
      opener.addEventListener('click', () => this.#show(column.classList.contains('open') ? undefined : column));
      column.addEventListener('keydown', (event) => {
        if (event.key !== 'Escape' || event.defaultPrevented || !column.classList.contains('open')) return;
        event.preventDefault();
        this.#show(undefined);
      });
    }
    this.plots = [...document.querySelectorAll('#folds button')].map(opened);
    for (const { opener, element: plot } of this.plots) opener.addEventListener('click', () => this.#unfold(plot.hidden ? plot : undefined));
  }

  /**
   * Shows one plot below the timeline, or none. One at a time, so that the stage keeps its room.
   *
   * @param {HTMLElement | undefined} wanted
   */
  #unfold(wanted) {
    for (const { opener, element: plot } of this.plots) {
      plot.hidden = plot !== wanted;
      opener.setAttribute('aria-expanded', String(plot === wanted));
    }
  }

  /**
   * Opens a column and closes the other, or closes both.
   *
   * @param {HTMLElement | undefined} wanted
   */
  #show(wanted) {
    for (const { opener, element: column } of this.columns) {
      const hadFocus = column.contains(document.activeElement);
      column.classList.toggle('open', column === wanted);
      opener.setAttribute('aria-expanded', String(column === wanted));
      if (column === wanted) column.querySelector('button')?.focus();
      else if (hadFocus) opener.focus();
    }
  }
}

/**
 * Returns a button of the page with the element that it opens.
 *
 * @param {Element} button
 */
function opened(button) {
  return { opener: /** @type {HTMLButtonElement} */ (button), element: byId(button.getAttribute('aria-controls') ?? '') };
}
