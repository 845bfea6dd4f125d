#include "tools/brittle/studio/keys.h"

#include <array>

namespace brittle::tools {

namespace {

using engine::Key;
using engine::Modifiers;

constexpr Modifiers none{}, control{.control = true}, control_shift{.shift = true, .control = true};
constexpr Key key(char c) {
    return static_cast<Key>(c);
}

constexpr std::array bindings{
    KeyBinding{Key::space, none, Command::break_all, "Space", "break it"},
    KeyBinding{key('R'), none, Command::reset, "R", "whole again"},
    KeyBinding{key('P'), none, Command::pause, "P", "pause, go on"},
    KeyBinding{key('.'), none, Command::step, ".", "a single step"},
    KeyBinding{key('F'), none, Command::frame, "F", "frame the selected piece, or all"},
    KeyBinding{key('X'), none, Command::explode, "X", "exploded view"},
    KeyBinding{key('V'), none, Command::cells, "V", "Voronoi cells, on the mesh as it will break"},
    KeyBinding{key('S'), none, Command::sites, "S", "sites"},
    KeyBinding{key('C'), none, Command::colours, "C", "materials, or a colour for each piece"},
    KeyBinding{key('O'), none, Command::wireframe, "O", "edges of triangles"},
    KeyBinding{key('N'), none, Command::smooth, "N", "smooth or flat"},
    KeyBinding{key('D'), none, Command::hulls, "D", "collision hulls"},
    KeyBinding{key('B'), none, Command::bonds, "B", "bonds, by their load"},
    KeyBinding{Key::f1, none, Command::tool_inspect, "F1", "tool: inspect"},
    KeyBinding{Key::f2, none, Command::tool_sites, "F2", "tool: place sites"},
    KeyBinding{Key::f3, none, Command::tool_hammer, "F3", "tool: hammer"},
    KeyBinding{Key::f4, none, Command::tool_shoot, "F4", "tool: shoot"},
    KeyBinding{Key::f5, none, Command::tool_grab, "F5", "tool: grab"},
    KeyBinding{Key::f6, none, Command::tool_anchors, "F6", "tool: paint anchors"},
    KeyBinding{key('W'), none, Command::gizmo_move, "W, E, T",
               "arrows, rings, scales on selected objects (Ctrl: steps)"},
    KeyBinding{key('E'), none, Command::gizmo_turn, "", ""},
    KeyBinding{key('T'), none, Command::gizmo_scale, "", ""},
    KeyBinding{key('1'), none, Command::material_1, "1 - 6", "glass, stone, concrete, wood, ceramic, brick"},
    KeyBinding{key('2'), none, Command::material_2, "", ""},
    KeyBinding{key('3'), none, Command::material_3, "", ""},
    KeyBinding{key('4'), none, Command::material_4, "", ""},
    KeyBinding{key('5'), none, Command::material_5, "", ""},
    KeyBinding{key('6'), none, Command::material_6, "", ""},
    KeyBinding{Key::delete_, none, Command::remove, "Del", "delete the selected objects or sites"},
    KeyBinding{key('D'), control, Command::duplicate, "Ctrl+D", "duplicate them"},
    KeyBinding{key('M'), control, Command::mirror, "Ctrl+M", "mirror the selected sites across X"},
    KeyBinding{key('Z'), control, Command::undo, "Ctrl+Z", "undo"},
    KeyBinding{key('Z'), control_shift, Command::redo, "Ctrl+Shift+Z", "redo"},
    KeyBinding{key('S'), control, Command::save, "Ctrl+S", "save the recipe"},
    KeyBinding{key('O'), control, Command::open, "Ctrl+O", "open a mesh or a recipe"},
    KeyBinding{key('E'), control, Command::export_dialog, "Ctrl+E", "export"},
    KeyBinding{Key::f12, none, Command::screenshot, "F12", "screenshot"},
    KeyBinding{Key::tab, none, Command::panels, "Tab", "hide or show the panels"},
    KeyBinding{Key::page_down, none, Command::page_down, "Page up, down", "roll the panels, or this help"},
    KeyBinding{Key::page_up, none, Command::page_up, "", ""},
    KeyBinding{key('H'), none, Command::help, "H", "this help"},
    KeyBinding{Key::escape, none, Command::quit, "Esc", "close what is open, or quit"},
};

constexpr std::array mouse{
    MouseHelp{"left", "the tool in use"},
    MouseHelp{"right drag", "orbit; so does Alt + left drag"},
    MouseHelp{"right + W A S D", "fly; Q and E go down and up"},
    MouseHelp{"middle drag", "pan; so does Shift + right drag"},
    MouseHelp{"wheel", "zoom to the cursor"},
    MouseHelp{"Shift + left drag", "select the objects within a box"},
    MouseHelp{"Shift + wheel", "radius of hammer, ball or brush"},
};

} // namespace

std::span<const KeyBinding> key_bindings() {
    return bindings;
}

std::optional<Command> command_for(engine::Key pressed, const engine::Modifiers& modifiers) {
    for (const KeyBinding& binding : bindings)
        if (binding.key == pressed && binding.modifiers == modifiers) return binding.action;
    return std::nullopt;
}

std::span<const MouseHelp> mouse_help() {
    return mouse;
}

} // namespace brittle::tools
