/** The base of all errors of this module. */
export class MotionSpliceError extends Error {
    /** @param {string} message */
    constructor(message: string);
}
/** The service refused a command or a request, and did nothing of it. */
export class RefusedError extends MotionSpliceError {
    /**
     * @param {string} type the problem's type, as `urn:motionsplice:unknown-clip`
     * @param {string} detail what is wrong and what to do
     */
    constructor(type: string, detail: string);
    /** The problem's type without its prefix, as `unknown-clip`. */
    type: string;
}
/** There is no connection, or it was lost before the service replied. */
export class ConnectionLostError extends MotionSpliceError {
    /**
     * @param {string} message
     * @param {number} [code] the WebSocket's close code
     */
    constructor(message: string, code?: number);
    code: number | undefined;
}
/** A message is not what the protocol describes. */
export class FormatError extends MotionSpliceError {
}
/** The joints do not fit the bones that they are to move. */
export class RigError extends MotionSpliceError {
}
