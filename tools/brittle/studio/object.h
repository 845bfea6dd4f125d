// The mesh that the studio works on: as it is in its file, and as it stands on the stage. Immutable, so that the window
// and its workers may share one.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "engine/render/piece_batch.h"
#include "fracture/mesh/triangle_tree.h"
#include "tools/brittle/recipe/input.h"
#include "tools/brittle/run/stage_placement.h"

namespace brittle::tools {

struct Hit {
    glm::dvec3 point{0.0}; // on the stage, m
    double distance = 0.0; // from the eye, m
};

class Object {
  public:
    // Reads and prepares the mesh that the options name. Throws a Failure, also where it is not closed.
    [[nodiscard]] static std::shared_ptr<const Object> load(const FractureOptions& options);
    // The same mesh where another world wants it.
    [[nodiscard]] std::shared_ptr<const Object> placed_for(const WorldOptions& world) const;
    Object(const Object&) = delete;
    Object& operator=(const Object&) = delete;

    [[nodiscard]] const std::string& name() const { return file_.name; }
    [[nodiscard]] const Input& file() const { return file_; }                              // without sites
    [[nodiscard]] const fracture::TriangleMesh& mesh() const { return stage_.model.mesh; } // on the stage
    [[nodiscard]] const engine::PieceBatch& batch() const { return batch_; } // the same, ready to be drawn
    [[nodiscard]] double import_milliseconds() const { return file_.import_milliseconds; }

    // Sites for the mesh on the stage, with the arithmetic of placed_on_stage(): pieces equal those of `brittle render`.
    [[nodiscard]] SiteSet sites(const FractureOptions& options) const;
    // For break_input().
    [[nodiscard]] Input with_sites(const FractureOptions& options) const;

    [[nodiscard]] const StagePlacement& placement() const { return placement_; }
    [[nodiscard]] glm::dvec3 to_stage(const glm::dvec3& p) const { return placement_.to_stage(p); }
    [[nodiscard]] glm::dvec3 to_file(const glm::dvec3& p) const { return placement_.to_file(p); }
    [[nodiscard]] double scale() const { return placement_.scale; } // metres on the stage by those in the file

    // Where a ray first meets the surface, from outside or inside. The direction is a unit one.
    [[nodiscard]] std::optional<Hit> first_hit(const glm::dvec3& from, const glm::dvec3& direction) const;
    // Where the same ray leaves the solid again after a hit; the hit itself if it does not.
    [[nodiscard]] Hit exit_after(const Hit& hit, const glm::dvec3& direction) const;

  private:
    Object(Input file, const WorldOptions& world);

    Input file_, stage_;
    WorldOptions world_;
    StagePlacement placement_;
    fracture::TriangleTree tree_;
    engine::PieceBatch batch_;
};

} // namespace brittle::tools
