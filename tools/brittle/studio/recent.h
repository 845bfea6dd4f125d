// What was used last, kept in a text file with one entry per line, the newest first: files, materials.
//
//     Recent files(Recent::usual_place("recent"), max_recent_files);
//     add_file(files, "/meshes/bunny.obj");
//
// If the file cannot be read or written, the list is silently empty or not saved.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace brittle::tools {

class Recent {
  public:
    // Returns $XDG_STATE_HOME/brittle/NAME, or ~/.local/state/brittle/NAME; empty, which keeps the list in memory only,
    // if neither is known.
    [[nodiscard]] static std::filesystem::path usual_place(std::string_view name);

    Recent(std::filesystem::path place, size_t max_entries);
    // Moves an entry to the front and saves the list. An entry that is empty or has several lines is skipped.
    void add(const std::string& entry);
    [[nodiscard]] const std::vector<std::string>& entries() const { return entries_; }

  private:
    std::filesystem::path place_;
    size_t max_entries_;
    std::vector<std::string> entries_;
};

inline constexpr size_t max_recent_files = 12, max_recent_materials = 3;

// Adds a file by its absolute path. Shapes (shape:NAME) are skipped.
void add_file(Recent& recent, const std::string& file);

} // namespace brittle::tools
