// The failure of a command: an exit code and a message for people, thrown up to main().
//
// The libraries report errors as Result values; must() turns a Result into its value or throws a Failure:
//
//     fracture::TriangleMesh mesh = must(fracture::import_mesh(file));
//
// Results of the engine: tools/brittle/base/device_failure.h.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "fracture/base/error.h"

namespace brittle::tools {

// Exit codes of the program. `brittle --help` lists them, and scripts rely on them.
enum ExitCode {
    exit_success = 0,
    exit_failure = 1,      // anything not listed below
    exit_usage = 2,        // a wrong command line
    exit_input = 3,        // an input file is missing, unreadable or damaged
    exit_mesh = 4,         // the mesh or the sites cannot be fractured
    exit_output = 5,       // an output could not be written; an existing file is unchanged
    exit_environment = 6,  // no display, no Vulkan device, or the device was lost
    exit_slower = 7,       // `profile --compare` found a slower time
    exit_differs = 8,      // `replay` reached a state that differs from the log's
    exit_interrupted = 130 // Ctrl+C; no half-written file is left
};

class Failure : public std::runtime_error {
  public:
    // Control characters of the message, which names from files may bring, are written as \x1b; lines stay.
    Failure(ExitCode code, const std::string& message);
    explicit Failure(const fracture::Error& error);

    [[nodiscard]] ExitCode code() const { return code_; }
    [[nodiscard]] std::optional<fracture::Status> status() const { return status_; } // of a failed Result
    // The same failure, with the place where it occurred before its message: "PLACE: MESSAGE".
    [[nodiscard]] Failure at(const std::string& place) const;

  private:
    ExitCode code_;
    std::optional<fracture::Status> status_{};
};

template<class T>
T must(fracture::Result<T>&& result) {
    if (!result) throw Failure(result.error());
    if constexpr (!std::is_void_v<T>) return *std::move(result);
}

} // namespace brittle::tools
