#include "engine/core/window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace brittle::engine {

namespace {

// Global, because GLFW's state is global and its error callback takes no user data.
int open_windows = 0;
std::string last_error;

Window& window_of(GLFWwindow* window) {
    return *static_cast<Window*>(glfwGetWindowUserPointer(window));
}

Modifiers modifiers_of(int bits) {
    return {(bits & GLFW_MOD_SHIFT) != 0, (bits & GLFW_MOD_CONTROL) != 0, (bits & GLFW_MOD_ALT) != 0};
}

} // namespace

Result<std::unique_ptr<Window>> Window::create(const WindowSettings& settings) {
    glfwSetErrorCallback([](int, const char* text) { last_error = text; });
    last_error.clear();
    // Once GLFW is initialised, further calls return true immediately.
    if (!glfwInit())
        return Error{Status::no_display, "cannot open a window, there is no display: " + last_error
                                             + ". Use `brittle render` to draw the same pictures into files."};

    std::unique_ptr<Window> window(new Window);
    ++open_windows; // the destructor counts down
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    window->window_ = glfwCreateWindow(static_cast<int>(settings.width), static_cast<int>(settings.height),
                                       settings.title.c_str(), nullptr, nullptr);
    if (!window->window_) return Error{Status::no_display, "cannot open a window: " + last_error};
    glfwSetWindowUserPointer(window->window_, window.get());
    window->install_callbacks();
    return window;
}

Window::~Window() {
    if (window_) glfwDestroyWindow(window_);
    if (--open_windows == 0) glfwTerminate();
}

// Must run before Dear ImGui installs its callbacks, because those call the previously installed ones
// (Renderer::attach()).
void Window::install_callbacks() {
    glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int, int action, int modifiers) {
        window_of(w).pending_input_.stirred = true;
        if (action != GLFW_PRESS) return;
        window_of(w).pending_input_.keys.push_back(static_cast<Key>(key));
        window_of(w).pending_input_.key_modifiers.push_back(modifiers_of(modifiers));
    });
    glfwSetDropCallback(window_, [](GLFWwindow* w, int count, const char** paths) {
        window_of(w).pending_input_.stirred = true;
        window_of(w).pending_input_.dropped.assign(paths, paths + count);
    });
    glfwSetScrollCallback(window_, [](GLFWwindow* w, double, double y) {
        window_of(w).pending_input_.stirred = true;
        window_of(w).pending_input_.scroll += static_cast<float>(y);
    });
    // A press sets the cursor position, so that a drag starts at zero even without an earlier motion event.
    glfwSetMouseButtonCallback(window_, [](GLFWwindow* w, int button, int action, int modifiers) {
        double x = 0.0, y = 0.0;
        glfwGetCursorPos(w, &x, &y);
        Input& input = window_of(w).pending_input_;
        input.stirred = true;
        input.cursor = {static_cast<float>(x), static_cast<float>(y)};
        if (button > GLFW_MOUSE_BUTTON_MIDDLE) return;
        input.buttons.push_back(
            {static_cast<Button>(button), action == GLFW_PRESS, input.cursor, modifiers_of(modifiers)});
    });
    glfwSetCursorPosCallback(window_, [](GLFWwindow* w, double x, double y) {
        Input& input = window_of(w).pending_input_;
        input.stirred = true;
        const glm::vec2 cursor(static_cast<float>(x), static_cast<float>(y));
        const glm::vec2 motion = cursor - input.cursor;
        input.cursor = cursor;
        const auto down = [w](int button) { return glfwGetMouseButton(w, button) == GLFW_PRESS; };
        if (down(GLFW_MOUSE_BUTTON_LEFT)) input.drag_left += motion;
        if (down(GLFW_MOUSE_BUTTON_MIDDLE)) input.drag_middle += motion;
        if (down(GLFW_MOUSE_BUTTON_RIGHT)) input.drag_right += motion;
    });
    glfwSetCharCallback(window_, [](GLFWwindow* w, unsigned) { window_of(w).pending_input_.stirred = true; });
    glfwSetCursorEnterCallback(window_, [](GLFWwindow* w, int) { window_of(w).pending_input_.stirred = true; });
    glfwSetWindowFocusCallback(window_, [](GLFWwindow* w, int) { window_of(w).pending_input_.stirred = true; });
    glfwSetWindowIconifyCallback(window_, [](GLFWwindow* w, int) { window_of(w).pending_input_.stirred = true; });
    glfwSetWindowRefreshCallback(window_, [](GLFWwindow* w) { window_of(w).pending_input_.stirred = true; });
    glfwSetFramebufferSizeCallback(window_,
                                   [](GLFWwindow* w, int, int) { window_of(w).pending_input_.stirred = true; });
}

const Input& Window::poll(double wait) {
    wait > 0.0 ? glfwWaitEventsTimeout(wait) : glfwPollEvents();
    const auto either = [this](int left, int right) {
        return glfwGetKey(window_, left) == GLFW_PRESS || glfwGetKey(window_, right) == GLFW_PRESS;
    };
    pending_input_.modifiers = {either(GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT),
                                either(GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL),
                                either(GLFW_KEY_LEFT_ALT, GLFW_KEY_RIGHT_ALT)};
    input_ = pending_input_;
    pending_input_ = Input{.cursor = input_.cursor};
    return input_;
}

void Window::wake() {
    glfwPostEmptyEvent();
}

bool Window::should_close() const {
    return glfwWindowShouldClose(window_) != 0;
}

void Window::close() {
    glfwSetWindowShouldClose(window_, GLFW_TRUE);
}

void Window::set_title(const std::string& title) {
    glfwSetWindowTitle(window_, title.c_str());
}

bool Window::is_down(Key key) const {
    return glfwGetKey(window_, static_cast<int>(key)) == GLFW_PRESS;
}

float Window::content_scale() const {
    float x = 1.0f, y = 1.0f;
    glfwGetWindowContentScale(window_, &x, &y);
    return std::max(x, y);
}

glm::uvec2 Window::framebuffer_size() const {
    if (glfwGetWindowAttrib(window_, GLFW_ICONIFIED)) return {0, 0}; // X11 reports the size before minimising
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    return {static_cast<uint32_t>(width), static_cast<uint32_t>(height)};
}

} // namespace brittle::engine
