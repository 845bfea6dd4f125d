// The table of the studio's keys, used by the window, the help sheet and the documents.
#pragma once

#include <optional>
#include <span>

#include "engine/core/window.h"

namespace brittle::tools {

enum class Command {
    break_all,
    reset,
    pause,
    step,
    frame,
    explode,
    wireframe,
    colours,
    smooth,
    hulls,
    bonds,
    cells,
    sites,
    help,
    panels,
    page_up,
    page_down,
    tool_inspect,
    tool_sites,
    tool_hammer,
    tool_shoot,
    tool_grab,
    tool_anchors,
    gizmo_move,
    gizmo_turn,
    gizmo_scale,
    material_1,
    material_2,
    material_3,
    material_4,
    material_5,
    material_6,
    undo,
    redo,
    save,
    open,
    export_dialog,
    screenshot,
    duplicate,
    mirror,
    remove,
    quit
};

struct KeyBinding {
    engine::Key key;
    engine::Modifiers modifiers;
    Command action;
    const char* shown; // name of the key for people
    const char* what;
};

[[nodiscard]] std::span<const KeyBinding> key_bindings();
[[nodiscard]] std::optional<Command> command_for(engine::Key key, const engine::Modifiers& modifiers);

struct MouseHelp {
    const char* shown;
    const char* what;
};
[[nodiscard]] std::span<const MouseHelp> mouse_help();

} // namespace brittle::tools
