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
// With a window, call attach(window) once, and present(scene, ui) in each frame instead of render(). The renderer
// follows the window's size by itself, and draws nothing while it is minimised. A Window must outlive the renderer
// attached to it, and a Device must outlive every renderer made from it.
//
// Each frame declares a new frame graph: upload, cull, shadow (skipped while the shadow map is valid), occlusion,
// shade, marks, upscale (if fewer pixels were drawn), and then either read back, or UI and present. Body poses need no
// pass: the caller writes them into permanently mapped memory, which the device reads in place, with one buffer for
// each of the two frames in flight. render() waits for its image.
//
// When memory runs out, the call fails and a later call may succeed. After device_lost, all calls fail with
// device_lost: destroy all objects made from the device, and create a new device.
//
// Pixels are reproducible: equal scenes give equal bytes on the same device and driver. There is no noise, no random
// dithering and no history. In a window on a CPU device, moving scenes are drawn with fewer pixels
// (Quality::moving_scale). Shaders write sRGB themselves into UNORM targets, because a window's sRGB formats would
// encode the user interface's colours twice.
//
// All functions run on one thread, except stage().
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
#include "engine/render/material_set.h"
#include "engine/render/piece_batch.h"
#include "engine/render/quality.h"
#include "engine/render/scene.h"

namespace brittle::engine {

class Window;

struct RendererSettings {
    Quality quality{};
    bool vsync = true; // wait for the display before each present
};

// Counts of the newest frame, for tests and for profiles.
struct FrameStats {
    uint32_t pieces = 0;
    // The pieces in the camera's view, in the newest frame that the device has finished; without culling, all pieces.
    uint32_t pieces_in_view = 0;
    uint32_t draws = 0; // draw ranges: one for each exterior and one for each interior, without fully faded pieces
    uint32_t indirect_calls = 0; // multi-draw calls over all passes
    uint64_t triangles = 0;      // triangles of all pieces
    bool shadow_drawn = false;   // false: the shadow map was reused
    float scale = 1.0f;          // Quality::moving_scale or 1
};

// The piece that each pixel shows.
struct IdImage {
    uint32_t width = 0;
    uint32_t height = 0;
    std::vector<uint32_t> ids; // PieceAttachment::id, or 0 for none; rows from top to bottom

    [[nodiscard]] uint32_t at(uint32_t x, uint32_t y) const { return ids[size_t{y} * width + x]; }
};

class Renderer {
  public:
    // Fails with invalid_argument when a member of Quality is out of range, or with the failure of a Vulkan call.
    [[nodiscard]] static Result<std::unique_ptr<Renderer>> create(Device& device,
                                                                  const RendererSettings& settings = {});
    ~Renderer();
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;

    [[nodiscard]] const Quality& quality() const; // the chosen quality; every member is set

    // Adds pieces between frames, without waiting for the device: the next frame copies the geometry, and the frame
    // graph orders the reuse of removed pieces' space. Returns handles in the order of the pieces. Fails as
    // PieceBatch::create() does, with invalid_argument on a body index or an amount that the device cannot address, and
    // with out_of_memory; then no piece is added. If the next frame fails, a later frame copies the geometry.
    [[nodiscard]] Result<std::vector<PieceHandle>> add_pieces(PieceBatch batch);
    [[nodiscard]] Result<std::vector<PieceHandle>> add_pieces(std::vector<PieceBatch> batches);
    [[nodiscard]] Result<std::vector<PieceHandle>> add_pieces(std::span<const PieceMesh> pieces);
    // Adds pieces that share the geometry of others on the device, solid, and attaches them. Any of them may be removed
    // first. Returns handles in the order of `handles`. Fails with invalid_argument on an unknown handle, a body index
    // or an amount that the device cannot address; then no piece is added.
    [[nodiscard]] Result<std::vector<PieceHandle>> copy_pieces(std::span<const PieceHandle> handles,
                                                               const PieceAttachment& attachment);
    // Removes pieces. Fails with invalid_argument on an unknown handle, and then removes none.
    [[nodiscard]] Result<void> remove_pieces(std::span<const PieceHandle> handles);
    // Sets the fade of pieces, from 0 (solid, as added) to 1 (not drawn). Fading is screen-door transparency: pixels
    // and shadow texels are discarded by a fixed 8x8 pattern. The wireframe of a fading piece is not drawn. Fails with
    // invalid_argument on an unknown handle or another value. Only fading pieces lose the early depth test.
    [[nodiscard]] Result<void> fade_pieces(std::span<const PieceHandle> handles, float fade);
    // Attaches pieces, whose geometry stays, to other bodies. Fails with invalid_argument on an unknown handle or a body
    // index that the device cannot address.
    [[nodiscard]] Result<void> attach_pieces(std::span<const PieceHandle> handles, const PieceAttachment& attachment);
    // Copies the geometry of a large batch into memory that the device reads, so that the frame which adds it need not
    // copy it on the CPU. Runs on any thread, concurrently with all other functions. A small batch, or one for which
    // there is no memory, stays unchanged. Staged batches must be destroyed before the device.
    void stage(PieceBatch& batch) const;
    // Removes all pieces and adds these.
    [[nodiscard]] Result<std::vector<PieceHandle>> set_pieces(std::span<const PieceMesh> pieces);
    // Sets the materials of meshes, for Scene::materials; those of the sets follow each other. Equal sets, by pointer,
    // change nothing; others wait for the device. Textures are uploaded by the first frame that shows them.
    [[nodiscard]] Result<void> set_materials(std::vector<std::shared_ptr<const MaterialSet>> sets);
    [[nodiscard]] uint32_t body_count() const; // one more than the largest PieceMesh::body; 0 without pieces

    // Draws one frame off screen and reads it back. Width and height are from 1 to the device's limit; other sizes fail
    // with invalid_argument.
    [[nodiscard]] Result<Bitmap> render(const Scene& scene, glm::uvec2 size);

    // Returns the picture that present() would show in a window of that size, without the user interface. It differs
    // from render() by Quality::moving_scale only. For tests and measurements.
    [[nodiscard]] Result<Bitmap> render_as_presented(const Scene& scene, glm::uvec2 size);

    // Returns the piece at the centre of each pixel, ignoring ground, lines and spheres. Sizes as for render().
    [[nodiscard]] Result<IdImage> render_ids(const Scene& scene, glm::uvec2 size);

    // Creates the swapchain and starts Dear ImGui on the window. May be called once. `prepare_ui` is called after Dear
    // ImGui's context was created, and may set fonts and style.
    [[nodiscard]] Result<void> attach(Window& window, const std::function<void()>& prepare_ui = {});

    // Draws one frame into the attached window. `ui` makes Dear ImGui calls between NewFrame() and Render(); it may be
    // empty. Returns false when the window could not be drawn into, because it is minimised or its system holds all
    // images.
    [[nodiscard]] Result<bool> present(const Scene& scene, const std::function<void()>& ui = {});
    // Return whether the user interface uses the mouse or the keyboard; the application should then ignore that input.
    [[nodiscard]] bool ui_wants_mouse() const;
    [[nodiscard]] bool ui_wants_keyboard() const;

    // Draws every pass but the UI's once into a tiny target, so that the driver compiles every shader now
    // instead of in the first frame that needs it; with set_materials(), those of materials, too. Call it after
    // attach(), for the window's format. It draws all pieces, too, so call it before many are added.
    [[nodiscard]] Result<void> warm_up();

    // Returns the times of the newest frame that the device has finished; in a window, it is one or two frames old.
    [[nodiscard]] const std::vector<PassTime>& timings() const;
    [[nodiscard]] const FrameStats& stats() const;      // the counts of the newest frame
    [[nodiscard]] const std::string& graph_dot() const; // the newest frame's graph, for `dot -Tsvg`

  private:
    struct State;
    explicit Renderer(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

} // namespace brittle::engine
