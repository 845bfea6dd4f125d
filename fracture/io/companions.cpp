#include "fracture/io/companions.h"

#include <algorithm>

#include "fracture/io/read_file.h"
#include "fracture/io/text_cursor.h"

namespace brittle::fracture {

namespace {

constexpr size_t max_notes = 30;
constexpr size_t max_name_length = 1000; // bytes, folders included

} // namespace

Result<std::span<const std::byte>> Companions::read(const std::string& name) {
    // File names have no control characters, and error messages would repeat them.
    const bool is_odd = std::any_of(name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
    if (is_odd || name.size() > max_name_length)
        return Error{Status::malformed_file, quoted(std::string_view(name)) + " is not the name of a file"};
    std::string slashed = name;
    std::replace(slashed.begin(), slashed.end(), '\\', '/');
    const std::filesystem::path file = std::filesystem::path(slashed).lexically_normal();
    const bool is_below = file.is_relative() && !file.empty() && *file.begin() != ".." && file.has_filename();
    if (!is_below || slashed.find("://") != slashed.npos)
        return Error{Status::malformed_file, quoted(std::string_view(name)) + " is not a file below its own folder"};
    const auto known = files_.find(file);
    if (known != files_.end()) return std::span<const std::byte>(known->second);
    if (!folder_)
        return Error{Status::file_not_found, quoted(std::string_view(name))
                                                 + " lies beside a mesh file, and this mesh "
                                                   "is read from memory: use a .glb"};
    Result<std::vector<std::byte>> bytes = read_file(*folder_ / file);
    if (!bytes) return bytes.error();
    size_ += bytes->size();
    return std::span<const std::byte>(files_.emplace(file, std::move(*bytes)).first->second);
}

std::string image_type(std::span<const std::byte> bytes) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), std::min<size_t>(bytes.size(), 12));
    if (text.starts_with("\x89PNG\r\n\x1a\n")) return "image/png";
    if (text.starts_with("\xff\xd8\xff")) return "image/jpeg";
    if (text.starts_with("RIFF") && text.ends_with("WEBP")) return "image/webp";
    if (text.starts_with("\xabKTX 20\xbb")) return "image/ktx2";
    return {};
}

void add_note(std::vector<std::string>& notes, std::string note) {
    if (notes.size() == max_notes) notes.emplace_back("further notes are omitted");
    if (notes.size() < max_notes) notes.push_back(std::move(note));
}

} // namespace brittle::fracture
