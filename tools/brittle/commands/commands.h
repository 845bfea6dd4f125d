// One function a command of the `brittle` program. Each returns the exit code or throws a Failure.
#pragma once

#include <cstdint>
#include <string>

#include "fracture/doctor/repair.h"
#include "tools/brittle/profile/scenario.h"
#include "tools/brittle/recipe/input.h"
#include "tools/brittle/recipe/piece_export.h"
#include "tools/brittle/recipe/view_options.h"

namespace brittle::tools {

struct FractureCommand {
    FractureOptions fracture;
    ExportSettings files;
    std::string classify = "cpu"; // auto, cpu or gpu
    std::string report;           // empty: none
};

// The pieces of the last moment; nowhere without an output.
struct StateExport {
    ExportSettings files;
    std::string as = "lie"; // or made: see pieces_as()
};

struct RenderCommand {
    FractureOptions fracture;
    ViewOptions view;
    std::string output = "frame_%04d.png"; // empty: no pictures
    uint32_t every = 10;                   // write each so many-th frame
    std::string video;                     // a file of all frames, by ffmpeg; empty: none
    std::string record;                    // a replay log; empty: none
    std::string ids;   // where each picture's piece numbers go (id_picture.h), named like output; empty: nowhere
    std::string graph; // where the frame graph goes, as DOT; empty: nowhere
    std::string classify = "cpu"; // auto, cpu or gpu
    StateExport pieces;
};

struct ReplayCommand {
    std::string log;
    std::string pictures; // as RenderCommand::output; empty: none
    uint32_t every = 10;
    std::string video;    // empty: none
    uint32_t threads = 0; // of the fracture; 0: one a core
    StateExport pieces;
    ViewOptions view;
};

struct DemoCommand {
    FractureOptions fracture;
    ViewOptions view;
    std::string record;            // a replay log of the last break; empty: none
    double ui_scale = 0.0;         // of text and panels; 0: as the display wants it
    std::string classify = "auto"; // auto, cpu or gpu
};

struct ProfileCommand {
    FractureOptions fracture;
    ViewOptions view;
    ProfilePlan plan;    // --scenarios, and what of it the command line outdoes
    ScenarioGroup lists; // --meshes, --counts, --classify
    bool json = false;
    std::string output;     // where the JSON goes besides; empty: nowhere
    std::string csv;        // likewise
    std::string trace;      // a time line; empty: none
    std::string compare;    // a profile to compare with; empty: none
    double threshold = 1.1; // ratios of medians and minima above this are slower
};

struct InspectCommand {
    std::string mesh;
    bool json = false;
    std::string marks;   // GLB file; empty: none
    std::string picture; // PNG file; empty: none
    ViewOptions view;    // of the picture
};

struct RepairCommand {
    std::string mesh;
    std::string output; // its ending says the format
    fracture::RepairSettings settings;
};

// Both return exit_mesh where fracture would refuse the mesh, the second for what was written.
int run_inspect(const InspectCommand& command);
int run_repair(const RepairCommand& command);
int run_fracture(const FractureCommand& command);
int run_render(const RenderCommand& command);
// Returns exit_differs where a state differs from the recorded one.
int run_replay(const ReplayCommand& command);
int run_demo(const DemoCommand& command);
// Returns exit_slower where --compare finds something slower.
int run_profile(const ProfileCommand& command);

} // namespace brittle::tools
