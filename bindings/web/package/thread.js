// A thread of brittle_wasm_threads: does what the script that Emscripten 3.1.6 writes beside the module does, as a module, which
// bundlers find and node loads. The thread that started it sends the memory first, later the function to run.
import start from "./brittle_wasm_threads.mjs";

let module = { ENVIRONMENT_IS_PTHREAD: true };

const COMMANDS = {
    async load({ wasmModule, wasmMemory }) {
        module.wasmMemory = wasmMemory;
        module.buffer = wasmMemory.buffer;
        module.instantiateWasm = (imports, receive) => {
            const instance = new WebAssembly.Instance(wasmModule, imports);
            receive(instance);
            return instance.exports;
        };
        module = await start(module); // which answers that it is loaded
    },
    run({ time, threadInfoStruct, start_routine, arg }) {
        module.__performance_now_clock_drift = performance.now() - time; // one clock for all threads
        module.__emscripten_thread_init(threadInfoStruct, 0, 0, 1);
        module.establishStackSpace();
        module.PThread.threadInit();
        try {
            module.invokeEntryPoint(start_routine, arg); // returns when the process ends
        } catch (error) {
            module.__emscripten_thread_crashed(); // so that the thread that waits for this one gives up
            throw error;
        }
    },
};
const receive = ({ data }) => COMMANDS[data.cmd]?.(data);

if (typeof self === "object" && self.postMessage) {
    self.onmessage = receive;
} else {
    const { parentPort } = await import("node:worker_threads");
    globalThis.postMessage = (message) => parentPort.postMessage(message);
    parentPort.on("message", (data) => receive({ data }));
}
