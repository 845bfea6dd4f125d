// Reads the files that a mesh file refers to: materials, images, buffers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fracture/base/error.h"
#include "fracture/io/model.h"

namespace brittle::fracture {

// Opens files in the folder of the mesh file and below only, so that a mesh from the network cannot read other files.
// Each file is read once, however often the mesh refers to it, so a small mesh file cannot take up much memory.
class Companions {
  public:
    // The folder; nothing for a mesh in memory, which has no files beside it.
    // geometry_only: the caller needs geometry only, so materials and images are not read.
    explicit Companions(std::optional<std::filesystem::path> folder, bool geometry_only = false)
        : folder_(std::move(folder)), geometry_only_(geometry_only) {}

    [[nodiscard]] bool wants_attributes() const { return !geometry_only_; }

    // Returns the content of the file with this name, a relative path with / or \. Valid as long as this object.
    Result<std::span<const std::byte>> read(const std::string& name);

    // The number of bytes in all files read so far.
    [[nodiscard]] uint64_t size() const { return size_; }

  private:
    std::optional<std::filesystem::path> folder_;
    bool geometry_only_;
    uint64_t size_ = 0;
    std::map<std::filesystem::path, std::vector<std::byte>> files_;
};

// The MIME type of an image, from its first bytes: PNG, JPEG, WebP, KTX2; empty for anything else.
[[nodiscard]] std::string image_type(std::span<const std::byte> bytes);

// Appends a note, a sentence for the reader of a report. Ignores it where there are many already.
void add_note(std::vector<std::string>& notes, std::string note);

} // namespace brittle::fracture
