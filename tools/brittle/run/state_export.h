// What one sees, into files: the pieces of a running simulation as live blows have cut them, where they lie or where they
// were cut. docs/files.md tells what the files hold.
//
//     Snapshot state = snapshot(simulation, fragments);             // between two steps; microseconds a piece
//     write_state({.output = "rubble.glb"}, PiecesAs::they_lie, recipe, source, state);   // on any thread
//
// Coordinates of files are those of the mesh's file, as placement_on_stage() leads back to them; metres.
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
#include "tools/brittle/recipe/piece_export.h"
#include "tools/brittle/run/simulation.h"
#include "tools/brittle/run/stage_placement.h"

namespace brittle::tools {

enum class PiecesAs {
    made,    // all where they were cut: they make up the mesh
    they_lie // turned and moved as the simulation left them
};

// "made" or "lie", as on the command line; else a Failure with exit_usage.
[[nodiscard]] PiecesAs pieces_as(const std::string& word);

// The pieces of a moment, on the stage. Shares what does not change with the simulation.
struct Snapshot {
    struct Piece {
        uint32_t number = 0;     // in the simulation
        physics::SolidPtr solid; // of what is cut anew; else null, and it is fragments->pieces[number]
        physics::Pose pose;      // of its centre of mass, after the last step
    };
    std::shared_ptr<const fracture::Fragments> fragments; // that the simulation was started with
    std::vector<Piece> pieces;                            // by number; those that are gone are not there
    std::vector<fracture::Bond> bonds; // that hold, in the coordinates of the fragments; a and b index `pieces`
};

[[nodiscard]] Snapshot snapshot(const Simulation& simulation, std::shared_ptr<const fracture::Fragments> fragments);

// A snapshot in the coordinates of the file: pieces where they were cut, and how they lie. Piece::site is the number of the
// piece where it was cut anew.
struct LivePieces {
    fracture::Fragments fragments;
    std::vector<fracture::PiecePose> poses;
};
[[nodiscard]] LivePieces live_pieces(const Snapshot& state, const StagePlacement& placement);

// `source` is the recipe's mesh with its looks, as load_input() gives it; it must be the one that was broken: else a Failure
// with exit_mesh. The files written, the one to open first. Throws a Failure; with exit_interrupted where `cancelled` says
// so before writing begins.
std::vector<std::filesystem::path> write_state(const ExportSettings& settings, PiecesAs as,
                                               const FractureOptions& recipe, const Input& source,
                                               const Snapshot& state, const std::function<bool()>& cancelled = {});

// For people: "57 pieces in rubble.glb", "... and 56 more".
[[nodiscard]] std::string written_text(size_t pieces, const std::vector<std::filesystem::path>& files);

} // namespace brittle::tools
