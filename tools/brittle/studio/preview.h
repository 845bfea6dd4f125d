// What a fracture would look like, before it happens: the pieces in their places, cracks on the surface, cells as lines.
// Made on a worker, the newest request only; a bunny of 70,000 triangles at 100 sites takes about 10 ms.
//
//     Preview preview(renderer);
//     preview.request({object, document.recipe(), {}, version});
//     each frame: if (auto shown = preview.take()) renderer.add_pieces(std::move(shown->batch));
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "engine/render/renderer.h"
#include "engine/render/scene.h"
#include "fracture/fracture.h"
#include "tools/brittle/studio/foresight.h"
#include "tools/brittle/studio/object.h"
#include "tools/brittle/studio/worker.h"

namespace brittle::tools {

struct PreviewRequest {
    std::shared_ptr<const Object> object;
    FractureOptions recipe{};
    std::optional<Strike> ghost{};   // a blow that may come, in the coordinates of the file
    std::optional<AimedBlow> blow{}; // at what is breakable and whole still
    std::optional<physics::PlannedCut>
        cut{}; // a blow to one piece, of this number; then object and recipe do not matter
    std::optional<uint32_t> piece{};
    uint64_t version = 0; // of the recipe: with `blow`, an equal one stands there already
    uint64_t key = 0;     // told apart by whoever asks
};

// All on the stage. Nothing in it where the recipe cannot be carried out; `fault` says why.
struct Cracked {
    uint64_t key = 0;
    bool ghost = false;            // of a blow
    std::optional<uint32_t> piece; // that it is the ghost of; cracks are in its frame then, about its centre of mass
    std::vector<glm::dvec3> sites;
    std::vector<uint32_t> idle_sites;       // ascending: nothing of the mesh is nearest to them, so they change nothing
    std::vector<engine::LineVertex> cracks; // a little above the surface, two a line
    std::vector<engine::LineVertex> cells;  // edges of the Voronoi diagram around the mesh; none for strikes
    uint32_t pieces = 0;
    double milliseconds = 0.0; // of the fracture; of a blow, all that it takes
    std::string fault;

    fracture::Fragments fragments;
    std::vector<glm::vec3> positions;
    engine::PieceBatch batch;   // of all pieces, ready to be drawn
    std::vector<uint8_t> stays; // by piece: what does not fall, where only a part breaks
};

class Preview {
  public:
    // What is taken is ready for that renderer, which must outlive it.
    explicit Preview(const engine::Renderer& renderer) : renderer_(renderer) {}

    void request(PreviewRequest request);
    // What was finished since, once.
    [[nodiscard]] std::shared_ptr<Cracked> take();
    // Something is being made, or waits to be taken.
    [[nodiscard]] bool busy() const;

  private:
    [[nodiscard]] std::shared_ptr<Cracked> make(const PreviewRequest& request, const Worker::Cancelled& cancelled);
    void fracture(const PreviewRequest& request, const Worker::Cancelled& cancelled, Cracked& made);
    void foresee_blow(const PreviewRequest& request, const Worker::Cancelled& cancelled, Cracked& made);

    const engine::Renderer& renderer_;
    fracture::Workspace workspace_; // the worker's
    Foresight foresight_;           // likewise
    mutable std::mutex mutex_;
    std::shared_ptr<Cracked> finished_;
    Worker worker_; // last: its destructor waits
};

} // namespace brittle::tools
