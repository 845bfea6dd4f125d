// How a command of `brittle` ends badly: an exit code and a message for people, thrown up to main().
//
// The libraries below report errors as Result values; must() turns them into the value or a Failure:
//
//     fracture::TriangleMesh mesh = must(fracture::import_mesh(file));
#pragma once

#include <stdexcept>
#include <string>

#include "engine/core/result.h"
#include "fracture/base/error.h"

namespace brittle::tools {

// What the shell sees. Listed in `brittle --help`; scripts rely on them.
enum ExitCode {
    exit_success = 0,
    exit_failure = 1,      // anything not listed below
    exit_usage = 2,        // a wrong command line
    exit_input = 3,        // an input file is missing, unreadable or damaged
    exit_mesh = 4,         // the mesh or the sites cannot be fractured
    exit_output = 5,       // an output could not be written; an old file is left as it was
    exit_environment = 6,  // no Vulkan device, a lost one, no display
    exit_slower = 7,       // `profile --compare` found something slower
    exit_differs = 8,      // `replay` came to another state than the log tells
    exit_interrupted = 130 // by Ctrl+C; nothing half-written is left
};

class Failure : public std::runtime_error {
  public:
    Failure(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
    explicit Failure(const fracture::Error& error);
    explicit Failure(const engine::Error& error);

    [[nodiscard]] ExitCode code() const { return code_; }

  private:
    ExitCode code_;
};

template<class T, template<class> class ResultOf>
T must(ResultOf<T>&& result) {
    if (!result) throw Failure(result.error());
    if constexpr (!std::is_void_v<T>) return *std::move(result);
}

} // namespace brittle::tools
