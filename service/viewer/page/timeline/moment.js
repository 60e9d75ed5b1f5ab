/**
 * Returns the seconds that someone typed: "1.5", "1,5 s", "90f" or "1:02.5". Undefined if it is none of these.
 *
 * @param {string} text
 * @param {number} rate frames per second
 */
export function parseMoment(text, rate) {
  const found = /^\s*(?:(\d+):)?(\d+(?:[.,]\d*)?|[.,]\d+)\s*(s|f)?\s*$/i.exec(text);
  if (!found) return undefined;
  const number = Number(found[2].replace(',', '.'));
  if (found[3]?.toLowerCase() === 'f') return found[1] ? undefined : number / rate;
  return 60 * Number(found[1] ?? 0) + number;
}
