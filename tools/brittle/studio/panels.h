// What the studio shows around its scene: columns with panels left and right, a bar of tools, a line of state, the help
// sheet. Dear ImGui and nothing else: panels read the session and answer with edits of its recipe and with actions.
//
// Nothing covers the scene: it is drawn into the middle of what is left free. Where the window is too narrow for both
// columns, the left one holds the panels of both; where it is too small for that, it goes, then the bar. What is higher than
// the window has a scroll bar.
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
    glm::vec2 free_min{0.0f}, free_max{0.0f}; // the scene's
    float left = 0.0f, right = 0.0f;          // widths of the columns; 0: not there
    float top = 0.0f, bottom = 0.0f;
};
[[nodiscard]] Layout layout_of(glm::vec2 window, float scale, bool panels);

// What of a picture sequence is done.
struct Recording {
    uint32_t done = 0, total = 0;
};

struct PanelState {
    Session& session;
    Tools& tools;
    const FrameTimes& times;
    const engine::Renderer& renderer;
    const RecentFiles& recent;
    std::string device;
    bool has_line_mode = true;
    float scale = 1.0f;
    glm::vec2 window{0.0f};
};

class Panels {
  public:
    void draw(const PanelState& state, const Overlay& overlay);
    // What was clicked since the last call.
    [[nodiscard]] std::vector<Command> take_actions() { return std::exchange(actions_, {}); }

    // Columns, or the help sheet while it is open, by nearly a page: 1 down, -1 up.
    void roll(int pages) { pages_ += pages; }

    bool shown = true;
    bool help = false;
    bool hint = true; // how to break something; until the first break
    std::optional<Recording> recording;

    // What the export window asks for.
    enum class ExportKind { none, pieces, recipe, replay, screenshot, sequence };
    bool export_open = false;
    [[nodiscard]] ExportKind take_export() { return std::exchange(export_, ExportKind::none); }
    int sequence_frames = 120;
    PiecesAs pieces_as = PiecesAs::they_lie; // of what is broken

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
    void pattern_panel(const PanelState& state);
    void material_panel(const PanelState& state);
    void tool_panel(const PanelState& state, float rows); // as high as so many, or higher
    void site_tools(const PanelState& state);
    void selected_sites(Session& session);
    void simulation_panel(const PanelState& state);
    void view_panel(const PanelState& state);
    void statistics_panel(const PanelState& state);
    void certificate(const PanelState& state);

    // The edit of a control that is dragged is one step of the history.
    void edit(Session& session, const Edit& edit);

    void roll_window() const; // the one that is being drawn

    std::vector<Command> actions_;
    ExportKind export_ = ExportKind::none;
    uint64_t gesture_ = 0;
    int pages_ = 0;    // to be rolled in this frame
    std::string told_; // the message that is shown, since when
    double told_at_ = 0.0;
};

} // namespace brittle::tools
