// What the studio shows: a mesh, as in its file and as on the stage, or a scene of several objects, ready to stand.
// Immutable, so that the window and its workers can share it.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/render/piece_batch.h"
#include "engine/render/renderer.h"
#include "fracture/mesh/triangle_tree.h"
#include "tools/brittle/stage/mesh_looks.h"
#include "tools/brittle/stage/stage.h"
#include "tools/scenario/recipe/input.h"
#include "tools/scenario/run/scene.h"
#include "tools/scenario/run/scene_cache.h"
#include "tools/scenario/run/stage_placement.h"

namespace brittle::tools {

struct Hit {
    glm::dvec3 point{0.0}; // on the stage, m
    double distance = 0.0; // from the eye, m
};

class Object {
  public:
    // Loads and prepares the mesh or the scene of the options. Throws a Failure, also if the one mesh is not closed, and
    // with exit_interrupted soon after `cancelled` answers true.
    // `progress` is called with shares from 0 to 1 while a scene is prepared.
    // `earlier`: the object before an edit, of which a scene takes what did not change; or null.
    [[nodiscard]] static std::shared_ptr<const Object> load(const FractureOptions& options,
                                                            const std::function<void(double)>& progress = {},
                                                            const Object* earlier = nullptr,
                                                            const std::function<bool()>& cancelled = {});
    // As load(), but does not prepare the objects of a scene: it can be shown, and not stand.
    [[nodiscard]] static std::shared_ptr<const Object> open(const FractureOptions& options,
                                                            const std::function<bool()>& cancelled = {});
    // Returns the mesh at its place in another world.
    [[nodiscard]] std::shared_ptr<const Object> placed_for(const WorldOptions& world) const;
    // Returns a scene with its objects at the places of a recipe; null where the recipe differs in more than places.
    [[nodiscard]] std::shared_ptr<const Object> placed_as(const FractureOptions& options) const;
    // False for a scene of open(), and for one in which placed_as() turned an object that is held at its lowest part:
    // load() prepares it.
    [[nodiscard]] bool is_prepared() const;
    Object(const Object&) = delete;
    Object& operator=(const Object&) = delete;

    [[nodiscard]] const std::string& name() const { return file_.name; } // "scene" for a scene
    // The scene, and its objects without payloads; none for a mesh. A scene has no sites, and no mesh().
    [[nodiscard]] bool is_scene() const { return scene_.has_value(); }
    [[nodiscard]] const LoadedScene& scene() const { return *scene_; } // precondition: is_scene()
    [[nodiscard]] std::span<const PreparedObject> parts() const { return parts_; }
    [[nodiscard]] const SceneMeshes& meshes() const { return meshes_; } // of a scene of open()
    // The object of a scene whose mesh a ray meets first, of those for which `skips` is false. `direction` is a unit
    // vector. All triangles are tested: for a click.
    [[nodiscard]] std::optional<uint32_t> object_along(const glm::dvec3& from, const glm::dvec3& direction,
                                                       const std::function<bool(uint32_t object)>& skips) const;
    [[nodiscard]] const fracture::Box& home() const { return home_; } // what the camera looks at, on the stage

    [[nodiscard]] size_t triangles() const { return triangles_; }         // of the mesh, or of all objects
    [[nodiscard]] const fracture::Box& extent() const { return extent_; } // of the file's mesh, or of all objects, m

    [[nodiscard]] const Input& file() const { return file_; }                              // without sites
    [[nodiscard]] const fracture::TriangleMesh& mesh() const { return stage_.model.mesh; } // on the stage
    // The batch of mesh(), in the form that the renderer draws; empty for a scene, whose pieces are drawn.
    [[nodiscard]] const engine::PieceBatch& batch() const { return batch_; }
    // Of mesh(), with the image for fracture surfaces of the recipe that was loaded; null without.
    [[nodiscard]] const std::shared_ptr<const MeshLooks>& looks() const { return stage_.looks; }
    // Sentences for people about looks that are not shown.
    [[nodiscard]] const std::vector<std::string>& look_notes() const { return look_notes_; }
    // See overlap_of(). Empty for a mesh that was united.
    [[nodiscard]] const std::string& overlap() const { return overlap_; }
    [[nodiscard]] double import_milliseconds() const { return file_.import_milliseconds; }

    // Returns sites for the mesh on the stage. Computed as by placed_on_stage(), so that the pieces equal those of
    // `brittle render`.
    [[nodiscard]] SiteSet sites(const FractureOptions& options) const;
    // Returns mesh and sites on the stage, for break_input().
    [[nodiscard]] Input with_sites(const FractureOptions& options) const;

    [[nodiscard]] const StagePlacement& placement() const { return placement_; }
    [[nodiscard]] glm::dvec3 to_stage(const glm::dvec3& p) const { return placement_.to_stage(p); }
    [[nodiscard]] glm::dvec3 to_file(const glm::dvec3& p) const { return placement_.to_file(p); }
    [[nodiscard]] double scale() const { return placement_.scale; } // metres on the stage per metre of the file

    // Returns the first intersection of a ray with the surface, from outside or inside. `direction` is a unit vector.
    [[nodiscard]] std::optional<Hit> first_hit(const glm::dvec3& from, const glm::dvec3& direction) const;
    // Returns the point where that ray leaves the solid after a hit; the hit itself if it does not.
    [[nodiscard]] Hit exit_after(const Hit& hit, const glm::dvec3& direction) const;

  private:
    Object(Input file, std::string overlap, const WorldOptions& world,
           std::shared_ptr<const engine::MaterialSet> materials);
    Object(LoadedScene scene, std::vector<PreparedObject> parts);
    using Prepare = std::function<std::vector<PreparedObject>(LoadedScene&, SceneCache&)>;
    static std::shared_ptr<Object> load_scene(const FractureOptions& options, const Host& host, const Object* earlier,
                                              const Prepare& prepare);

    Input file_, stage_;
    std::string overlap_;
    std::shared_ptr<const engine::MaterialSet> materials_; // of the file; or null
    std::vector<std::string> look_notes_;
    WorldOptions world_;
    StagePlacement placement_;
    fracture::TriangleTree tree_;
    engine::PieceBatch batch_;
    fracture::Box home_, extent_;
    size_t triangles_ = 0;
    std::optional<LoadedScene> scene_;
    std::vector<PreparedObject> parts_; // empty: not prepared
    SceneMeshes meshes_;
    std::shared_ptr<SceneCache> cache_; // used by one load at a time
    std::string but_places_;            // the recipe that the scene was loaded for, without the places
    std::vector<glm::dvec3> turned_;    // by object: the rotation with which it was prepared
};

// The objects of a scene with payloads of their own, for Stage::stand(); none for a mesh. On any thread.
[[nodiscard]] std::vector<PreparedObject> parts_of(const Object& object, const engine::Renderer& renderer,
                                                   uint32_t threads);

} // namespace brittle::tools
