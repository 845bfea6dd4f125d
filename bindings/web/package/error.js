/** A refusal of the library: `status` is its name, the message says what to do. */
export class BrittleError extends Error {
    constructor(status, message) {
        super(message);
        this.name = "BrittleError";
        this.status = status;
    }
}
