// Meshes on standard input and output, under the name "-".
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fracture/io/model.h"

namespace brittle::tools {

inline constexpr const char* standard_stream = "-";             // in the place of a file
inline constexpr uint64_t max_stream_bytes = uint64_t{4} << 30; // of a mesh on standard input; GLB files end there, too

// Reads a descriptor to its end. Throws a Failure with exit_input that begins with `name`, for more than `max_bytes` and
// for errors.
[[nodiscard]] std::vector<std::byte> read_stream(int descriptor, const std::string& name, uint64_t max_bytes);

// Reads a mesh from standard input, once in a run of the program. `format` is that of --format ("glb", "obj", ...), or
// empty: told by the first bytes. Throws a Failure.
[[nodiscard]] fracture::Model read_standard_mesh(const std::string& format);

// Throws a Failure with exit_usage if standard output is a terminal. To call before the work.
void refuse_terminal_output();
// Throws a Failure with exit_output if not all bytes can be written.
void write_standard_output(std::span<const std::byte> bytes);

} // namespace brittle::tools
