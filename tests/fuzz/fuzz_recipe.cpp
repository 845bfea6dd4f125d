// Fuzzes recipes and scenes: a valid one is unchanged after writing and reading it again, and its run breaks no promise
// (run_checks.h).
#include "tests/fuzz/oracle.h"
#include "tests/fuzz/run_checks.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/recipe.h"

using namespace brittle;
using namespace brittle::tools;

namespace {

// Returns whether the bytes are a recipe.
bool read(const uint8_t* data, size_t size, FractureOptions& options) {
    const fuzz::TimeGuard guard;
    const fuzz::MemoryFile file(data, size);
    try {
        read_recipe(file.path(), options);
    } catch (const Failure& failure) {
        fuzz::require(failure.code() == exit_input, "a damaged recipe is an input error");
        fuzz::check_message(failure.what());
        return false;
    }
    return true;
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    FractureOptions options;
    if (!read(data, size, options)) return 0;
    const std::string text = recipe_json(options);
    const fuzz::MemoryFile written(reinterpret_cast<const uint8_t*>(text.data()), text.size());
    FractureOptions again;
    try {
        read_recipe(written.path(), again);
    } catch (const Failure& failure) {
        fuzz::require(false, failure.what());
    }
    fuzz::require(recipe_json(again) == text, "a recipe that was written is read as another");
    if (!fuzz::bound(options)) return 0;
    const fuzz::TimeGuard guard(fuzz::max_run_seconds);
    fuzz::run_or_fail([&] {
        Simulation simulation(options.material);
        fuzz::run(options, simulation, fuzz::max_steps);
    });
    return 0;
}
