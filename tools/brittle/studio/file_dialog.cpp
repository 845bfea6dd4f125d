#include "tools/brittle/studio/file_dialog.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include <imgui.h>

namespace brittle::tools {

namespace fs = std::filesystem;

namespace {

constexpr size_t max_name_bytes = 4096;

} // namespace

void FileDialog::open(std::string title, const fs::path& folder, const std::string& name,
                      std::vector<std::string> endings, bool saves) {
    title_ = std::move(title);
    endings_ = std::move(endings);
    saves_ = saves;
    open_ = appeared_ = true;
    confirmed_ = false;
    std::error_code error;
    folder_ = fs::absolute(folder.empty() ? fs::path(".") : folder, error).lexically_normal();
    name_.assign(max_name_bytes, '\0');
    std::copy_n(name.begin(), std::min(name.size(), max_name_bytes - 1), name_.begin());
    list();
}

void FileDialog::list() {
    entries_.clear();
    std::error_code error;
    for (fs::directory_iterator at(folder_, fs::directory_options::skip_permission_denied, error), end;
         !error && at != end; at.increment(error)) {
        const std::string name = at->path().filename().string();
        if (name.starts_with('.')) continue;
        std::error_code unknown;
        if (at->is_directory(unknown))
            entries_.push_back({name, true});
        else if (std::find(endings_.begin(), endings_.end(), at->path().extension().string()) != endings_.end())
            entries_.push_back({name, false});
    }
    std::sort(entries_.begin(), entries_.end(),
              [](const Entry& a, const Entry& b) { return a.folder != b.folder ? a.folder : a.name < b.name; });
}

std::optional<fs::path> FileDialog::draw(float scale) {
    if (!open_) return std::nullopt;
    std::optional<fs::path> chosen;
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({display.x * 0.5f, display.y * 0.5f}, ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::SetNextWindowSize({std::min(520.0f * scale, display.x), std::min(420.0f * scale, display.y)});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 1.0f);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 6.0f * scale);
    ImGui::Begin((title_ + "###file dialog").c_str(), &open_,
                 ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove
                     | ImGuiWindowFlags_NoSavedSettings);
    ImGui::TextDisabled("%s", folder_.c_str());
    ImGui::BeginChild("entries", {0.0f, -2.0f * ImGui::GetFrameHeightWithSpacing()}, true);
    std::optional<fs::path> into;
    if (folder_.has_parent_path() && ImGui::Selectable("..")) into = folder_.parent_path();
    for (const Entry& entry : entries_) {
        if (ImGui::Selectable((entry.folder ? entry.name + "/" : entry.name).c_str(), false,
                              ImGuiSelectableFlags_AllowDoubleClick)) {
            if (entry.folder) {
                into = folder_ / entry.name;
            } else {
                std::fill(name_.begin(), name_.end(), '\0');
                std::copy_n(entry.name.begin(), std::min(entry.name.size(), max_name_bytes - 1), name_.begin());
                if (ImGui::IsMouseDoubleClicked(0)) chosen = folder_ / entry.name;
            }
        }
    }
    ImGui::EndChild();
    if (into) {
        folder_ = *into;
        list();
    }
    ImGui::SetNextItemWidth(-1.0f);
    if (appeared_) ImGui::SetKeyboardFocusHere();
    appeared_ = false;
    ImGui::InputText("##name", name_.data(), name_.size(), ImGuiInputTextFlags_AutoSelectAll);
    const bool entered = std::exchange(confirmed_, false);
    if ((ImGui::Button(saves_ ? "Save" : "Open", {96.0f * scale, 0.0f}) || entered) && name_[0])
        chosen = folder_ / name_.data();
    ImGui::SameLine();
    if (ImGui::Button("Cancel", {96.0f * scale, 0.0f})) open_ = false;
    ImGui::End();
    ImGui::PopStyleVar(2);
    if (chosen) open_ = false;
    return chosen;
}

} // namespace brittle::tools
