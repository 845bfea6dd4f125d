// Recipes and runs behind the C interface. Internal.
#pragma once

#include <functional>
#include <string>
#include <utility>

#include "bindings/c/handles.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/host.h"
#include "tools/scenario/recipe/input.h"

struct brittle_recipe {
    brittle::tools::FractureOptions options;
};

namespace brittle::c {

[[nodiscard]] brittle_status status_of(const tools::Failure& failure);

// guarded_json(), where a tools::Failure becomes its status and its message.
template<class Body>
brittle_status guarded_run(brittle_error* error, Body&& body) noexcept {
    return guarded_json(error, [&] {
        try {
            body();
        } catch (const tools::Failure& failure) {
            throw Refusal{status_of(failure), failure.what()};
        }
    });
}

// What the caller of a long call wants to be asked and told.
struct Caller {
    uint32_t threads = 0; // 0: one per core
    tools::Host host;
    std::function<void(double)> progress;

    explicit Caller(const brittle_load_settings* settings);

    // The options of a recipe, for this call.
    [[nodiscard]] tools::FractureOptions options_of(const brittle_recipe& recipe) const;
};

// A path in UTF-8, or a Refusal for NULL and for no text.
[[nodiscard]] std::string read_path(const char* path, const char* name);
// The same of a file that must exist.
[[nodiscard]] std::string read_file_name(const char* path, const char* name);

} // namespace brittle::c
