// Errors of the engine as failures of a command (scenario/base/failure.h).
//
//     std::unique_ptr<engine::Device> device = must(engine::Device::create({}));
#pragma once

#include <type_traits>
#include <utility>

#include "engine/core/result.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

[[nodiscard]] Failure failure_of(const engine::Error& error);

template<class T>
T must(engine::Result<T>&& result) {
    if (!result) throw failure_of(result.error());
    if constexpr (!std::is_void_v<T>) return *std::move(result);
}

} // namespace brittle::tools
