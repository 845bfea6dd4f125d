// Draws a Scene: into an image in main memory, or into a window.
//
// Headless:
//
//     auto device = Device::create({});                      // Results: check each
//     auto renderer = Renderer::create(**device);
//     (*renderer)->add_pieces(pieces);
//     Scene scene{.camera = look_at_bounds(bounds, 0.5f, 0.3f, 16.0f / 9.0f), .bounds = bounds};
//     scene.write_poses = [&](std::span<BodyPose> poses, uint64_t) { world.poses(poses); };
//     Result<Bitmap> image = (*renderer)->render(scene, {1280, 720});
//     write_png(*image, "frame.png");
//
// With a window: attach(window) once, then present(scene, ui) each frame instead of render(). The renderer
// notices by itself that the window was resized or minimised. A Window must outlive the renderer attached to
// it, a Device every renderer made from it.
//
// Each frame is a frame graph declared anew: cull, shadow (left out where it can be kept), occlusion, shade, marks,
// enlarge (where fewer pixels were drawn), then read back, or UI and present. Body poses need no pass: the caller
// writes them into memory that is mapped for good and that the device reads in place, a slice for each of the two
// frames in flight. render() waits for its image.
//
// Where memory runs out, the call fails and the next one may succeed. After device_lost all calls fail so:
// destroy what was made from the device, and start again.
//
// Pixels are reproducible: the same scene gives the same bytes on the same device and driver. There is no
// dithering, no noise and no history. In a window on a CPU device things that move are drawn with fewer pixels
// (Quality::moving_scale). Shaders write sRGB themselves into UNORM targets, because a window's
// sRGB formats would encode the user interface's colours twice.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "engine/core/bitmap.h"
#include "engine/core/result.h"
#include "engine/gpu/device.h"
#include "engine/graph/pass_time.h"
#include "engine/render/piece_batch.h"
#include "engine/render/scene.h"

namespace brittle::engine {

class Window;

// What costs time on a device that has little. Unset members are chosen by the device: cheap on a CPU, good
// on a GPU.
struct Quality {
    std::optional<uint32_t> shadow_size{}; // texels a side, 64 to 8192; automatic: 1024 on a CPU, 2048 on a GPU
    std::optional<bool> soft_shadows{};    // filtered over 16 taps; automatic: on a GPU only. Off: 1 tap
    std::optional<uint32_t> samples{};     // a pixel, 1 or 4; automatic: 1 on a CPU, 4 on a GPU
    // Darkens gaps, and the ground under what stands on it, by a search in the depth image; automatic: on a
    // GPU only.
    std::optional<bool> ambient_occlusion{};
    // Finds out on the device which pieces are in view, and draws no others: the same picture. Automatic:
    // where the device has multi-draws.
    std::optional<bool> culling{};
    // Draws near pieces first, sorted by the CPU in each frame, so that hidden pixels are not shaded: the same picture
    // but where surfaces coincide. Automatic: on a CPU only.
    std::optional<bool> front_to_back{};
    // How many pixels a side present() draws for each of the window's while Scene::moved is true, and texels of the
    // shadow map for each of shadow_size, 0.25 to 1; the picture is enlarged, and the user interface drawn on it in
    // full. What is still is drawn in full, and so are pictures of render(). Automatic: 0.5 on a CPU, 1 on a GPU. 1
    // where the window system takes no copies.
    std::optional<float> moving_scale{};
};

struct RendererSettings {
    Quality quality{};
    bool vsync = true; // wait for the display before each present
};

// What the last frame drew: for tests and for the profile.
struct FrameStats {
    uint32_t pieces = 0;
    // Those in the camera's view, of the newest frame that the device has finished; without culling, all of
    // them.
    uint32_t pieces_in_view = 0;
    uint32_t draws = 0; // draw ranges in the indirect buffer: one for each exterior, one for each interior, but for
                        // pieces that have faded away
    uint32_t indirect_calls = 0; // multi-draw calls that draw them, over all passes
    uint64_t triangles = 0;      // of the pieces
    bool shadow_drawn = false;   // false when the kept shadow map was used
    float scale = 1.0f;          // see Quality::moving_scale
};

// Which piece each pixel shows.
struct IdImage {
    uint32_t width = 0;
    uint32_t height = 0;
    std::vector<uint32_t> ids; // row by row from the top: PieceHandle::number, 0: none

    [[nodiscard]] uint32_t at(uint32_t x, uint32_t y) const { return ids[size_t{y} * width + x]; }
};

class Renderer {
  public:
    [[nodiscard]] static Result<std::unique_ptr<Renderer>> create(Device& device,
                                                                  const RendererSettings& settings = {});
    ~Renderer();
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;

    [[nodiscard]] const Quality& quality() const; // as chosen: every member is set

    // Pieces come and go between frames. Nothing here waits for the device: the next frame copies the geometry, and
    // the space of removed pieces is used again in the order of frames. Handles are in the order of the pieces. Fails
    // with invalid_argument as PieceBatch::create() says, and on a body or an amount that the device cannot address,
    // or with out_of_memory; then nothing changes. A piece whose frame fails comes with the next.
    [[nodiscard]] Result<std::vector<PieceHandle>> add_pieces(PieceBatch batch);
    [[nodiscard]] Result<std::vector<PieceHandle>> add_pieces(std::vector<PieceBatch> batches); // all, or none
    [[nodiscard]] Result<std::vector<PieceHandle>> add_pieces(std::span<const PieceMesh> pieces);
    // Fails with invalid_argument on a handle of no piece that is there, and then removes none.
    [[nodiscard]] Result<void> remove_pieces(std::span<const PieceHandle> handles);
    // How far pieces have faded, from 0, as they come, to 1, where they are not drawn: by a fixed pattern of 8x8
    // pixels that they leave out, in their shadow as well; their wireframe is not drawn. Fails with invalid_argument
    // as remove_pieces() does, and on other values. While pieces fade, they alone cost a depth test late in the
    // pipeline.
    [[nodiscard]] Result<void> fade_pieces(std::span<const PieceHandle> handles, float fade);
    // Copies what a large batch holds to where the device reads it, so that the frame that shows it need not: a million
    // triangles are some ten milliseconds. On any thread, beside all else. A small batch stays as it is, and so does
    // one that there is no memory for. What was staged must go before the device does.
    void stage(PieceBatch& batch) const;
    // Removes all pieces and adds these.
    [[nodiscard]] Result<std::vector<PieceHandle>> set_pieces(std::span<const PieceMesh> pieces);
    [[nodiscard]] uint32_t body_count() const; // one more than the largest PieceMesh::body; 0 without pieces

    // Draws one frame off screen and reads it back. Width and height from 1 to the device's limit.
    [[nodiscard]] Result<Bitmap> render(const Scene& scene, glm::uvec2 size);

    // The picture that present() would show in a window of that size, but for the user interface: differs from render()
    // by Quality::moving_scale only. For tests, and to measure what a window costs.
    [[nodiscard]] Result<Bitmap> render_as_presented(const Scene& scene, glm::uvec2 size);

    // Which piece each pixel's middle shows, through everything but pieces. Sizes as for render().
    [[nodiscard]] Result<IdImage> render_ids(const Scene& scene, glm::uvec2 size);

    // Makes the swapchain and starts Dear ImGui on the window. Once in a renderer's life. `prepare_ui` is called once
    // Dear ImGui has its context: the place for fonts and style.
    [[nodiscard]] Result<void> attach(Window& window, const std::function<void()>& prepare_ui = {});

    // Draws one frame into the attached window. `ui` makes Dear ImGui calls between its new-frame and render;
    // empty for none. Returns false when there was nothing to draw into because the window is minimised.
    [[nodiscard]] Result<bool> present(const Scene& scene, const std::function<void()>& ui = {});
    // True while the mouse is over, or the keyboard goes to, the user interface: the application should then
    // leave that input alone.
    [[nodiscard]] bool ui_wants_mouse() const;
    [[nodiscard]] bool ui_wants_keyboard() const;

    // Draws every pass but the UI's once into a tiny target, so that the driver compiles every shader now
    // (0.1 to 0.5 s on a CPU device) and not in the first frame that needs it. After attach(), for the
    // window's format.
    [[nodiscard]] Result<void> warm_up();

    // Of the newest frame that the device has finished: in a window, one or two behind the newest.
    [[nodiscard]] const std::vector<PassTime>& timings() const;
    [[nodiscard]] const FrameStats& stats() const;      // of the newest frame
    [[nodiscard]] const std::string& graph_dot() const; // the newest frame's graph, for `dot -Tsvg`

  private:
    struct State;
    explicit Renderer(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

} // namespace brittle::engine
