// The window of `brittle demo`: connects session, tools, panels and camera, once per frame.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>

#include "engine/core/window.h"
#include "engine/gpu/device.h"
#include "engine/render/renderer.h"
#include "tools/brittle/pictures/video.h"
#include "tools/brittle/studio/file_dialog.h"
#include "tools/brittle/studio/frame_times.h"
#include "tools/brittle/studio/idleness.h"
#include "tools/brittle/studio/navigation.h"
#include "tools/brittle/studio/panels.h"
#include "tools/brittle/studio/recent.h"
#include "tools/brittle/studio/session.h"
#include "tools/brittle/studio/tools.h"

namespace brittle::tools {

class Studio {
  public:
    // The renderer must be attached to the window with apply_style(scale), and warm. All arguments outlive the studio.
    Studio(engine::Window& window, engine::Device& device, engine::Renderer& renderer, Session& session, float scale);

    // Runs until the window closes. Throws a Failure if the device fails.
    void run();

  private:
    enum class Asked { open, recipe, pieces, replay, sequence };

    [[nodiscard]] bool is_lively() const; // whether the next frame differs even without input
    void handle(const engine::Input& input, double seconds);
    void handle_keys(const engine::Input& input);
    void perform(Command action);
    bool perform_view(Command action); // whether the command concerns the view
    void quit_or_close();
    void frame_selected();
    void fly(double seconds);
    void watch();
    void draw(const Viewport& view);
    void take_panels();
    void ask(Asked what);
    void answer(const std::filesystem::path& file);
    void answer_recipe(const std::string& file);
    void screenshot(const engine::Scene& scene);
    void begin_recording(const std::string& file);
    void record(const engine::Scene& scene);
    void end_recording();
    void show_title();
    [[nodiscard]] glm::vec2 window_size() const;
    [[nodiscard]] Viewport viewport() const;
    [[nodiscard]] float aspect() const; // of the free part of the window

    engine::Window& window_;
    engine::Device& device_;
    engine::Renderer& renderer_;
    Session& session_;
    float scale_;
    Recent recent_files_, recent_materials_;
    Navigation navigation_;
    Tools tools_;
    Panels panels_;
    FrameTimes times_;
    Idleness idleness_;
    FileDialog dialog_;
    Asked asked_ = Asked::open;
    std::string sequence_;         // name of the video, or pattern for names of pictures
    std::shared_ptr<Video> video_; // video that is being recorded; null for pictures
    glm::uvec2 recorded_size_{0};
    std::string title_;
    const Object* seen_ = nullptr; // object that the camera was last turned to
    bool screenshot_due_ = false;
};

} // namespace brittle::tools
