// Files that were opened lately: a text file, a path a line, the newest first.
//
//     RecentFiles recent(RecentFiles::usual_place());
//     recent.add("/meshes/bunny.obj");
//
// A convenience: where the file cannot be read or written, there are just no recent files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace brittle::tools {

class RecentFiles {
  public:
    static constexpr size_t most = 12;

    // $XDG_STATE_HOME/brittle/recent, or the same below ~/.local/state; empty where neither is known, which keeps none.
    [[nodiscard]] static std::filesystem::path usual_place();

    explicit RecentFiles(std::filesystem::path place);
    // To the front, and writes the list. Shapes (shape:NAME) are left out. Relative paths become absolute.
    void add(const std::string& file);
    [[nodiscard]] const std::vector<std::string>& files() const { return files_; }

  private:
    std::filesystem::path place_;
    std::vector<std::string> files_;
};

} // namespace brittle::tools
