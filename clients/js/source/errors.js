/** The base of all errors of this module. */
export class MotionSpliceError extends Error {
  /** @param {string} message */
  constructor(message) {
    super(message);
    this.name = new.target.name;
  }
}

/** The service refused a command or a request, and did nothing of it. */
export class RefusedError extends MotionSpliceError {
  /**
   * @param {string} type the problem's type, as `urn:motionsplice:unknown-clip`
   * @param {string} detail what is wrong and what to do
   */
  constructor(type, detail) {
    super(detail);
    /** The problem's type without its prefix, as `unknown-clip`. */
    this.type = type.replace(/^urn:motionsplice:/, '');
  }
}

/** There is no connection, or it was lost before the service replied. */
export class ConnectionLostError extends MotionSpliceError {
  /**
   * @param {string} message
   * @param {number} [code] the WebSocket's close code
   */
  constructor(message, code) {
    super(message);
    this.code = code;
  }
}

/** A message is not what the protocol describes. */
export class FormatError extends MotionSpliceError {}

/** The joints do not fit the bones that they are to move. */
export class RigError extends MotionSpliceError {}
