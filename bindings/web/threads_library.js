// What Emscripten takes from its surroundings for threads, from the options of the module: see init() in package/brittle.js.
mergeInto(LibraryManager.library, {
    // As many cores as there are threads: "one thread a core" never asks for more than there are workers.
    emscripten_num_logical_cores: function () { return Module["threads"] || 1; },
    // It takes node for a page, which must not wait; init() refuses threads in pages.
    emscripten_check_blocking_allowed: function () {},
});
// Emscripten names a script that is no module.
LibraryManager.library.$PThread.allocateUnusedWorker = function () { PThread.unusedWorkers.push(Module["newThread"]()); };
