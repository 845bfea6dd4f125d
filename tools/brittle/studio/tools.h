// The tools of the studio: translate mouse gestures to edits of the recipe and to actions on the stage. The left button
// belongs to the selected tool; the right button, the middle button and the wheel move the camera.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "engine/core/window.h"
#include "tools/brittle/studio/gizmo.h"
#include "tools/brittle/studio/navigation.h"
#include "tools/brittle/studio/session.h"
#include "tools/brittle/studio/viewport.h"

namespace brittle::tools {

enum class Tool { inspect, sites, hammer, shoot, grab, anchors };

struct ToolInfo {
    std::string_view name;
    const char* key;
    const char* hint; // function of the left button
};
[[nodiscard]] const ToolInfo& info_of(Tool tool);
inline constexpr std::array all_tools{Tool::inspect, Tool::sites, Tool::hammer, Tool::shoot, Tool::grab, Tool::anchors};

// Graphics over the picture; pixels.
struct Overlay {
    struct Circle {
        glm::vec2 centre;
        float radius;
        bool strong;
    };
    // A painted anchor.
    struct Spot {
        glm::vec2 centre;
        float radius;
    };
    struct Axis {
        glm::vec2 from, to;
        int axis; // 0, 1, 2
        bool strong;
        bool scales = false; // ends in a square
    };
    struct Ring {
        std::vector<glm::vec2> points;
        int axis;
        bool strong;
    };
    struct Middle { // the handle in the middle of the gizmo
        glm::vec2 at;
        bool strong, scales;
    };
    std::vector<Circle> circles;
    std::vector<Spot> spots;
    std::vector<Axis> axes;  // axes of the gizmo
    std::vector<Ring> rings; // of the gizmo that turns
    std::optional<Middle> middle;
    std::optional<std::array<glm::vec2, 2>> box;    // corners of the selection
    std::string text;                               // what a drag does, beside the cursor
    std::vector<glm::vec2> idle;                    // sites without effect
    std::optional<std::array<glm::vec2, 2>> string; // from the grabbed point to the cursor
};

// Opens a mesh or a recipe that was dropped on the window; the last one of several. A mesh that joins a scene lies on
// what is under the cursor.
void open_dropped(const engine::Input& input, const Viewport& view, Session& session);

class Tools {
  public:
    [[nodiscard]] Tool tool() const { return tool_; }
    void choose(Tool tool, Session& session);

    [[nodiscard]] GizmoMode gizmo() const { return gizmo_; }
    void choose(GizmoMode mode) { gizmo_ = mode; }

    // `free`: the mouse is over the scene and not over a panel.
    void handle(const engine::Input& input, const Viewport& view, bool free, Session& session, Navigation& navigation);
    [[nodiscard]] Overlay overlay(const Viewport& view, const Session& session) const;
    [[nodiscard]] bool right_held() const { return right_; } // for flying
    // Whether a button that went down over the scene is held.
    [[nodiscard]] bool holds() const { return left_ || right_ || middle_; }

    // Act on the selected sites.
    void remove_selected(Session& session) const;
    void duplicate_selected(Session& session) const;
    // Mirrors in the middle of the mesh; all sites if none is selected.
    void mirror_selected(Session& session, int axis) const;

  private:
    enum class Drag { none, orbit, site, axis, gizmo, box, grab, paint, rub_out };

    void press(const engine::ButtonEvent& event, const Viewport& view, Session& session);
    void release(const engine::ButtonEvent& event, const Viewport& view, Session& session);
    void press_sites(const engine::ButtonEvent& event, const Viewport& view, Session& session);
    void place_site(const engine::ButtonEvent& event, const Viewport& view, Session& session);
    void press_anchors(const engine::ButtonEvent& event, const Viewport& view, Session& session);
    void paint_along(glm::vec2 to, const Viewport& view, Session& session);
    void paint(const Ray& ray, Session& session);
    void drag_to(glm::vec2 cursor, const Viewport& view, Session& session);
    void ring_sites(const Viewport& view, const Session& session, Overlay& overlay) const;
    void aim(const engine::Input& input, const Viewport& view, bool free, Session& session);
    [[nodiscard]] std::optional<uint32_t> site_at(glm::vec2 pixel, const Viewport& view, const Session& session) const;
    [[nodiscard]] std::optional<int> axis_at(glm::vec2 pixel, const Viewport& view, const Session& session) const;
    [[nodiscard]] std::optional<glm::vec3> gizmo_at(const Session& session) const;
    void hold_axis(int axis, glm::vec2 pixel, const Viewport& view, Session& session);
    void press_inspect(const engine::ButtonEvent& event, const Viewport& view, Session& session);
    void click_inspect(const engine::ButtonEvent& event, const Viewport& view, Session& session) const;
    [[nodiscard]] std::optional<GizmoFrame> gizmo_frame(const Session& session) const;
    void drag_gizmo(glm::vec2 cursor, const Viewport& view, Session& session);
    void lay_on_surface(glm::vec2 cursor, const Viewport& view, Session& session);
    void draw_gizmo(const Viewport& view, const Session& session, Overlay& overlay) const;

    Tool tool_ = Tool::inspect;
    Drag drag_ = Drag::none;
    bool left_ = false, right_ = false, middle_ = false; // pressed over the scene
    glm::vec2 cursor_{0.0f}, pressed_at_{0.0f}, painted_to_{0.0f};
    uint64_t gesture_ = 0;
    int axis_ = 0;
    engine::Modifiers modifiers_{}; // held in this frame
    GizmoMode gizmo_ = GizmoMode::move;
    std::optional<GizmoDrag> held_; // the handle that is dragged, and what it began with
    std::vector<uint32_t> held_objects_;
    std::vector<ObjectPlacement> held_places_;
    engine::Bounds held_box_;
    std::string held_text_;
    std::optional<GizmoHandle> over_; // the handle under the cursor
    glm::dvec3 dragged_{0.0};         // last position of the drag, on the stage
    std::optional<uint32_t> hovered_;
    std::optional<glm::vec3> aimed_; // point that the hammer or the brush would hit
    glm::vec3 target_{0.0f};
};

} // namespace brittle::tools
