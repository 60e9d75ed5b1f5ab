/**
 * Decodes a MessagePack value. Blobs become views into `bytes`. Extension types, which the protocol does not use, are
 * refused.
 *
 * @param {Uint8Array} bytes
 * @returns {unknown}
 * @throws {FormatError} if the bytes are not one whole value
 */
export function decode(bytes: Uint8Array): unknown;
