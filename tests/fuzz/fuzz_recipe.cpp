// Fuzzes the reader of recipes: a valid recipe is unchanged after writing and reading it again.
#include "tests/fuzz/oracle.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/recipe.h"

using namespace brittle;
using namespace brittle::tools;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const fuzz::MemoryFile file(data, size);
    const fuzz::TimeGuard guard;
    FractureOptions options;
    try {
        read_recipe(file.path(), options);
    } catch (const Failure& failure) {
        fuzz::require(failure.code() == exit_input, "a damaged recipe is an input error");
        fuzz::check_message(failure.what());
        return 0;
    }
    const std::string text = recipe_json(options);
    const fuzz::MemoryFile written(reinterpret_cast<const uint8_t*>(text.data()), text.size());
    FractureOptions again;
    try {
        read_recipe(written.path(), again);
    } catch (const Failure& failure) {
        fuzz::require(false, failure.what());
    }
    fuzz::require(recipe_json(again) == text, "a recipe that was written is read as another");
    return 0;
}
