#include "tools/brittle/stage/standard_streams.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string_view>

#include <unistd.h>

#include "fracture/io/import.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

namespace {

constexpr size_t min_room_bytes = size_t{1} << 16; // bytes read at once at first; doubled whenever they are full

// "obj, stl, ply ..."
std::string known_formats() {
    std::string list;
    for (const std::string& extension : fracture::importable_extensions())
        list += (list.empty() ? "" : ", ") + extension.substr(1);
    return list;
}

} // namespace

std::vector<std::byte> read_stream(int descriptor, const std::string& name, uint64_t max_bytes) {
    std::vector<std::byte> bytes;
    size_t used = 0;
    for (;;) {
        // One byte more than allowed tells a stream that is too long from one that just fits.
        if (used == bytes.size())
            bytes.resize(static_cast<size_t>(
                std::min<uint64_t>(max_bytes + 1, std::max<uint64_t>(min_room_bytes, 2 * uint64_t{used}))));
        const ssize_t count = ::read(descriptor, bytes.data() + used, bytes.size() - used);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) throw Failure(exit_input, name + ": cannot be read: " + std::strerror(errno));
        used += static_cast<size_t>(count);
        if (used > max_bytes)
            throw Failure(exit_input, name + ": longer than " + std::to_string(max_bytes)
                                          + " bytes, the limit; write the mesh to a file and give its name");
        if (count == 0) break;
    }
    bytes.resize(used);
    return bytes;
}

fracture::Model read_standard_mesh(const std::string& format) {
    static bool is_read = false;
    const std::string name = "standard input";
    if (is_read) throw Failure(exit_usage, name + ": was read already; write the mesh to a file and give its name");
    is_read = true;
    if (::isatty(STDIN_FILENO) == 1)
        throw Failure(exit_usage, name
                                      + " is a terminal; send a mesh to it, as in `brittle inspect - < bunny.obj`, or "
                                        "give the name of a file");
    const std::vector<std::byte> bytes = read_stream(STDIN_FILENO, name, max_stream_bytes);
    if (bytes.empty())
        throw Failure(exit_input, name + ": is empty; send a mesh to it, as in `brittle inspect - < bunny.obj`");
    const std::string extension = format.empty() ? std::string(fracture::extension_of(bytes)) : "." + format;
    if (extension.empty())
        throw Failure(exit_input,
                      name + ": the first bytes do not tell the format of the mesh; give --format and one of "
                          + known_formats());
    return must(fracture::import_model(bytes, extension, name));
}

void refuse_terminal_output() {
    if (::isatty(STDOUT_FILENO) != 1) return;
    throw Failure(exit_usage,
                  "standard output is a terminal, and the mesh is data; send it to a file or a program, as in "
                  "`... -o - > pieces.glb`, or give the name of a file");
}

void write_standard_output(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t count = ::write(STDOUT_FILENO, bytes.data(), bytes.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0)
            throw Failure(exit_output, std::string("standard output: cannot be written: ") + std::strerror(errno));
        bytes = bytes.subspan(static_cast<size_t>(count));
    }
}

} // namespace brittle::tools
