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

fs::path Recent::usual_place(std::string_view name) {
    if (const char* state = std::getenv("XDG_STATE_HOME"); state && *state == '/')
        return fs::path(state) / "brittle" / name;
    if (const char* home = std::getenv("HOME"); home && *home == '/')
        return fs::path(home) / ".local/state/brittle" / name;
    return {};
}

Recent::Recent(fs::path place, size_t max_entries) : place_(std::move(place)), max_entries_(max_entries) {
    std::ifstream file(place_);
    for (std::string line; entries_.size() < max_entries_ && std::getline(file, line);)
        if (!line.empty()) entries_.push_back(line);
}

void Recent::add(const std::string& entry) {
    if (entry.empty() || entry.find('\n') != std::string::npos) return;
    const std::string newest = entry; // it may be one of the list
    std::erase(entries_, newest);
    entries_.insert(entries_.begin(), newest);
    if (entries_.size() > max_entries_) entries_.resize(max_entries_);
    if (place_.empty()) return;
    std::error_code error;
    fs::create_directories(place_.parent_path(), error);
    std::string text;
    for (const std::string& one : entries_) text += one + "\n";
    (void)fracture::write_file_atomically(place_, std::as_bytes(std::span(text)));
}

void add_file(Recent& recent, const std::string& file) {
    if (file.starts_with("shape:")) return;
    std::error_code error;
    const fs::path absolute = fs::absolute(file, error);
    if (!error) recent.add(absolute.lexically_normal().string());
}

} // namespace brittle::tools
