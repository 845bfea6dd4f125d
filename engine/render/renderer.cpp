#include "engine/render/renderer.h"

#include <string>

#include <imgui.h>

#include "engine/gpu/check.h"
#include "engine/render/renderer_state.h"

namespace brittle::engine {

namespace {

// Bytes from which a batch gets a staging buffer of its own: copying fewer is cheaper than an allocation.
constexpr uint64_t min_staged_bytes = 64 << 10;

Result<void> check_size(const Device& device, glm::uvec2 size) {
    const uint32_t largest = device.limits().maxImageDimension2D;
    if (size.x == 0 || size.y == 0 || size.x > largest || size.y > largest)
        return Error{Status::invalid_argument, "cannot draw a picture of " + std::to_string(size.x) + " x "
                                                   + std::to_string(size.y) + " pixels: each side must be 1 to "
                                                   + std::to_string(largest)};
    return {};
}

} // namespace

Renderer::Renderer(std::unique_ptr<State> state) : state_(std::move(state)) {}

Renderer::~Renderer() = default;

Result<std::unique_ptr<Renderer>> Renderer::create(Device& device, const RendererSettings& settings) {
    return guarded([&]() -> Result<std::unique_ptr<Renderer>> {
        Result<Quality> quality = choose_quality(settings.quality, device);
        if (!quality) return quality.error();
        return std::unique_ptr<Renderer>(
            new Renderer(std::make_unique<State>(device, RendererSettings{*quality, settings.vsync})));
    });
}

const Quality& Renderer::quality() const {
    return state_->quality();
}

Result<std::vector<PieceHandle>> Renderer::set_pieces(std::span<const PieceMesh> pieces) {
    return state_->run([&]() -> Result<std::vector<PieceHandle>> {
        Result<PieceBatch> batch = PieceBatch::create(pieces);
        if (!batch) return batch.error();
        Result<std::vector<PieceHandle>> handles = state_->pieces.replace_all(*std::move(batch));
        if (!handles) return handles;
        state_->invalidate_shadow_map();
        // The indices of bodies now refer to other bodies.
        for (const auto& slot : state_->slots) slot->poses_moment = 0;
        return handles;
    });
}

Result<std::vector<PieceHandle>> Renderer::add_pieces(std::span<const PieceMesh> pieces) {
    Result<PieceBatch> batch = state_->run([&] { return PieceBatch::create(pieces); });
    if (!batch) return batch.error();
    return add_pieces(*std::move(batch));
}

Result<std::vector<PieceHandle>> Renderer::add_pieces(PieceBatch batch) {
    std::vector<PieceBatch> one;
    one.push_back(std::move(batch));
    return add_pieces(std::move(one));
}

Result<std::vector<PieceHandle>> Renderer::add_pieces(std::vector<PieceBatch> batches) {
    return state_->run([&]() -> Result<std::vector<PieceHandle>> {
        Result<std::vector<PieceHandle>> handles = state_->pieces.add(std::move(batches));
        if (handles) state_->invalidate_shadow_map();
        return handles;
    });
}

void Renderer::stage(PieceBatch& batch) const {
    if (batch.staged() || batch.bytes() < min_staged_bytes) return;
    (void)guarded([&]() -> Result<void> {
        batch.move_to(state_->staging.take(batch.bytes()));
        return {};
    });
}

Result<std::vector<PieceHandle>> Renderer::copy_pieces(std::span<const PieceHandle> handles,
                                                       const PieceAttachment& attachment) {
    return state_->run([&]() -> Result<std::vector<PieceHandle>> {
        Result<std::vector<PieceHandle>> copies = state_->pieces.copy(handles, attachment);
        if (copies) state_->invalidate_shadow_map();
        return copies;
    });
}

Result<void> Renderer::remove_pieces(std::span<const PieceHandle> handles) {
    return state_->run([&]() -> Result<void> {
        Result<void> removed = state_->pieces.remove(handles);
        if (removed) state_->invalidate_shadow_map();
        return removed;
    });
}

Result<void> Renderer::fade_pieces(std::span<const PieceHandle> handles, float fade) {
    return state_->run([&]() -> Result<void> {
        Result<void> faded = state_->pieces.fade(handles, fade);
        if (faded) state_->invalidate_shadow_map();
        return faded;
    });
}

Result<void> Renderer::attach_pieces(std::span<const PieceHandle> handles, const PieceAttachment& attachment) {
    return state_->run([&]() -> Result<void> {
        Result<void> attached = state_->pieces.attach(handles, attachment);
        if (attached) state_->invalidate_shadow_map();
        return attached;
    });
}

Result<void> Renderer::set_materials(std::vector<std::shared_ptr<const MaterialSet>> sets) {
    return state_->run([&]() -> Result<void> {
        if (sets == state_->material_sets) return {};
        state_->device.wait_idle();
        state_->materials.reset();
        state_->material_sets = std::move(sets);
        state_->invalidate_shadow_map(); // cut-outs cast other shadows
        return {};
    });
}

uint32_t Renderer::body_count() const {
    return state_->pieces.bodies();
}

Result<Bitmap> Renderer::render(const Scene& scene, glm::uvec2 size) {
    return state_->run([&]() -> Result<Bitmap> {
        if (Result<void> valid = check_size(state_->device, size); !valid) return valid.error();
        return state_->draw_off_screen(scene, {Format::rgba8_unorm, {size.x, size.y}});
    });
}

Result<Bitmap> Renderer::render_as_presented(const Scene& scene, glm::uvec2 size) {
    return state_->run([&]() -> Result<Bitmap> {
        if (Result<void> valid = check_size(state_->device, size); !valid) return valid.error();
        return state_->draw_off_screen(scene, {Format::rgba8_unorm, {size.x, size.y}, state_->window_scale(scene)});
    });
}

Result<IdImage> Renderer::render_ids(const Scene& scene, glm::uvec2 size) {
    return state_->run([&]() -> Result<IdImage> {
        if (Result<void> valid = check_size(state_->device, size); !valid) return valid.error();
        return state_->draw_ids(scene, {size.x, size.y});
    });
}

Result<void> Renderer::attach(Window& window, const std::function<void()>& prepare_ui) {
    return state_->run([&]() -> Result<void> {
        if (state_->window) return Error{Status::invalid_argument, "the renderer already draws into a window"};
        auto swapchain = std::make_unique<Swapchain>(state_->device, window, state_->settings.vsync, frames_in_flight);
        state_->ui = std::make_unique<UiPass>(state_->device, window, *swapchain, prepare_ui);
        state_->swapchain = std::move(swapchain);
        state_->window = &window;
        return {};
    });
}

Result<bool> Renderer::present(const Scene& scene, const std::function<void()>& ui) {
    return state_->run([&]() -> Result<bool> {
        if (!state_->window) return Error{Status::invalid_argument, "present() needs attach() first"};
        return state_->draw_in_window(scene, ui);
    });
}

bool Renderer::ui_wants_mouse() const {
    return state_->ui && ImGui::GetIO().WantCaptureMouse;
}

bool Renderer::ui_wants_keyboard() const {
    return state_->ui && ImGui::GetIO().WantCaptureKeyboard;
}

Result<void> Renderer::warm_up() {
    return state_->run([&]() -> Result<void> {
        // Two triangles, one of them fading, so that the driver compiles the shaders of both even without any piece.
        const glm::vec3 corners[] = {{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}};
        const glm::uvec3 triangle(0, 1, 2);
        const PieceMesh piece{.positions = corners, .triangles = {&triangle, 1}, .exterior_triangles = 1};
        const PieceMesh two[] = {piece, piece};
        const Result<std::vector<PieceHandle>> stand_ins = add_pieces(two);
        if (!stand_ins) return stand_ins.error();

        const LineVertex line[] = {{{0.0f, 0.0f, 0.0f}}, {{1.0f, 0.0f, 0.0f}}};
        const Sphere sphere{};
        const Scene scene{.lines = line, .spheres = {&sphere, 1}, .spheres_cast_shadows = true};
        const Format format = state_->swapchain ? state_->swapchain->format() : Format::rgba8_unorm;
        const Result<void> drawn = guarded([&]() -> Result<void> {
            if (Result<void> faded = state_->pieces.fade({&stand_ins->back(), 1}, 0.5f); !faded) return faded;
            Scene drawn_scene = scene;
            for (const bool materials : {false, true}) {
                drawn_scene.materials = materials;
                if (!materials || !state_->material_sets.empty())
                    (void)state_->draw_off_screen(drawn_scene, {format, {16, 16}, state_->window_scale(scene)});
            }
            return {};
        });
        state_->invalidate_shadow_map();
        const Result<void> removed = state_->pieces.remove(*stand_ins);
        return drawn ? removed : drawn;
    });
}

const std::vector<PassTime>& Renderer::timings() const {
    return state_->timings;
}

const FrameStats& Renderer::stats() const {
    return state_->stats;
}

const std::string& Renderer::graph_dot() const {
    return state_->dot;
}

} // namespace brittle::engine
