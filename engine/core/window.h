// A window and its input, by GLFW. It contains no Vulkan; Renderer::attach() makes the surface.
//
//     Result<std::unique_ptr<Window>> window = Window::create({.title = "Brittle"});
//     if (!window) return fail(window.error()); // without a display, the message names `brittle render`
//     while (!(*window)->should_close()) {
//         const Input& input = (*window)->poll();
//         if (input.pressed(Key::space)) fracture();
//         camera.rotate(input.drag_left);
//         renderer.present(scene, draw_ui);
//     }
//
// All functions but wake() run on the thread that called create(). GLFW requires the main thread.
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

// GLFW's key codes. The code of a letter or digit is its upper-case ASCII code: Key('R').
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
    bool down = false; // true: pressed; false: released
    glm::vec2 cursor{0.0f};
    Modifiers modifiers{};
};

// The input between two polls. Distances are in screen units (pixels, on most systems), y downwards.
struct Input {
    std::vector<Key> keys{};                // the keys pressed, in order; repeats of a held key are omitted
    std::vector<Modifiers> key_modifiers{}; // the modifiers held at each key press; parallel to keys
    std::vector<ButtonEvent> buttons{};     // presses and releases, in order
    Modifiers modifiers{};                  // the modifiers held at the end of the poll
    std::vector<std::string> dropped{};     // paths of the files dropped on the window
    glm::vec2 cursor{0.0f};                 // position at the end of the poll, from the top left corner
    glm::vec2 drag_left{0.0f};              // cursor motion while the left button was down
    glm::vec2 drag_middle{0.0f};
    glm::vec2 drag_right{0.0f};
    float scroll = 0.0f; // notches; positive away from the user
    // An event may have changed the window's picture: any of the input above, a key release or repeat, text, focus,
    // a resize, or the window becoming visible again.
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
    // Opens a window. Fails with no_display when there is no window system or it refuses the window.
    [[nodiscard]] static Result<std::unique_ptr<Window>> create(const WindowSettings& settings);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    // Handles the pending events and returns the input since the previous poll. Without pending events, waits for one
    // for at most `wait` seconds. The reference stays valid, and its content constant, until the next poll.
    const Input& poll(double wait = 0.0);

    void wake(); // ends a wait of poll(); from any thread

    [[nodiscard]] bool should_close() const;
    void close(); // makes should_close() return true
    void set_title(const std::string& title);
    [[nodiscard]] bool is_down(Key key) const;
    // Returns the display's scale of text and controls: 1, or more on a display of high density.
    [[nodiscard]] float content_scale() const;

    // Returns the size of the window's picture in pixels, zero in both when the window is minimised.
    [[nodiscard]] glm::uvec2 framebuffer_size() const;
    [[nodiscard]] GLFWwindow* handle() const { return window_; }

  private:
    Window() = default;
    void install_callbacks();

    GLFWwindow* window_ = nullptr;
    Input pending_input_; // filled by the callbacks
    Input input_;         // the result of the last poll()
};

} // namespace brittle::engine
