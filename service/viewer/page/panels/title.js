/** @import { Catalogue } from '../catalogue.js' */
/** @import { State } from '../state.js' */

/** Says which bank is open, and gives the tab the name of what is played. */
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
