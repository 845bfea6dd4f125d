// Export of a running simulation to files: the pieces as blows have cut them so far, either as they lie or where they
// were cut. docs/files.md describes the files.
//
//     Snapshot state = snapshot(simulation, fragments);             // between two steps; microseconds per piece
//     write_state({.output = "rubble.glb"}, PiecesAs::they_lie, recipe, source, state);   // on any thread
//
// Files have the coordinates of the mesh's file, by the inverse of placement_on_stage(); metres. The file of a scene has
// those of the world.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "fracture/pieces/fragments.h"
#include "physics/cutting/solid_piece.h"
#include "physics/world/world.h"
#include "tools/scenario/recipe/piece_export.h"
#include "tools/scenario/run/scene.h"
#include "tools/scenario/run/simulation.h"
#include "tools/scenario/run/stage_placement.h"

namespace brittle::tools {

enum class PiecesAs {
    made,    // at the places where they were cut: together they form the mesh
    they_lie // in the poses of the simulation
};

// Parses "made" or "lie", the words of the command line. Throws a Failure with exit_usage for another word.
[[nodiscard]] PiecesAs pieces_as(const std::string& word);

// The pieces on the stage at one moment. Shares immutable data with the simulation.
struct Snapshot {
    struct Piece {
        uint32_t number = 0; // number of the piece in the simulation
        // The solid in a breakable world; otherwise null, and the piece is fragments->pieces[number].
        physics::SolidPtr solid;
        physics::Pose pose; // pose of the centre of mass after the last step
    };
    // Fragments that the simulation was started with; null in a scene, where every piece has a solid.
    std::shared_ptr<const fracture::Fragments> fragments;
    std::vector<Piece> pieces;         // ascending by number, without removed pieces
    std::vector<fracture::Bond> bonds; // unbroken bonds, in the coordinates of the fragments; a and b index `pieces`
};

[[nodiscard]] Snapshot snapshot(const Simulation& simulation, std::shared_ptr<const fracture::Fragments> fragments);

// A snapshot in the coordinates of the file: the pieces where they were cut, and their poses. Piece::site is the number
// of the piece in a breakable world.
struct LivePieces {
    fracture::Fragments fragments;
    std::vector<fracture::PiecePose> poses;
};
[[nodiscard]] LivePieces live_pieces(const Snapshot& state, const StagePlacement& placement);

// Writes a snapshot. `source` is the recipe's mesh with its looks, as load_input() returns it. Returns the files
// written, the one to open first. Throws a Failure: exit_mesh if `source` is not the mesh that was broken,
// exit_interrupted if `cancelled` returns true before writing begins.
std::vector<std::filesystem::path> write_state(const ExportSettings& settings, PiecesAs as,
                                               const FractureOptions& recipe, const Input& source,
                                               const Snapshot& state, const std::function<bool()>& cancelled = {});

// The snapshot of each object of a scene, in their order. Piece numbers are those of the simulation; solids and bonds
// have the object's coordinates, poses the world's. An object of which nothing is left has no pieces.
[[nodiscard]] std::vector<Snapshot> object_snapshots(const Simulation& simulation);

// Writes the pieces of a scene to a GLB file (fracture::ObjectExport): each object by its name and material, and with the
// materials of its file where the scene was loaded with looks; fixed ones without hulls. Returns the number of pieces.
// Throws a Failure.
size_t write_scene_state(const ExportSettings& settings, PiecesAs as, const LoadedScene& scene,
                         const Simulation& simulation);

// The pose of a piece that lies where it was cut, in the world of its object.
[[nodiscard]] fracture::PiecePose made_pose(const physics::Pose& placement, const glm::dvec3& centre_of_mass);

// Throws a Failure with exit_usage where a scene is to be exported to another format than GLB, or piece by piece.
// `output_option`: that of the file.
void check_export_of_scene(const FractureOptions& recipe, const ExportSettings& settings,
                           const std::string& output_option = "--export");

// Returns a text for people: "57 pieces in rubble.glb", "... and 56 more".
[[nodiscard]] std::string written_text(size_t pieces, const std::vector<std::filesystem::path>& files);

} // namespace brittle::tools
