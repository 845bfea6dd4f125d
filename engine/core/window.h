// A window and its input, by GLFW. Knows no Vulkan: Renderer::attach() makes a surface from it.
//
//     Result<std::unique_ptr<Window>> window = Window::create({.title = "Brittle"});
//     if (!window) return fail(window.error());           // no display: a message that names `brittle
//     render` while (!(*window)->should_close()) {
//         const Input& input = (*window)->poll();         // what happened since the previous poll
//         if (input.pressed(Key::space)) fracture();
//         camera.rotate(input.drag_left);
//         renderer.present(scene, draw_ui);
//     }
//
// Everything here runs on the thread that called create(), which GLFW wants to be the main thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "engine/core/result.h"

struct GLFWwindow;

namespace brittle::engine {

// Letters and digits are their upper-case ASCII code: Key('R').
enum class Key : int {
    space = 32,
    escape = 256,
    enter = 257,
    tab = 258,
    backspace = 259,
    right = 262,
    left = 263,
    down = 264,
    up = 265,
    page_up = 266,
    page_down = 267,
    f1 = 290,
    f2 = 291,
    f3 = 292,
    f4 = 293,
    f5 = 294,
    f6 = 295,
    f12 = 301,
    left_shift = 340,
    left_control = 341,
    left_alt = 342,
    delete_ = 261
};

struct Modifiers {
    bool shift = false;
    bool control = false;
    bool alt = false;

    friend bool operator==(const Modifiers&, const Modifiers&) = default;
};

enum class Button { left, right, middle };

struct ButtonEvent {
    Button button = Button::left;
    bool down = false; // pressed; else released
    glm::vec2 cursor{0.0f};
    Modifiers modifiers{};
};

// What happened between two polls. Distances are in screen units (pixels, on most systems), y downwards.
struct Input {
    std::vector<Key> keys{}; // pressed since the previous poll, in order; repeats of a held key are left out
    std::vector<Modifiers> key_modifiers{}; // held when each of the keys was pressed
    std::vector<ButtonEvent> buttons{};     // pressed or released, in order
    Modifiers modifiers{};                  // held now
    std::vector<std::string> dropped{};     // paths of files that were dropped on the window
    glm::vec2 cursor{0.0f};                 // position now, from the top left corner
    glm::vec2 drag_left{0.0f};              // motion of the cursor while this button was down
    glm::vec2 drag_middle{0.0f};
    glm::vec2 drag_right{0.0f};
    float scroll = 0.0f; // notches; positive away from the user
    // Something came that may change what the window should show: any of the above, a released or repeated key, text, focus,
    // another size, or what lay before the window went away.
    bool stirred = false;

    [[nodiscard]] bool pressed(Key key) const { return std::find(keys.begin(), keys.end(), key) != keys.end(); }
    [[nodiscard]] bool pressed(char key) const { return pressed(static_cast<Key>(key)); }
};

struct WindowSettings {
    std::string title = "Brittle";
    uint32_t width = 1280; // screen units
    uint32_t height = 720;
};

class Window {
  public:
    // Fails with no_display where there is no window system.
    [[nodiscard]] static Result<std::unique_ptr<Window>> create(const WindowSettings& settings);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    // Handles pending events; where there are none, waits so long for one, s. The reference stays valid, and its content
    // unchanged, until the next poll.
    const Input& poll(double wait = 0.0);

    [[nodiscard]] bool should_close() const;
    void close(); // should_close() is true from now on
    void set_title(const std::string& title);
    [[nodiscard]] bool is_down(Key key) const; // held now
    // Pixels by which the display wants text larger than usual: 1, or 2 on a display of high density.
    [[nodiscard]] float content_scale() const;

    // In pixels; zero in both when the window is minimised.
    [[nodiscard]] glm::uvec2 framebuffer_size() const;
    [[nodiscard]] GLFWwindow* handle() const { return window_; }

  private:
    Window() = default;
    void install_callbacks();

    GLFWwindow* window_ = nullptr;
    Input pending_input_; // filled by the callbacks
    Input input_;         // what poll() handed out
};

} // namespace brittle::engine
