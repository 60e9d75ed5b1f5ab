/**
 * Colours to draw on a canvas with.
 *
 * @typedef {Record<keyof typeof FALLBACKS, string>} Theme
 */

const FALLBACKS = {
  back: '#1b1d20', panel: '#24272b', text: '#e6e6e6', faint: '#9aa0a6', line: '#3a3f45',
  accent: '#f28c28', warn: '#e5534b', left: '#5aa9ff', right: '#ff8fa3',
};

/**
 * Returns the page's colours at an element. A canvas cannot read CSS variables, and a variable may hold an
 * expression such as light-dark(), so the browser resolves each one as the colour of a hidden element.
 *
 * @param {HTMLElement} element
 * @returns {Theme}
 */
export function themeOf(element) {
  const probe = document.createElement('span');
  probe.hidden = true;
  element.append(probe);
  const theme = { ...FALLBACKS };
  for (const [name, fallback] of Object.entries(FALLBACKS)) {
    probe.style.color = `var(--${name}, ${fallback})`;
    theme[/** @type {keyof Theme} */ (name)] = getComputedStyle(probe).color;
  }
  probe.remove();
  return theme;
}

/**
 * Calls back when the system changes between light and dark.
 *
 * @param {() => void} changed
 */
export function onTheme(changed) {
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', changed);
}
