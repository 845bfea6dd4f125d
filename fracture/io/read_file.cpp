#include "fracture/io/read_file.h"

#include <cerrno>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace brittle::fracture {
namespace {

struct Descriptor {
    int number = -1;
    explicit Descriptor(int n) : number(n) {}
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor() {
        if (number >= 0) ::close(number);
    }
};

Error not_found(const std::filesystem::path& file, const std::string& reason) {
    return {Status::file_not_found, file.string() + ": " + reason};
}

} // namespace

Result<std::vector<std::byte>> read_file(const std::filesystem::path& file) {
    // Without O_NONBLOCK, opening a pipe waits for its writer.
    const Descriptor descriptor(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (descriptor.number < 0) return not_found(file, std::string("cannot open: ") + std::strerror(errno));

    struct stat info {};
    if (::fstat(descriptor.number, &info) != 0) return not_found(file, std::strerror(errno));
    if (S_ISDIR(info.st_mode)) return not_found(file, "is a folder; name a file in it");
    if (!S_ISREG(info.st_mode)) return not_found(file, "is not a regular file; copy it to one first");
    const auto size = static_cast<uint64_t>(info.st_size);
    if (size == 0) return Error{Status::malformed_file, file.string() + ": the file is empty (0 bytes)"};
    if (size >= max_file_size) {
        return Error{Status::malformed_file, file.string() + ": the file has " + std::to_string(size)
                                                 + " bytes; files of 4 GiB and more are not read, simplify the mesh"};
    }

    std::vector<std::byte> bytes(size);
    size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t got = ::read(descriptor.number, bytes.data() + done, bytes.size() - done);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return not_found(file, std::string("cannot read: ") + std::strerror(errno));
        if (got == 0) break; // the file shrank meanwhile
        done += static_cast<size_t>(got);
    }
    bytes.resize(done);
    return bytes;
}

} // namespace brittle::fracture
