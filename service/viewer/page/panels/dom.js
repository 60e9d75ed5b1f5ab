/**
 * Makes an element. Text is added as text nodes, so names of clips are never read as HTML.
 *
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Record<string, string | number | boolean | undefined>} [attributes] true: present; false or undefined: left out
 * @param {...(Node | string)} children
 * @returns {HTMLElementTagNameMap[Tag]}
 */
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== undefined && value !== false) element.setAttribute(name, value === true ? '' : String(value));
  }
  element.append(...children);
  return element;
}

/**
 * @param {string} label
 * @param {() => void} onClick
 * @param {Record<string, string | boolean | undefined>} [attributes]
 */
export function button(label, onClick, attributes = {}) {
  const element = make('button', { type: 'button', ...attributes }, label);
  element.addEventListener('click', onClick);
  return element;
}

/**
 * Returns an element of the page.
 *
 * @param {string} id
 */
export function byId(id) {
  const element = document.getElementById(id);
  if (!element) throw new Error(`the page has no #${id}`);
  return element;
}

let made = 0;

/** Returns an id that no other element has. */
export function newId() {
  made += 1;
  return `panel-${made}`;
}

/**
 * Returns an input behind its label.
 *
 * @param {string} label
 * @param {HTMLElement} input
 */
export function labelled(label, input) {
  input.id = newId();
  return make('div', { class: 'field' }, make('label', { for: input.id, class: 'label' }, label), input);
}

/**
 * Returns the options of a menu.
 *
 * @param {[string, string][]} choices value and label of each
 */
export function optionsOf(choices) {
  return choices.map(([value, label]) => make('option', { value }, label));
}

/**
 * Returns a small square of a colour, which a label beside it explains.
 *
 * @param {string} colour
 */
export function swatch(colour) {
  const element = make('span', { class: 'swatch', 'aria-hidden': 'true' });
  element.style.background = colour;
  return element;
}

/**
 * Formats metres as centimetres.
 *
 * @param {number} metres
 */
export function centimetres(metres) {
  return `${(100 * metres).toFixed(1)} cm`;
}
