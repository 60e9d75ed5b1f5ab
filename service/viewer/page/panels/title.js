/** @import { Catalogue } from '../catalogue.js' */
/** @import { State } from '../state.js' */

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
  reload({ clips, baseline, server }) {
    this.element.textContent = `${clips.size} clips, baseline ${baseline}`;
    this.element.title = `Bank ${server.bank}\nmotionsplice ${server.version}`;
    this.#name();
  }

  #name() {
    const { locomotion, action } = this.state.values;
    document.title = `${[locomotion, action].filter(Boolean).join(' + ') || 'Viewer'} - motionsplice`;
  }
}
