// The files that a mesh file names: materials, images, buffers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fracture/base/error.h"
#include "fracture/io/model.h"

namespace brittle::fracture {

// Opens files in the mesh file's folder and below only: a mesh from the network must not read what it likes. Each is
// read once however often it is named, so a small file cannot unfold into much memory.
class Companions {
  public:
    // without_looks: the caller wants geometry only, so materials and images need not be looked for.
    explicit Companions(std::filesystem::path folder, bool without_looks = false)
        : folder_(std::move(folder)), without_looks_(without_looks) {}

    [[nodiscard]] bool wants_looks() const { return !without_looks_; }

    // The content of the file of that name (a path with / or \). Valid as long as this object.
    Result<std::span<const std::byte>> read(const std::string& name);

    // Bytes of all files read.
    [[nodiscard]] uint64_t size() const { return size_; }

  private:
    std::filesystem::path folder_;
    bool without_looks_;
    uint64_t size_ = 0;
    std::map<std::filesystem::path, std::vector<std::byte>> files_;
};

// The MIME type that the first bytes tell: PNG, JPEG, WebP, KTX2; empty for anything else.
[[nodiscard]] std::string image_type(std::span<const std::byte> bytes);

// Appends a note for people, unless there are many already.
void add_note(std::vector<std::string>& notes, std::string note);

} // namespace brittle::fracture
