/**
 * Returns a function that returns whether a text contains all words of a search, in any case and order.
 *
 * @param {string} search
 * @returns {(text: string) => boolean}
 */
export function matcher(search) {
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  return (text) => words.every((word) => text.toLowerCase().includes(word));
}
