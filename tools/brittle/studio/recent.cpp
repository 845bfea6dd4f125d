#include "tools/brittle/studio/recent.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <span>
#include <system_error>
#include <utility>

#include "fracture/io/atomic_file.h"

namespace brittle::tools {

namespace fs = std::filesystem;

fs::path RecentFiles::usual_place() {
    if (const char* state = std::getenv("XDG_STATE_HOME"); state && *state == '/')
        return fs::path(state) / "brittle" / "recent";
    if (const char* home = std::getenv("HOME"); home && *home == '/')
        return fs::path(home) / ".local/state/brittle/recent";
    return {};
}

RecentFiles::RecentFiles(fs::path place) : place_(std::move(place)) {
    std::ifstream file(place_);
    for (std::string line; files_.size() < max_files && std::getline(file, line);)
        if (!line.empty()) files_.push_back(line);
}

void RecentFiles::add(const std::string& file) {
    if (file.starts_with("shape:") || file.find('\n') != std::string::npos) return;
    std::error_code error;
    const fs::path absolute = fs::absolute(file, error);
    if (error) return;
    const std::string name = absolute.lexically_normal().string();
    std::erase(files_, name);
    files_.insert(files_.begin(), name);
    if (files_.size() > max_files) files_.resize(max_files);
    if (place_.empty()) return;
    fs::create_directories(place_.parent_path(), error);
    std::string text;
    for (const std::string& one : files_) text += one + "\n";
    (void)fracture::write_file_atomically(place_, std::as_bytes(std::span(text)));
}

} // namespace brittle::tools
