// The mesh files and shapes of a scene, each read once, and again once it has changed on disk.
//
// For one thread.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <glm/mat3x3.hpp>

#include "fracture/io/import.h"
#include "fracture/mesh/mesh.h"
#include "tools/scenario/recipe/host.h"
#include "tools/scenario/recipe/input.h"

namespace brittle::tools {

class MeshFiles {
  public:
    // The mesh of an object as its file has it, with its attributes and materials; valid until the next call of a member.
    // Throws a Failure.
    const fracture::Model& model_of(const SceneObject& object);
    // The materials of that model, decoded once for all objects of a file; null without any. Notes for people about what
    // is not shown are added once. Throws a Failure.
    std::shared_ptr<const engine::MaterialSet> materials_of(const SceneObject& object, const LooksMaker& maker,
                                                            std::vector<std::string>& notes);
    // The images of that model, as its file has them; null without any. Throws a Failure.
    std::shared_ptr<const std::vector<fracture::Image>> images_of(const SceneObject& object);
    // The nodes of a glTF file; valid until the next call of a member. Throws a Failure.
    const fracture::MeshScene& scene_of(const std::string& file) { return content_of(file).scene; }
    // Index of an object's mesh in its file; nothing where the object is no node. Throws a Failure.
    std::optional<uint32_t> index_of(const SceneObject& object);
    void keep_only(const std::set<std::string>& files); // forgets all others

  private:
    struct Looks {
        std::shared_ptr<const std::vector<fracture::Image>> images; // of the file, once somebody asked
        bool is_decoded = false;
        std::shared_ptr<const engine::MaterialSet> materials;
    };
    struct Pieces { // a glTF file whose nodes are pieces
        std::string stamp;
        fracture::Model model; // without images
    };
    struct Whole { // a file without nodes, or a shape
        std::string stamp;
        fracture::Model model; // without images once `looks` has them
        Looks looks;
    };
    struct Content { // a glTF file of which objects name nodes
        std::string stamp;
        fracture::MeshScene scene;               // without images once `looks` has them
        std::map<std::string, uint32_t> mesh_of; // by name of the node
        Looks looks;
    };

    Whole& whole_of(const std::string& file);
    Content& content_of(const std::string& file);
    // The looks of an object's file, with its images.
    Looks& looks_of(const SceneObject& object);
    const fracture::Model& pieces_of(const std::string& file);
    static uint32_t mesh_in(const Content& content, const SceneObject& object); // throws a Failure

    std::map<std::string, Content> nodes_;
    std::map<std::string, Whole> whole_;
    std::map<std::string, Pieces> pieces_;
    fracture::Model node_; // of model_of()
};

// Gives a model that was transformed the normals of its surface, and where it was mirrored, and its triangles turned, the
// attributes of the turned corners.
void turn_attributes(fracture::Model& model, const glm::dmat3& linear);

// Why a mesh cannot be broken, whatever it looks like; empty where it can.
[[nodiscard]] std::string fault_of(const fracture::TriangleMesh& mesh);

// Differs between two versions of a file, by its size and the time of its last change; empty for a shape, and where
// there is no file.
[[nodiscard]] std::string stamp_of(const std::string& file);

} // namespace brittle::tools
