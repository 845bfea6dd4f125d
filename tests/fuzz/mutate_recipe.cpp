// Recipes and scenes, changed by their schemas.
#include "tests/fuzz/mutate.h"

using namespace brittle::fuzz;

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned seed) {
    static const JsonMutator mutator(BRITTLE_ASSETS,
                                     {{"anyOf", {{{"$ref", "recipe.schema.json"}}, {{"$ref", "scene.schema.json"}}}}});
    if (seed % bytes_one_in == 0) return LLVMFuzzerMutate(data, size, max_size);
    const Json before = Json::parse(data, data + size, nullptr, false);
    const Json after = before.is_object() ? mutator.mutated(before, seed) : mutator.generated(seed);
    return written(text_of(after), data, size, max_size);
}
