// Recently opened files, kept in a text file with one path per line, the newest first.
//
//     RecentFiles recent(RecentFiles::usual_place());
//     recent.add("/meshes/bunny.obj");
//
// If the file cannot be read or written, the list is silently empty or not saved.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace brittle::tools {

class RecentFiles {
  public:
    static constexpr size_t max_files = 12;

    // Returns $XDG_STATE_HOME/brittle/recent, or ~/.local/state/brittle/recent; empty, which disables the list, if
    // neither is known.
    [[nodiscard]] static std::filesystem::path usual_place();

    explicit RecentFiles(std::filesystem::path place);
    // Moves a file to the front and saves the list. Shapes (shape:NAME) are skipped. Relative paths become absolute.
    void add(const std::string& file);
    [[nodiscard]] const std::vector<std::string>& files() const { return files_; }

  private:
    std::filesystem::path place_;
    std::vector<std::string> files_;
};

} // namespace brittle::tools
