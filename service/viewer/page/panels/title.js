import { byId } from './dom.js';

/** @import { Catalogue } from '../catalogue.js' */
/** @import { State } from '../state.js' */

/**
 * Shows what the bank has.
 *
 * @param {HTMLElement} element
 * @param {Catalogue} catalogue
 */
export function describeBank(element, { clips, baseline, server }) {
  element.textContent = `${clips.size} ${clips.size === 1 ? 'clip' : 'clips'}, baseline ${baseline}`;
  element.title = `Bank ${server.bank}\nmotionsplice ${server.version}`;
}

/** Names the bank in the page's head, and the current clips in the tab's title. */
export class Title {
  /**
   * @param {HTMLElement} element
   * @param {Catalogue} catalogue
   * @param {State} state
   */
  constructor(element, catalogue, state) {
    this.element = element;
    this.state = state;
    state.on(() => this.#name());
    this.reload(catalogue);
  }

  /** @param {Catalogue} catalogue */
  reload(catalogue) {
    describeBank(this.element, catalogue);
    byId('show-report').hidden = !catalogue.server.report;
    this.#name();
  }

  #name() {
    const { locomotion, action } = this.state.values;
    document.title = `${[locomotion, action].filter(Boolean).join(' + ') || 'Viewer'} - motionsplice`;
  }
}
