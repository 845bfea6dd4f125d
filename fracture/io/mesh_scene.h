// The content of a glTF file as a scene: nodes that show meshes, each under a transform.
//
//     Result<MeshScene> scene = import_scene("level.glb");                 // import.h
//     for (const SceneNode& node : scene->nodes)
//         place(node.name, scene->meshes[node.mesh].mesh, node.world);     // p becomes node.world * p
//
// Nodes that show one mesh are its instances: they have one entry of `meshes`.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>

#include "fracture/io/model.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

struct SceneMesh {
    std::string name{};  // may be empty
    TriangleMesh mesh{}; // in the coordinates of its nodes, not of the scene; welded, with at least one triangle
    std::vector<std::string> materials{}; // names, each once, in the order of the primitives
    std::string extras{};                 // JSON; empty where the mesh has none
    // Where the scene was read with looks: the attributes of the corners of `mesh`, in their order, and material_of,
    // into MeshScene::looks. All else is empty.
    Model looks{};
};

struct SceneNode {
    // Unique in the scene: the name of the node, or where it has none of its mesh, or "node K". From the second node of
    // a name on, a number follows: "Vase", "Vase 2".
    std::string name{};
    uint32_t mesh = 0;     // into MeshScene::meshes
    glm::dmat4 world{1.0}; // from the coordinates of the mesh to those of the file; affine and finite
    std::string extras{};  // JSON; empty where the node has none
};

struct MeshScene {
    std::vector<SceneNode> nodes{};  // depth first, in the order of the file
    std::vector<SceneMesh> meshes{}; // by their first nodes; each is the mesh of a node
    // Sentences for a reader about nodes that were left out: their meshes have no triangles, or by their names they are
    // collision shapes for Unreal (UCX_ ...) or Godot (... -convcolonly).
    std::vector<std::string> notes{};
    // Where the scene was read with looks: materials, textures and images of the file, and notes about those that could
    // not be read. All else is empty.
    Model looks{};
};

// Returns a mesh with its attributes, materials and textures, without the images of the file.
[[nodiscard]] Model model_of(const MeshScene& scene, uint32_t mesh);

// Returns whether any triangle has a material, or any corner a colour.
[[nodiscard]] bool has_looks(const Model& model);

// Appends the mesh of `other` with the attributes of its corners. Its materials must be those of `model`.
void append_mesh(Model& model, const Model& other);

} // namespace brittle::fracture
