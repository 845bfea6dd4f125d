// Preview of a fracture: the pieces in their places, cracks on the surface, cells as lines. Computed on a worker, for
// the newest request only. A bunny of 70,000 triangles at 100 sites takes about 10 ms.
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
    std::optional<Strike> ghost{};   // an aimed strike, in the coordinates of the file
    std::optional<AimedBlow> blow{}; // an aimed blow at a breakable mesh that is still whole
    // A planned cut of the piece `piece`; object and recipe are then ignored.
    std::optional<physics::PlannedCut> cut{};
    std::optional<uint32_t> piece{};
    bool coarse = false;  // rough cuts with few triangles
    uint64_t version = 0; // version of the recipe, by which a simulation made for an earlier `blow` is used again
    uint64_t key = 0;     // key chosen by the caller to identify the request
};

// A finished preview, in the coordinates of the stage. Empty if the recipe cannot be carried out; `fault` then gives
// the reason.
struct Cracked {
    uint64_t key = 0;
    bool ghost = false;            // preview of a strike or blow
    std::optional<uint32_t> piece; // piece that the blow cuts; cracks are then in its frame, around its centre of mass
    std::vector<glm::dvec3> sites;
    // Ascending; sites whose cells contain nothing of the mesh, so that they have no effect.
    std::vector<uint32_t> idle_sites;
    std::vector<engine::LineVertex> cracks; // a little above the surface, two vertices per line
    std::vector<engine::LineVertex> cells;  // edges of the Voronoi diagram around the mesh; none for strikes
    uint32_t pieces = 0;
    double milliseconds = 0.0; // duration of the fracture; for a blow, of the whole prediction
    std::string fault;

    fracture::Fragments fragments;
    std::vector<glm::vec3> positions;
    engine::PieceBatch batch;   // all pieces in the form that the renderer draws
    std::vector<uint8_t> stays; // by piece: 1 for the part that stays in place when only a part breaks
};

class Preview {
  public:
    // Previews are prepared for this renderer, which must outlive the object.
    explicit Preview(const engine::Renderer& renderer) : renderer_(renderer) {}

    void request(PreviewRequest request);
    // Returns the newest finished preview, once; else null.
    [[nodiscard]] std::shared_ptr<Cracked> take();
    // Returns whether a preview is being made or waits to be taken.
    [[nodiscard]] bool busy() const;

  private:
    [[nodiscard]] std::shared_ptr<Cracked> make(const PreviewRequest& request, const Worker::Cancelled& cancelled);
    void fracture(const PreviewRequest& request, const Worker::Cancelled& cancelled, Cracked& made);
    void foresee_blow(const PreviewRequest& request, const Worker::Cancelled& cancelled, Cracked& made);

    const engine::Renderer& renderer_;
    fracture::Workspace workspace_; // used by the worker only
    Foresight foresight_;           // used by the worker only
    mutable std::mutex mutex_;
    std::shared_ptr<Cracked> finished_;
    Worker worker_; // last: its destructor waits
};

} // namespace brittle::tools
