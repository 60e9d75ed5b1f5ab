/** Vectors of three numbers, for shapes that are computed once. */

/** @typedef {[number, number, number]} Vector */

/** @param {Vector} a @param {Vector} b @returns {Vector} */
export const plus = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];

/** @param {Vector} a @param {Vector} b @returns {Vector} */
export const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];

/** @param {Vector} a @param {number} factor @returns {Vector} */
export const times = (a, factor) => [a[0] * factor, a[1] * factor, a[2] * factor];

/** @param {Vector} a @param {Vector} b */
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** @param {Vector} a @param {Vector} b @returns {Vector} */
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/** @param {Vector} a */
export const norm = (a) => Math.hypot(a[0], a[1], a[2]);

/** @param {Vector} a @returns {Vector} */
export const unit = (a) => times(a, 1 / (norm(a) || 1));

/** @param {Vector} a @param {Vector} b @param {number} share @returns {Vector} */
export const between = (a, b, share) => plus(times(a, 1 - share), times(b, share));

/**
 * Returns the part of a vector that is perpendicular to a unit vector, as a unit vector; `fallback` if there is hardly any.
 *
 * @param {Vector} a
 * @param {Vector} axis
 * @param {Vector} [fallback]
 * @returns {Vector}
 */
export function across(a, axis, fallback = [1, 0, 0]) {
  const rest = minus(a, times(axis, dot(a, axis)));
  if (norm(rest) > 0.05 * norm(a)) return unit(rest);
  const other = minus(fallback, times(axis, dot(fallback, axis)));
  return norm(other) > 0.05 ? unit(other) : unit(cross(axis, Math.abs(axis[1]) < 0.9 ? [0, 1, 0] : [1, 0, 0]));
}
