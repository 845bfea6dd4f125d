// A small dialog for the name of a file, with a list of the folder's contents.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace brittle::tools {

class FileDialog {
  public:
    // Opens the dialog. Files with other endings are not listed. `saves`: the file need not exist.
    void open(std::string title, const std::filesystem::path& folder, const std::string& name,
              std::vector<std::string> endings, bool saves);
    [[nodiscard]] bool is_open() const { return open_; }
    void close() { open_ = false; }
    // Confirms the name, as the button does: Dear ImGui 1.86 misses a key that is pressed and released between two
    // frames.
    void confirm() { confirmed_ = open_; }
    // Draws the dialog; returns the chosen file once.
    [[nodiscard]] std::optional<std::filesystem::path> draw(float scale);

  private:
    struct Entry {
        std::string name;
        bool folder;
    };
    void list();

    bool open_ = false;
    bool saves_ = false;
    bool appeared_ = false;
    bool confirmed_ = false;
    std::string title_;
    std::filesystem::path folder_;
    std::vector<std::string> endings_;
    std::vector<Entry> entries_;
    std::vector<char> name_;
};

} // namespace brittle::tools
