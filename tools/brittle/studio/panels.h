// The panels of the studio: columns left and right of the scene, the tool bar, the status line, the help sheet. They
// use Dear ImGui only, read the session, and respond with edits of its recipe and with commands.
//
// Panels never cover the scene, which is drawn in the middle of the free part of the window. In a window too narrow for
// two columns the left one holds all panels; in a still smaller window the columns disappear first, then the bar. A
// column that is higher than the window has a scroll bar.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/render/renderer.h"
#include "tools/brittle/studio/frame_times.h"
#include "tools/brittle/studio/keys.h"
#include "tools/brittle/studio/recent.h"
#include "tools/brittle/studio/session.h"
#include "tools/brittle/studio/tools.h"

namespace brittle::tools {

struct Layout {
    glm::vec2 free_min{0.0f}, free_max{0.0f}; // free part, where the scene is drawn
    float left = 0.0f, right = 0.0f;          // widths of the columns; 0: hidden
    float top = 0.0f, bottom = 0.0f;
};
[[nodiscard]] Layout layout_of(glm::vec2 window, float scale, bool panels);

// Progress of a recorded sequence, in frames.
struct Recording {
    uint32_t done = 0, total = 0;
};

struct PanelState {
    Session& session;
    Tools& tools;
    const FrameTimes& times;
    const engine::Renderer& renderer;
    const Recent& recent_files;
    Recent& recent_materials;
    std::string device;
    bool has_line_mode = true;
    float scale = 1.0f;
    glm::vec2 window{0.0f};
};

class Panels {
  public:
    void draw(const PanelState& state, const Overlay& overlay);
    // Returns the commands clicked since the last call.
    [[nodiscard]] std::vector<Command> take_actions() { return std::exchange(actions_, {}); }

    // Scrolls the columns, or the help sheet while it is open, by nearly a page: 1 down, -1 up.
    void roll(int pages) { pages_ += pages; }

    bool shown = true;
    bool help = false;
    bool hint = true; // hint on breaking the mesh, shown until the first break
    std::optional<Recording> recording;

    // The choice made in the export window.
    enum class ExportKind { none, pieces, recipe, replay, screenshot, sequence };
    bool export_open = false;
    [[nodiscard]] ExportKind take_export() { return std::exchange(export_, ExportKind::none); }
    int sequence_frames = 120;
    PiecesAs pieces_as = PiecesAs::they_lie; // pose of exported pieces once the mesh is broken

  private:
    void left_column(const PanelState& state, const Layout& layout);
    void right_column(const PanelState& state, const Layout& layout);
    void bar(const PanelState& state, const Layout& layout);
    void state_line(const PanelState& state, const Layout& layout);
    void help_sheet(const PanelState& state);
    void export_window(const PanelState& state);
    void piece_options(Session& session);
    void message(const PanelState& state, const Layout& layout);
    void progress(const PanelState& state, const Layout& layout);

    void object_panel(const PanelState& state);
    void scene_panel(const PanelState& state);
    void object_list(Session& session);
    void selected_objects(Session& session, Recent& recent_materials);
    void pattern_panel(const PanelState& state);
    void material_panel(const PanelState& state);
    void cuts_panel(const PanelState& state);
    void tool_panel(const PanelState& state, float rows); // at least this many rows high
    void site_tools(const PanelState& state);
    void selected_sites(Session& session);
    void simulation_panel(const PanelState& state);
    void view_panel(const PanelState& state);
    void statistics_panel(const PanelState& state);
    void certificate(const PanelState& state);

    // Applies an edit. All edits of one drag of a control are one step of the history.
    void edit(Session& session, const Edit& edit);

    void roll_window() const; // scrolls the window that is being drawn

    std::vector<Command> actions_;
    ExportKind export_ = ExportKind::none;
    uint64_t gesture_ = 0;
    std::vector<uint32_t> listed_; // the selected objects in the last frame
    int pages_ = 0;                // pages to scroll in this frame
    std::string told_;             // message on display, and the time of its first display
    double told_at_ = 0.0;
    double worked_since_ = 0.0; // last time without work
};

} // namespace brittle::tools
